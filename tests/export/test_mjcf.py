"""Scenarios in MuJoCo compared with Drake, and what the exported files say."""

import csv
import subprocess
import sys
import xml.etree.ElementTree as ET
from pathlib import Path

import numpy as np
import pytest
from command_line import soft_gripper

from soft_gripper.diagrams.simulation import run_station
from soft_gripper.diagrams.station import make_station
from soft_gripper.export.folder import export_mjcf
from soft_gripper.export.mjcf import to_mjcf
from soft_gripper.scenario.scenario_file import load_scenario

STEPS = ["pressure.steps.all=[60e3, 150e3]"]


def tips_in_drake(scenario):
    """At the end of each step, (steps, F, 3) m in the world."""
    station = make_station(scenario)
    recording = run_station(station)
    plant, context = station.plant, station.plant.CreateDefaultContext()
    ends = (np.arange(scenario.steps) + 1) * scenario.step_duration
    found = []
    for row in np.searchsorted(recording["time"].values, ends - 1e-6):
        plant.SetPositionsAndVelocities(context, recording["plant.state"].values[row])
        found.append([finger.frames[-1].CalcPoseInWorld(context).translation() for finger in station.fingers])
    return np.array(found)


def tips_in_mujoco(scenario, folder):
    """The same, by the loader that is exported, in a process without this package."""
    pytest.importorskip("mujoco")
    export_mjcf(scenario, folder)
    subprocess.run([sys.executable, "-I", folder / "run_mjcf.py"], check=True, cwd=folder, capture_output=True)
    with (folder / "tips.csv").open(newline="") as file:
        rows = np.array(list(csv.reader(file))[1:], dtype=float)
    ends = (np.arange(scenario.steps) + 1) * scenario.step_duration
    at_ends = rows[np.searchsorted(rows[:, 0], ends - 1e-6)]
    fingers = len(make_station(scenario).fingers)
    return at_ends[:, 1 : 1 + 3 * fingers].reshape(-1, fingers, 3)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "overrides", "bar"),
    [
        ("free_bending", STEPS, 5e-6),  # 0.005 mm; the bar is 0.5 mm
        ("three_chambers", ["pressure.steps={all: [60e3], finger::left: [20e3]}"], 5e-6),
        ("box_grasp", ["pressure.steps.all=[50e3, 100e3, 150e3]"], 1.5e-3),
    ],
)
def test_tips_at_rest_are_those_of_drake(tmp_path, name, overrides, bar):
    scenario = load_scenario(name, overrides)
    difference = np.linalg.norm(tips_in_mujoco(scenario, tmp_path) - tips_in_drake(scenario), axis=-1)
    assert difference.max() < bar


def test_springs_friction_and_pressures_are_in_the_file():
    """With all their digits."""
    scenario = load_scenario("box_grasp")
    found = to_mjcf(scenario)
    finger = make_station(scenario).fingers[0].finger
    root = ET.fromstring(found.text)
    joints = [joint for joint in root.iter("joint") if "type" in joint.attrib]
    assert [float(joint.get("stiffness")) for joint in joints[:12]] == finger.stiffness.tolist()
    assert [float(joint.get("damping")) for joint in joints[:12]] == pytest.approx(finger.damping, rel=1e-15)
    gains = [float(part.get("coef")) for part in root.find("tendon")[0]]
    assert gains == finger.pressure_gain.tolist()
    assert found.actuators == ["left_finger", "right_finger"]
    frictions = {pair.get("friction").split()[0] for pair in root.find("contact")}
    assert repr(2 * 0.8 * finger.contact.friction / (0.8 + finger.contact.friction)) in frictions


def test_a_free_body_begins_where_it_does_here():
    key = ET.fromstring(to_mjcf(load_scenario("box_grasp")).text).find("keyframe")[0]
    assert [float(x) for x in key.get("qpos").split()][-7:] == [0, 0, 0.03001, 1, 0, 0, 0]


def test_an_arm_has_its_controllers_and_carries_its_weight():
    found = to_mjcf(load_scenario("bottle_grasp"))
    assert found.actuators[2:] == ["gantry::x", "gantry::z"]
    assert found.arm[0] == 0
    assert 0 < found.arm[1] < 0.005  # m, above where the ram hangs


@pytest.mark.parametrize(
    ("name", "overrides", "part"),
    [
        ("tendon_grasp", [], "left_finger: tendons"),
        ("bottle_grasp", [], "task: the arm stays where the run begins"),
        ("tip_distance_steps", [], "control.set_points: a closed loop; pressures stay 0"),
        ("box_grasp", ["pressure.leaks={all: 0.1}"], "pressure.leaks"),
    ],
)
def test_what_cannot_be_exported_is_named(name, overrides, part):
    assert part in to_mjcf(load_scenario(name, overrides)).left_out


def test_meshes_are_beside_the_file(tmp_path):
    found = export_mjcf(load_scenario("bottle_grasp"), tmp_path)
    (name,) = found.meshes
    assert (tmp_path / "meshes" / name).read_bytes() == found.meshes[name].read_bytes()
    (mesh,) = ET.parse(tmp_path / "scenario.xml").iter("mesh")
    assert mesh.get("file") == name


def test_commands_are_those_of_the_steps(tmp_path):
    export_mjcf(load_scenario("box_grasp", ["pressure.steps={left_finger: [1e3, 2e3], right_finger: [3e3]}"]), tmp_path)
    with (tmp_path / "commands.csv").open(newline="") as file:
        header, *rows = list(csv.reader(file))
    assert header == ["time [s]", "left_finger", "right_finger"]
    assert [list(map(float, row)) for row in rows] == [[0, 1e3, 3e3], [2, 2e3, 3e3], [4, 2e3, 3e3]]


@pytest.mark.slow
def test_the_command(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    done = soft_gripper("export", "tendon_grasp", "--out", "there")
    assert done.code == 0
    assert "not exported: left_finger: tendons" in done.out
    assert {path.name for path in Path("there").iterdir()} == {"scenario.xml", "commands.csv", "run_mjcf.py"}
