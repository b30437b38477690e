"""A finger's offsets, found again while it is free; and warnings where a recording leaves what was fitted."""

from dataclasses import replace

import numpy as np
import pytest
from refusals import refused

from soft_gripper.extras.hardware.finger_logs import FingerLog
from soft_gripper.extras.hardware.fitted_range import disagreement_warnings, extrapolation_warnings
from soft_gripper.extras.hardware.replay.finger_estimation import zeroed_log
from soft_gripper.fingers.statics import resting_angles
from soft_gripper.sensors.sensor_layout import SensorLayout

OFFSETS = np.array([0.01, -0.02, 0.0, 0.005])
TURNED = np.column_stack([[[0.0, 0.0, -1.0], [0.0, 1.0, 0.0], [1.0, 0.0, 0.0]], np.zeros(3)])  # x of B is up


@pytest.fixture
def layout(shipped_finger):
    return SensorLayout(shipped_finger, 2)


@pytest.fixture
def log(layout):
    """A level finger, whose sensors were set anew, under a pressure that rises after two seconds."""
    time = np.arange(0, 6, 0.02)
    pressure = np.where(time > 2.5, 60e3, 20e3)
    q = resting_angles(layout.finger, pressure, np.full(time.shape, -9.81j))
    poses = np.tile(TURNED, (len(time), 1, 1))
    return FingerLog("day_2", None, 3.0 + time, pressure, poses, np.array([0, 0, -9.81]), layout.read(q) + OFFSETS)


def test_offsets_are_taken_from_all_readings(layout, log):
    found = zeroed_log(log, layout, 2.0)
    np.testing.assert_allclose(log.readings - found.readings, np.broadcast_to(OFFSETS, log.readings.shape), atol=1e-5)


def test_what_cannot_be_zeroed_is_refused(layout, log):
    with refused("--zero", 6.0):
        zeroed_log(log, layout, 6.0)
    readings = log.readings.copy()
    readings[:150, 2] = np.nan
    with refused("--zero", 2.0):
        zeroed_log(replace(log, readings=readings), layout, 2.0)


def test_the_furthest_state_is_named():
    distance = np.array([[0.1, 0.2], [0.4, 3.0], [0.3, 0.1]])
    far = np.array([False, True, False])
    said = extrapolation_warnings(np.array([0.0, 0.5, 1.0]), distance, far, lambda row, part: f"state {row}, {part}")
    assert said == ["33 % of it is far from what was fitted: furthest at 0.5 s, with state 1, 1"]
    assert extrapolation_warnings(np.zeros(3), distance, np.zeros(3, bool), lambda *_: "") == []


def test_disagreement_is_said_beyond_that_of_fitted_recordings():
    assert disagreement_warnings("wires and pressures", 0.2, 0.2) == []
    (line,) = disagreement_warnings("wires and pressures", 0.3, 0.2)
    assert line.startswith("wires and pressures disagree (by 0.30 spreads, at most 0.20")
