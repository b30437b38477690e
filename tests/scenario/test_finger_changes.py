"""Fingers with other parameters than their file's, from a scenario."""

from dataclasses import replace

import pytest
from refusals import refused

from soft_gripper.diagrams.station import make_station
from soft_gripper.fingers.urdf import expand_urdf
from soft_gripper.models import DIRECTORY
from soft_gripper.scenario.finger_changes import configured_finger
from soft_gripper.scenario.scenario_file import changed_scenario, dump_scenario, parse_scenario
from soft_gripper.scenario.schema import FingerConfig


def test_changes_for_all_come_first_and_those_of_the_name_on_top(tapered_finger):
    changes = {"tapered": FingerConfig(width="+10 %"), "all": FingerConfig(width="0.03", shear_factor="0.8")}
    found = configured_finger(tapered_finger, "here", changes)
    assert (found.base.width, found.tip.width) == pytest.approx((0.033, 0.033))
    assert (found.shear_factor, found.tip.thickness) == (0.8, tapered_finger.tip.thickness)


def test_all_cross_sections_change_alike():
    (finger, _) = expand_urdf(DIRECTORY / "grippers/conforming.urdf").fingers
    changes = {"all": FingerConfig(youngs_modulus="-20 %", chamber_width="+5 %")}
    found = configured_finger(finger, "here", changes)
    for part, before in zip(found.cross_sections, finger.cross_sections, strict=True):
        assert part.youngs_modulus == pytest.approx(0.8 * before.youngs_modulus)
        assert part.chamber_width == pytest.approx(1.05 * before.chamber_width)
    assert found.places == finger.places


def test_a_chamber_is_not_put_where_there_is_none():
    (finger, _) = expand_urdf(DIRECTORY / "grippers/conforming.urdf").fingers
    with refused("tip.chamber_width", 8e-3):
        configured_finger(finger, "here", {"all": FingerConfig(chamber_width="8e-3")})


def test_chambers_change_alike():
    (finger,) = expand_urdf(DIRECTORY / "grippers/three_chambers.urdf").fingers
    found = configured_finger(finger, "here", {"all": FingerConfig(chamber_width="+4 %", youngs_modulus="+10 %")})
    for chamber, before in zip(found.chambers, finger.chambers, strict=True):
        assert chamber.width == pytest.approx([1.04 * width for width in before.width])
        assert chamber.thickness == before.thickness
    assert found.base.youngs_modulus == pytest.approx(1.1 * finger.base.youngs_modulus)


def test_the_center_of_chambers_with_places_of_their_own_does_not_change():
    (finger,) = expand_urdf(DIRECTORY / "grippers/three_chambers.urdf").fingers
    with refused("chamber_center", "1e-3"):
        configured_finger(finger, "here", {"all": FingerConfig(chamber_center="1e-3")})


def test_friction_and_nothing_else_changes(tapered_finger):
    found = configured_finger(tapered_finger, "here", {"all": FingerConfig(friction="0.3")})
    assert found.contact == replace(tapered_finger.contact, friction=0.3)
    assert found.links.mass == pytest.approx(tapered_finger.links.mass)


def test_a_finger_may_yield_in_more_ways_than_its_file_says(tapered_finger):
    found = configured_finger(tapered_finger, "here", {"all": FingerConfig(yields="bending sideways twist")})
    assert found == replace(tapered_finger, yields=("bending", "sideways", "twist"))


@pytest.mark.parametrize(
    ("changes", "field", "value"),
    [
        ({"all": FingerConfig(width="wide")}, "width", "wide"),
        ({"all": FingerConfig(yields="bending sideways")}, "yields", "bending sideways"),
        ({"tapered": FingerConfig(length="-1")}, "length", -1.0),
    ],
)
def test_what_is_no_finger_is_refused(tapered_finger, changes, field, value):
    with refused(field, value):
        configured_finger(tapered_finger, "here", changes)


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
