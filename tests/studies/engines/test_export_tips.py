"""Exported scenarios in MuJoCo compared with Drake, joints that follow included."""

import xml.etree.ElementTree as ET
from pathlib import Path

import numpy as np
import pytest
import yaml
from arm_urdfs import LIMIT, joint, link, write_urdf
from creeping_fingers import FINGER, write_creeping

from soft_gripper.extras.export.mjcf import to_mjcf
from soft_gripper.scenario.model_files import model_path
from soft_gripper.scenario.scenario_file import load_scenario
from studies.engines.export_tips import differences, drake_tips

TRIALS = (0, 4)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "overrides", "bar"),
    [
        ("free_bending", ["pressure.steps.all=[60e3, 150e3]"], 5e-6),  # 0.005 mm; the bar is 0.5 mm
        ("three_chambers", ["pressure.steps={all: [60e3], finger::left: [20e3]}"], 5e-6),
        ("box_grasp", ["pressure.steps.all=[50e3, 150e3]"], 1.5e-3),
        ("turned_box_grasp", ["pressure.steps.all=[50e3, 100e3]"], 1.5e-3),  # fingers that twist
        ("irregular_grasp", ["pressure.steps.all=[100e3]"], 1.5e-3),  # a mesh that is not convex
    ],
)
def test_tips_at_rest_are_those_of_drake(name, overrides, bar):
    pytest.importorskip("mujoco")
    assert differences(load_scenario(name, [*overrides, "record.truth=none"])).max() < bar


@pytest.mark.slow
def test_creep_and_laws_of_the_pressure_are_those_of_drake(tmp_path):
    """Tips at 3 and 6 s of a finger that creeps, and of one with a law; without either they are elsewhere."""
    pytest.importorskip("mujoco")
    creeping = write_creeping(FINGER, tmp_path, 0.3, 2.0)
    plain = Path(model_path(FINGER)).read_text(encoding="utf-8")
    with_law = tmp_path / "law.urdf"
    law = '<pressure_law pressure="-5e4 0 1e5 2e5" effective="-5e4 0 1.2e5 2.6e5"/></finger>'
    with_law.write_text(plain.replace("</finger>", law), encoding="utf-8")
    steps = [
        "pressure.steps.all=[100e3, 100e3]",
        "pressure.settle=2.9",
        "pressure.hold_samples=10",
        "record.truth=none",
    ]
    files = [f"models.left_finger.file={creeping}", f"models.right_finger.file={with_law}"]
    scenario = load_scenario("free_bending", [*steps, *files])
    assert differences(scenario, 0.002).max() < 5e-5  # creep follows angles that are held for 10 ms
    tips, bare = drake_tips(scenario), drake_tips(load_scenario("free_bending", steps))
    assert np.linalg.norm(tips - bare, axis=-1).min() > 5e-3


HOME, MULTIPLIER, OFFSET = 0.3, -0.8, 0.1


@pytest.fixture
def scenario(tmp_path):
    """An arm whose elbow and wrist follow its shoulder, the wrist by way of the elbow; it swings a gripper."""
    follow = f"<mimic joint='shoulder' multiplier='{MULTIPLIER}' offset='{OFFSET}'/>"
    joints = joint("shoulder", "base", "upper") + joint("elbow", "upper", "fore", LIMIT + follow)
    joints += joint("wrist", "fore", "hand", LIMIT + "<mimic joint='elbow'/>")
    write_urdf(tmp_path, "".join(map(link, ("base", "upper", "fore", "hand"))) + joints)
    gripper = {"name": "gripper", "file": "package://soft_gripper/grippers/two_finger.urdf", "parent": "arm::hand"}
    phases = [{"name": "swing", "posture": [HOME + 0.2], "rest": 1.0}]
    described = {
        "description": "swings a gripper",
        "models": [{"name": "arm", "file": "arm.urdf"}, gripper],
        "pressure": {"steps": {"all": [0.0]}},
        "arm": {"model": "arm", "home": [HOME], "frequency": 10, "acceleration": 10},
        "task": {"phases": phases},
        "record": {"truth": "none"},
    }
    (tmp_path / "arm.yaml").write_text(yaml.safe_dump(described))
    return load_scenario(str(tmp_path / "arm.yaml"))


def test_what_follows_is_coupled_and_has_no_controller_in_mjcf(scenario):
    found = to_mjcf(scenario)
    laws = {each.get("joint1"): each for each in ET.fromstring(found.text).findall("equality/joint")}
    assert {name: law.get("joint2") for name, law in laws.items()} == {
        "arm::elbow": "arm::shoulder",
        "arm::wrist": "arm::elbow",
    }
    assert laws["arm::elbow"].get("polycoef") == f"{OFFSET} {MULTIPLIER} 0.0 0.0 0.0"
    assert found.actuators[-1] == "arm::shoulder"
    assert found.commands.arm.shape[1] == 1


@pytest.mark.parametrize("time_step", [0.002, 0.01])
def test_joints_follow_in_mujoco_as_in_drake(scenario, time_step):
    """The tips at the end of the motion; without the couplings the forearm and the hand fall."""
    pytest.importorskip("mujoco")
    assert differences(scenario, time_step).max() < 5e-5  # m, of an arm that reaches 1.4 m
