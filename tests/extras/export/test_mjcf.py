"""What the exported files say."""

import xml.etree.ElementTree as ET
from functools import cache
from pathlib import Path

import numpy as np
import pytest
from command_line import soft_gripper

from soft_gripper.diagrams.simulation import simulate
from soft_gripper.diagrams.station import make_station
from soft_gripper.errors import InputError
from soft_gripper.extras.export import mjcf
from soft_gripper.extras.export.folder import export_mjcf
from soft_gripper.extras.export.mjcf import to_mjcf
from soft_gripper.extras.export.tree import mobilities, tree_depth
from soft_gripper.scenario.scenario_file import load_scenario

exported = cache(lambda name: to_mjcf(load_scenario(name)))  # as shipped
SHORT_PHASES = ("task.phases.close.rest=0.1", "task.phases.lift.rest=0.0")


@pytest.mark.parametrize(("time_step", "tolerance"), [(0.002, 0.05), (0.01, 0.25)])
def test_a_skin_is_as_stiff_in_mujoco_as_in_drake(time_step, tolerance):
    """Force over penetration of every point that carries something, N/m.

    In long steps springs and dampers hold a link back, which is known joint by joint only.
    """
    model = model_of(load_scenario("box_grasp"), time_step)
    half_stiffness = 0.5 * 2e5 * 0.02 * 0.01 / 0.005  # E A / H of the last link, which has half of it
    found = skin_stiffnesses(model, 100e3, "box")
    assert found == pytest.approx([half_stiffness / 4] * 8, rel=tolerance)  # on four points each


@pytest.mark.slow
def test_fingers_that_press_on_each_other_are_as_stiff_as_two_skins():
    """Without a pair, at four points of each of three pairs of links: half of the stiffness of one skin, E A / H."""
    scenario = load_scenario("tip_distance_steps")
    assert not pair_names(to_mjcf(scenario, 0.002))
    found = skin_stiffnesses(model_of(scenario, 0.002), 150e3, "finger")
    assert found == pytest.approx([2e5 * 0.02 * 0.01 / 0.005 / 4 / 2] * 12, rel=0.05)


def model_of(scenario, time_step):
    mujoco = pytest.importorskip("mujoco")
    return mujoco.MjModel.from_xml_string(to_mjcf(scenario, time_step).text)


def pair_names(exported):
    return [pair.get(name) for pair in ET.fromstring(exported.text).find("contact") for name in ("geom1", "geom2")]


def skin_stiffnesses(model, pressure, other):
    """Of every point between a finger and another body that carries something after 2 s."""
    import mujoco

    data, force, found = mujoco.MjData(model), np.zeros(6), []
    mujoco.mj_resetDataKeyframe(model, data, 0)
    data.ctrl[:] = pressure
    mujoco.mj_step(model, data, round(2 / model.opt.timestep))
    for number, contact in enumerate(data.contact):
        mujoco.mj_contactForce(model, data, number, force)
        names = sorted((model.geom(geom).name for geom in contact.geom), key=lambda name: "finger" not in name)
        if "finger" in names[0] and other in names[1] and force[0] > 0.05:
            found.append(-force[0] / contact.dist)
    return found


def test_mobilities_are_those_by_which_mujoco_scales_contacts():
    mujoco = pytest.importorskip("mujoco")
    name = "bottle_grasp"
    model, plant = mujoco.MjModel.from_xml_string(*text_and_meshes(name)), make_station(load_scenario(name)).plant
    for index, mobility in mobilities(plant, {}, 0.0).items():
        name = plant.get_body(index).scoped_name().get_full()
        if name != "WorldModelInstance::WorldBody" and plant.get_body(index).default_mass() > 0:
            assert model.body(name).invweight0[0] == pytest.approx(mobility, rel=1e-6, abs=1e-9), name


def text_and_meshes(scenario):
    found = exported(scenario)
    return found.text, {name: source.read_bytes() for name, source in found.meshes.items()}


def test_springs_friction_and_pressures_are_in_the_file():
    """With all their digits."""
    found = exported("box_grasp")
    finger = make_station(load_scenario("box_grasp")).fingers[0].finger
    root = ET.fromstring(found.text)
    joints = [joint for joint in root.iter("joint") if "type" in joint.attrib]
    assert [float(joint.get("stiffness")) for joint in joints[:12]] == finger.stiffness.tolist()
    assert [float(joint.get("damping")) for joint in joints[:12]] == pytest.approx(finger.damping, rel=1e-15)
    gains = [float(part.get("coef")) for part in root.find("tendon")[0]]
    assert gains == finger.pressure_gain.tolist()
    assert found.actuators == ["left_finger", "right_finger"]
    frictions = {pair.get("friction").split()[0] for pair in root.find("contact")}
    assert repr(2 * 0.8 * finger.contact.friction / (0.8 + finger.contact.friction)) in frictions


def test_an_arm_has_its_controllers_and_carries_its_weight():
    found = exported("bottle_grasp")
    assert found.actuators[2:] == ["gantry::x", "gantry::z"]
    x, z = found.commands.arm[0]
    assert x == 0
    assert 0 < z < 0.005  # m, above where the ram hangs


@pytest.mark.parametrize(
    ("name", "overrides", "part"),
    [
        ("tendon_grasp", [], "left_finger: tendons"),
        ("pick_and_place_box", [], "task: it waits for estimates; the arm stays where the run begins"),
        ("tip_distance_steps", [], "control.set_points: a closed loop; pressures stay 0"),
        ("box_grasp", ["pressure.leaks={all: 0.1}"], "pressure.leaks"),
        ("box_grasp", ["external=[pressure]"], "external: pressure; commands are those of the scenario"),
        ("free_bending", ["models.left_finger.self_contact=true"], "left_finger: self_contact of its fingers"),
    ],
)
def test_what_cannot_be_exported_is_named(name, overrides, part):
    assert part in to_mjcf(load_scenario(name, overrides)).left_out


@pytest.mark.parametrize("time_step", [0.0, -1.0, float("nan"), float("inf")])
def test_a_time_step_is_above_zero(time_step):
    with pytest.raises(InputError, match=r"export: time_step = .*: give a number of seconds above 0"):
        to_mjcf(load_scenario("free_bending"), time_step)


def test_a_soft_object_is_refused():
    pytest.importorskip("soft_gripper.extras.soft")
    with pytest.raises(InputError, match="export: models = 'sponge': is soft; rigid objects can be exported"):
        to_mjcf(load_scenario("pick_and_place_sponge"))


def test_meshes_are_beside_the_file(tmp_path):
    found = export_mjcf(load_scenario("bottle_grasp"), tmp_path)
    (name,) = found.meshes
    assert (tmp_path / "meshes" / name).read_bytes() == found.meshes[name].read_bytes()
    assets = ET.parse(tmp_path / "scenario.xml").find("asset")
    assert [mesh.get("file") for mesh in assets if "file" in mesh.attrib] == [name]
    assert len([mesh for mesh in assets if "vertex" in mesh.attrib]) == 4  # the convex parts that fingers touch


def test_the_arm_moves_as_it_is_commanded_in_drake():
    """Its desired positions, with the velocity and the weight folded in."""
    scenario = load_scenario("bottle_grasp", ["record.truth=none", *SHORT_PHASES])
    found = to_mjcf(scenario).commands
    weight = found.arm[0, 1]
    assert found.arm[found.times < 0.1, 1] == pytest.approx(weight)
    assert found.arm[-1, 1] - weight == pytest.approx(0.08)
    desired = simulate(scenario)["task.desired_state"].values[1:]
    count = min(len(desired), len(found.arm))
    damping_over_stiffness = 2 * scenario.arm.damping_ratio / (2 * np.pi * scenario.arm.frequency)
    folded = desired[:count, 1] + damping_over_stiffness * desired[:count, 3]
    np.testing.assert_allclose(found.arm[:count, 1] - weight, folded, rtol=0, atol=1e-9)


@pytest.mark.slow
def test_the_command(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    done = soft_gripper("export", "tendon_grasp", "--out", "there")
    assert done.code == 0
    assert "not exported: left_finger: tendons" in done.out
    assert {path.name for path in Path("there").iterdir()} == {"scenario.xml", "commands.csv", "run_mjcf.py"}


def _body_depth(element):
    return (element.tag == "body") + max(map(_body_depth, element), default=0)


def test_more_links_on_each_other_than_mujoco_reads_are_refused(monkeypatch):
    mujoco = pytest.importorskip("mujoco")

    def read(depth):
        bodies = depth * "<body><joint/><geom size='1'/>" + depth * "</body>"
        mujoco.MjModel.from_xml_string(f"<mujoco><worldbody>{bodies}</worldbody></mujoco>")

    read(mjcf.MAX_DEPTH)
    with pytest.raises(ValueError, match="DEPTH"):
        read(mjcf.MAX_DEPTH + 1)
    scenario = load_scenario("free_bending")
    depth = tree_depth(make_station(scenario).plant)
    assert depth == _body_depth(ET.fromstring(to_mjcf(scenario).text))
    monkeypatch.setattr(mjcf, "MAX_DEPTH", depth - 1)
    with pytest.raises(InputError, match=f"models = '{depth} links': MuJoCo reads at most {depth - 1} links"):
        to_mjcf(scenario)
