"""The contact scenarios in full: how well the pose and the load of a touched finger are known, and what holds."""

from functools import cache
from typing import NamedTuple

import numpy as np
import pytest

from soft_gripper.diagrams.recording.recording import Recording
from soft_gripper.diagrams.schema.scenario_file import load_scenario
from soft_gripper.diagrams.simulation import run_station
from soft_gripper.diagrams.station import make_station
from soft_gripper.diagrams.station_parts import Station
from soft_gripper.evaluation.paper.held_steps import held_samples
from soft_gripper.evaluation.paper.pose_table import PoseRow, pose_table
from soft_gripper.fingers.kinematics import forward_kinematics

GRASPED = {"box_grasp": "box", "irregular_grasp": "irregular"}
CONTACT = ("obstructed_inside", "obstructed_outside", *GRASPED)
WEIGHT = {"box": 0.05 * 9.81, "irregular": 0.04 * 9.81}  # N


class Run(NamedTuple):
    """A scenario that was simulated once, for all tests of this module."""

    name: str
    station: Station
    recording: Recording
    poses: list[PoseRow]

    def errors(self, sections: int, column: str = "pose_error_mm"):
        """Of every finger and held step, mm."""
        return np.array([getattr(row, column) for row in self.poses if row.sections == sections])

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
        return np.array([forward_kinematics(q, 0.01).tip for q in angles])


def simulated(name: str, *overrides: str) -> Run:
    station = make_station(load_scenario(name, overrides))
    recording = run_station(station)
    return Run(name, station, recording, pose_table(name, station, recording, (1, 2, 3, 4)))


@cache
def run(name: str) -> Run:
    """The run of a scenario as it is shipped."""
    return simulated(name)


@pytest.fixture(params=CONTACT)
def contact(request) -> Run:
    return run(request.param)


@pytest.fixture(params=GRASPED)
def grasp(request) -> Run:
    return run(request.param)


def test_four_sensors_know_the_pose(contact):
    assert contact.errors(4).mean() <= 1.0
    assert contact.errors(4).max() <= 2.5


def test_four_sensors_find_the_tip(contact):
    assert contact.errors(4, "tip_error_mm").mean() <= 2.5


@pytest.mark.parametrize("column", ["pose_error_mm", "tip_error_mm"])
def test_one_sensor_errs_several_times_as_much(contact, column):
    assert contact.errors(1, column).mean() > 5 * contact.errors(4, column).mean()


def test_every_sensor_more_gains(contact):
    errors = np.array([contact.errors(sections) for sections in (1, 2, 3, 4)])
    rounding = 1e-6
    assert np.diff(errors, axis=0).max() <= rounding
    assert np.diff(errors.mean(axis=1)).max() < -0.05


def test_base_torque_is_estimated_within_a_tenth(contact):
    for finger in contact.station.fingers:
        estimated, truth = (
            contact.held(f"{finger.name}.{signal}")[..., 0].mean(axis=1)
            for signal in ("external_torque", "true_external_torque")
        )
        assert (np.abs(estimated - truth) <= np.maximum(0.1 * np.abs(truth), 2e-3)).all()
        assert np.abs(truth).max() > 0.05


def test_contact_carries_the_weight(grasp):
    name = GRASPED[grasp.name]
    force = grasp.held(f"{name}.contact_wrench")[..., 3:].mean(axis=1)
    np.testing.assert_allclose(force, np.tile([0, 0, WEIGHT[name]], (13, 1)), atol=0.01 * WEIGHT[name])


def test_what_is_held_stays(grasp):
    path = grasp.object_path()
    assert np.linalg.norm(path - path[:, :1], axis=-1).max() < 1e-3


def test_both_fingers_press(grasp):
    """Held open by the object, and less so where the lever to it is shorter."""
    for finger in grasp.station.fingers:
        torque = grasp.held(f"{finger.name}.true_external_torque")[-1].mean(axis=0)
        assert torque[0] < -0.05
        assert (np.diff(torque[:-1]) > 0).all()


def test_an_obstructed_finger_bends_both_ways():
    angles, kappa = (
        run("obstructed_inside").held(f"finger.{signal}")[-1].mean(axis=0)
        for signal in ("sampled_joint_angles", "kappa")
    )
    assert angles[0] < -0.01
    assert angles[-1] > 0.01
    assert np.count_nonzero(np.diff(np.sign(angles))) == 1
    assert kappa[0] < -1
    assert kappa[-1] > 1


def test_both_solvers_close_on_the_box_alike():
    """Regularised friction lets each of them creep in its own way, by about 0.1 mm a step; the tips go 16 mm."""
    discrete, continuous = run("box_grasp").tips(), simulated("box_grasp", "plant_config.time_step=0").tips()
    assert np.abs(discrete - discrete[:, :1]).max() > 0.01
    assert np.abs(continuous - discrete).max() < 2e-4
