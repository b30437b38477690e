"""The contact scenarios in full: what is touched, what it bears, and what stays."""

from functools import cache
from typing import NamedTuple

import numpy as np
import pytest

from soft_gripper.diagrams.recording import Recording
from soft_gripper.diagrams.simulation import run_station
from soft_gripper.diagrams.station import make_station
from soft_gripper.diagrams.station_parts import Station
from soft_gripper.fingers.kinematics import forward_kinematics
from soft_gripper.runs.scores.poses import held_samples
from soft_gripper.scenario.scenario_file import load_scenario

pytestmark = pytest.mark.slow

GRASPED = {"box_grasp": "box", "irregular_grasp": "irregular"}
WEIGHT = {"box": 0.05 * 9.81, "irregular": 0.06 * 9.81}  # N
LEFT, RIGHT = "left_finger", "right_finger"
SEGMENT = 0.01  # m
TOUCH = 1e-3  # N


class Run(NamedTuple):
    """A scenario that was simulated once, for all tests of this module."""

    name: str
    station: Station
    recording: Recording

    def held(self, signal: str):
        """Samples of every held step, (steps, samples, ...)."""
        return held_samples(self.station.scenario, self.recording, signal)

    def object_path(self):
        """Position of the grasped object, (steps, samples, 3) m."""
        name = GRASPED[self.name]
        start = self.station.plant.GetStateNames().index(f"{name}_{name}_x")
        return self.held("plant.state")[..., start : start + 3]

    def tips(self):
        """Both fingertips at the end of every step, (fingers, steps) m in B, complex."""
        angles = [self.held(f"{finger.name}.sampled_joint_angles")[:, -1] for finger in self.station.fingers]
        return np.array([forward_kinematics(q, SEGMENT).tip for q in angles])


def simulated(name: str, *overrides: str) -> Run:
    station = make_station(load_scenario(name, overrides))
    return Run(name, station, run_station(station))


@cache
def run(name: str) -> Run:
    """The run of a scenario as it is shipped."""
    return simulated(name)


@pytest.fixture(params=GRASPED)
def grasp(request) -> Run:
    return run(request.param)


@pytest.mark.parametrize("name", ["obstructed_inside", "obstructed_outside"])
def test_the_finger_beside_the_obstructed_one_stays_free(name):
    torque, truth = (run(name).held(f"{RIGHT}.{signal}") for signal in ("external_torque", "true_external_torque"))
    assert not truth.any()
    assert np.abs(torque).max() < 5e-4


def test_contact_carries_the_weight(grasp):
    name = GRASPED[grasp.name]
    force = grasp.held(f"{name}.contact_wrench")[..., 3:].mean(axis=1)
    np.testing.assert_allclose(force, np.tile([0, 0, WEIGHT[name]], (13, 1)), atol=0.01 * WEIGHT[name])


def test_both_fingers_press(grasp):
    """Held open by the object, and less so where the lever to it is shorter."""
    for finger in grasp.station.fingers:
        torque = grasp.held(f"{finger.name}.true_external_torque")[-1].mean(axis=0)
        assert torque[0] < -0.05
        assert (np.diff(torque[:-1]) > 0).all()


def test_the_box_is_touched_by_the_tips_alone():
    """A finger that pressure bends meets a flat face with its end: no link but the last two, 15 mm, touches it."""
    for finger in (LEFT, RIGHT):
        touching = run("box_grasp").held(f"{finger}.link_contact_force").mean(axis=1) > TOUCH
        assert not touching[:, :-2].any()
        assert touching[-1].any()
