"""Joints that follow others, in the files of other simulators."""

import xml.etree.ElementTree as ET

import pytest
import yaml
from arm_urdfs import LIMIT, joint, link, write_urdf

from soft_gripper.extras.export.mjcf import to_mjcf
from soft_gripper.scenario.scenario_file import load_scenario
from studies.engines.export_tips import differences

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
