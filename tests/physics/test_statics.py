"""Settled bending under pressure alone: every joint turns by its torque over its stiffness."""

import numpy as np
import pytest
from finger_plants import free_bending

from soft_gripper.diagrams.simulation import run_station
from soft_gripper.diagrams.station import make_station


def free_angles(finger, pressure):
    """tau_i / k_i = p A e ds / (E I), from the cross-section at the middle of every segment."""
    s = (np.arange(finger.segments) + 0.5) / finger.segments
    quantities = ("chamber_area", "chamber_eccentricity", "youngs_modulus", "width", "thickness")
    area, eccentricity, modulus, width, thickness = (
        (1 - s) * getattr(finger.base, name) + s * getattr(finger.tip, name) for name in quantities
    )
    rigidity = modulus * width * thickness**3 / 12
    return pressure * area * eccentricity * (finger.length / finger.segments) / rigidity


@pytest.mark.parametrize("time_step", [0.01, 0.0])
def test_settled_angles_are_torque_over_stiffness(time_step):
    pressures = [10e3, 240e3, -60e3]
    weightless = ("gravity=[0, 0, 0]", f"plant_config.time_step={time_step}")
    station = make_station(free_bending(pressures, 2.0, *weightless))
    recording = run_station(station)
    for finger in station.fingers:
        angles = recording[f"{finger.name}.sampled_joint_angles"]
        for end, pressure in zip((2.0, 4.0, 6.0), pressures, strict=True):
            settled = angles.sel(time=end, method="nearest")
            np.testing.assert_allclose(settled, free_angles(finger.finger, pressure), rtol=1e-3)
