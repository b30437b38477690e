"""Fingers with other parameters than their file's, from a scenario."""

from dataclasses import replace

import numpy as np
import pytest
from pydrake.common.yaml import yaml_dump
from pydrake.math import RollPitchYaw
from refusals import refused

from soft_gripper.diagrams.station import make_station
from soft_gripper.fingers.finger_element import FingerElement
from soft_gripper.fingers.finger_parts import CreepBranch, PressureLaw, TipLoad
from soft_gripper.fingers.paths import Tendon
from soft_gripper.fingers.urdf import expand_urdf
from soft_gripper.models import DIRECTORY
from soft_gripper.scenario.finger_changes import changed_finger, mounted_finger
from soft_gripper.scenario.scenario_file import changed_scenario, dump_scenario, load_scenario, parse_scenario
from soft_gripper.scenario.schema import ModelConfig


@pytest.fixture(scope="module")
def chambered_finger():
    (finger,) = expand_urdf(DIRECTORY / "grippers/three_chambers.urdf").fingers
    return finger


def test_changes_for_all_come_first_and_those_of_the_name_on_top(tapered_finger):
    changes = {"tapered": {"width": "+10 %"}, "all": {"width": "0.03", "shear_factor": "0.8"}}
    mounted = mounted_finger(FingerElement(tapered_finger, "palm"), "here", changes)
    changed = mounted.finger
    assert (changed.base.width, changed.tip.width) == pytest.approx((0.033, 0.033))
    assert (changed.shear_factor, changed.tip.thickness) == (0.8, tapered_finger.tip.thickness)
    assert mounted.rpy == (0.0, 0.0, 0.0)


def test_all_cross_sections_change_alike():
    (finger, _) = expand_urdf(DIRECTORY / "grippers/conforming.urdf").fingers
    changed = changed_finger(finger, "here", {"youngs_modulus": "-20 %", "chamber_width": "+5 %"})
    for part, before in zip(changed.cross_sections, finger.cross_sections, strict=True):
        assert part.youngs_modulus == pytest.approx(0.8 * before.youngs_modulus)
        assert part.chamber_width == pytest.approx(1.05 * before.chamber_width)
    assert changed.places == finger.places


def test_a_chamber_is_not_put_where_there_is_none():
    (finger, _) = expand_urdf(DIRECTORY / "grippers/conforming.urdf").fingers
    with refused("tip.chamber_width", 8e-3):
        changed_finger(finger, "here", {"chamber_width": "8e-3"})


def test_chambers_change_alike(chambered_finger):
    changes = {"chambers.width": "+4 %", "youngs_modulus": "+10 %"}
    changed = changed_finger(chambered_finger, "here", changes)
    for chamber, before in zip(changed.chambers, chambered_finger.chambers, strict=True):
        assert chamber.width == pytest.approx([1.04 * width for width in before.width])
        assert chamber.thickness == before.thickness
    assert changed.base.youngs_modulus == pytest.approx(1.1 * chambered_finger.base.youngs_modulus)


@pytest.mark.parametrize(
    ("key", "path"),
    [
        ("chamber_width", "chambers.width"),
        ("chamber_thickness", "chambers.thickness"),
        ("chamber_center", "chambers.x"),
    ],
)
def test_the_chamber_of_every_section_is_that_of_chambers(chambered_finger, key, path):
    changed, same = (changed_finger(chambered_finger, "here", {name: "+4 %"}) for name in (key, path))
    assert changed == same != chambered_finger


def test_a_finger_may_yield_in_more_ways_than_its_file_says(tapered_finger):
    changed = changed_finger(tapered_finger, "here", {"yields": "bending sideways twist"})
    assert changed == replace(tapered_finger, yields=("bending", "sideways", "twist"))


@pytest.mark.parametrize(
    ("changes", "field", "value"),
    [
        ({"width": "wide"}, "width", "wide"),
        ({"yields": "bending sideways"}, "yields", "bending sideways"),
        ({"length": "-1"}, "length", -1.0),
        ({"length": "-100 %"}, "length", 0.0),
        ({"tip_load.mass": "0.1"}, "tip_load.mass", "0.1"),
        ({"tendons.stiffness": "+10 %"}, "tendons.stiffness", "+10 %"),
    ],
)
def test_what_is_no_finger_is_refused(tapered_finger, changes, field, value):
    with refused(field, value) as caught:
        changed_finger(tapered_finger, "here", changes)
    assert str(caught.value).startswith("here: ")


def test_a_tilt_is_an_angle_on_top_of_that_of_the_file(tapered_finger):
    mounted = FingerElement(tapered_finger, "palm", rpy=(0.1, 0.2, 0.3))
    tilted = mounted_finger(mounted, "here", {"all": {"tilt": "0.05"}})
    turns = [RollPitchYaw(finger.rpy).ToRotationMatrix() for finger in (mounted, tilted)]
    np.testing.assert_allclose((turns[0].inverse() @ turns[1]).ToAngleAxis().angle(), 0.05, atol=1e-12)
    with refused("tilt", "+10 %"):
        mounted_finger(mounted, "here", {"all": {"tilt": "+10 %"}})


@pytest.mark.parametrize(
    ("path", "part"),
    [
        ("creep.time", (CreepBranch(0.1, 0.3), CreepBranch(0.1, 3.0))),
        ("tip_load.mass", TipLoad(0.05, 0.01, 0.0)),
        ("pressure_law.effective", PressureLaw((0.0, 1e5), (0.0, 2e5))),
        ("tendons.stiffness", (Tendon("wire", (0.0,), (0.0,), stiffness=2e3),)),
    ],
)
def test_a_part_changes_that_the_finger_has(tapered_finger, path, part):
    name, _, field = path.partition(".")
    changed = changed_finger(replace(tapered_finger, **{name: part}), "here", {path: "+10 %"})
    parts = zip(*(each if isinstance(each, tuple) else (each,) for each in (getattr(changed, name), part)), strict=True)
    for new, old in parts:
        np.testing.assert_allclose(getattr(new, field), 1.1 * np.array(getattr(old, field)))


@pytest.mark.parametrize(
    ("key", "path"),
    [
        ("models.gripper.fingers.all.friction", "contact.friction"),
        ("models.gripper.fingers.left_finger.hydroelastic_modulus", "contact.hydroelastic_modulus"),
        ("nominal.youngs_modulus", "nominal.finger.youngs_modulus"),
        ("nominal.length", "nominal.finger.length"),
        ("nominal.finger.tilt", "nominal.finger.tilt"),
        ("youngs_modulus", "nominal.finger.youngs_modulus"),
    ],
)
def test_a_key_that_is_no_path_is_refused_with_the_one_that_is(key, path):
    with refused(key.replace("gripper", "0").replace(".0", "[0]"), "0.3") as caught:
        load_scenario("box_grasp", [f"{key}='0.3'"])
    assert path in str(caught.value)


def test_a_path_is_one_key_or_several(tmp_path):
    """In a file, with --set on top, and in what is dumped."""
    path = tmp_path / "scenario.yaml"
    file = DIRECTORY / "grippers/two_finger.urdf"
    path.write_text(
        f"models: [{{name: g, file: {file}, fingers: {{all: {{tip.width: 0.02, base: {{width: 0.02}}}}}}}}]"
    )
    scenario = load_scenario(path, ["models.g.fingers.all.tip.width=+5 %"])
    assert scenario.models[0].fingers == {"all": {"base.width": "0.02", "tip.width": "+5 %"}}
    assert parse_scenario(path, dump_scenario(scenario)) == scenario
    again = ModelConfig("g", str(file), fingers={"all": {"tip": {"width": "+5 %"}, "base.width": 0.02, "length": None}})
    assert again.fingers == scenario.models[0].fingers
    plain = load_scenario(path, ["models.g.fingers.all.tip.width=null", "models.g.fingers.all.base.width=null"])
    assert plain.models[0].fingers == {"all": {}}


def test_a_recording_has_its_changes_whose_keys_were_others(tmp_path):
    """As 0.2 wrote them; a scenario file with such a key is refused."""
    former = {
        "friction": "contact.friction",
        "hydroelastic_modulus": "contact.hydroelastic_modulus",
        "dissipation": "contact.dissipation",
        "tendon_stiffness": "tendons.stiffness",
        "tendon_friction": "tendons.friction",
        "tendon_slack": "tendons.slack",
        "chamber_width": "chamber_width",
        "tilt": "tilt",
    }
    nominal = {"width": "+1 %", "sensor_spacing": "0.018"}
    document = {
        "models": [{"name": "g", "file": "g.urdf", "fingers": {"all": dict.fromkeys(former, "+2 %")}}],
        "nominal": {**nominal, "creep": False},
    }
    scenario = parse_scenario(tmp_path / "recording.nc", yaml_dump(document))
    assert scenario.models[0].fingers == {"all": dict.fromkeys(former.values(), "+2 %")}
    assert (scenario.nominal.finger, scenario.nominal.creep) == (nominal, False)
    assert parse_scenario(tmp_path / "recording.nc", dump_scenario(scenario)) == scenario


def test_a_scenario_keeps_the_changes_and_the_station_has_them(tmp_path):
    key = "models.gripper.fingers.right_finger.youngs_modulus"
    scenario = changed_scenario("box_grasp", {key: 3e5})
    again = parse_scenario(tmp_path / "scenario.yaml", dump_scenario(scenario))
    left, right = (finger.finger for finger in make_station(again).fingers)
    assert right.base.youngs_modulus == right.tip.youngs_modulus == 3e5
    assert left.base.youngs_modulus == 2.67e5


@pytest.mark.parametrize(
    ("model", "known"), [("gripper", "known: all, left_finger, right_finger"), ("box", "known: none")]
)
def test_fingers_that_are_not_there_are_named(model, known):
    with refused("fingers", "thumb") as caught:
        make_station(changed_scenario("box_grasp", {f"models.{model}.fingers.thumb.width": 0.02}))
    assert known in caught.value.expected
