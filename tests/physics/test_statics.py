"""Settled bending under pressure alone: every joint turns by its torque over its stiffness."""

import numpy as np
import pytest
from finger_plants import built_at, free_bending

from soft_gripper.diagrams.simulation import run_station
from soft_gripper.diagrams.station import make_station


def free_angles(finger, pressure):
    """tau_i / k_i = p A e ds / (E I), from the cross-section at the middle of every segment."""
    ds = finger.length / finger.segments
    sections = [built_at(finger, (i + 0.5) * ds) for i in range(finger.segments)]
    gains = np.array([section.chamber_area * section.chamber_eccentricity for section in sections])
    return pressure * gains * ds / [section.bending_stiffness for section in sections]


@pytest.mark.parametrize("time_step", [0.01, 0.0])
def test_settled_angles_are_torque_over_stiffness(time_step):
    pressures = [10e3, 210e3, -50e3]
    weightless = ("gravity=[0, 0, 0]", f"plant_config.time_step={time_step}")
    station = make_station(free_bending(pressures, 2.0, *weightless))
    recording = run_station(station)
    for finger in station.fingers:
        angles = recording[f"{finger.name}.sampled_joint_angles"]
        for end, pressure in zip((2.0, 4.0, 6.0), pressures, strict=True):
            settled = angles.sel(time=end, method="nearest")
            np.testing.assert_allclose(settled, free_angles(finger.finger, pressure), rtol=1e-3)
