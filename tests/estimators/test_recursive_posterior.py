"""The posterior of `recursive` in Drake's contacts with realistic sensors, and its innovation test."""

import numpy as np
import pytest

from soft_gripper.diagrams.simulation import simulate
from soft_gripper.estimators.recursive import RecursiveShape
from soft_gripper.estimators.uncertainty import Uncertainty
from soft_gripper.fingers.statics import free_bending_angles
from soft_gripper.scenario.scenario_file import load_scenario
from soft_gripper.sensors.sensor_layout import SensorLayout

EXACT = "estimator.uncertainty.bend_per_pressure=0.005"
REALISTIC = ["estimator.type=recursive", "sensor.errors.preset=realistic", "sensor.seed=3", EXACT]


def run(name, *overrides):
    return simulate(load_scenario(name, [*REALISTIC, *overrides])).data


@pytest.mark.slow
@pytest.mark.parametrize(("name", "sections"), [("obstructed_inside", 4), ("obstructed_outside", 2)])
def test_what_is_stated_of_a_force_is_true_in_time(name, sections):
    """Of samples with more than 0.05 N; before contact nothing is detected, and bounds are not far above the force."""
    data = run(name, f"sensor.sections={sections}")
    force = np.abs(data["left_finger.true_contact_force"].values.ravel())
    least, most = data["left_finger.contact_force_set"].values.T
    bounds = np.nan_to_num(data["left_finger.contact_force_bounds"].values[:, 1], nan=np.inf)
    touched, detected = force > 0.05, data["left_finger.contact_probability"].values.ravel() > 0.95
    assert np.mean((least <= force)[touched] & (force <= most)[touched]) > 0.95
    assert np.mean((force <= bounds)[touched]) > 0.95
    assert np.median((bounds / np.maximum(force, 1e-9))[touched]) < 1.4
    assert np.mean(detected[touched]) > 0.98
    assert np.mean(detected[force == 0]) < 0.02
    other = data["right_finger.contact_probability"].values.ravel() > 0.95
    assert np.mean(other) < 0.02, "of a finger that nothing touches"
    for finger in ("left_finger", "right_finger"):
        assert np.mean(data[f"{finger}.innovation"].values > 1) < 0.01


def test_a_jump_of_the_readings_that_was_not_predicted_is_an_innovation(shipped_finger):
    layout = SensorLayout(shipped_finger, 2)
    estimator = RecursiveShape(layout, Uncertainty(reading=1e-3))
    driving, rng = shipped_finger.pressure_torque(60e3), np.random.default_rng(1)
    readings = layout.read(free_bending_angles(shipped_finger, 60e3)) + 1e-3 * rng.standard_normal((3000, 4))
    known, exceeded = estimator.begin(), []
    for sample in readings:
        known = estimator.step(known, sample, driving, np.zeros(3))
        exceeded.append(known.innovation > 1)
    assert np.mean(exceeded[100:]) < 0.004, "noise: 1 in 1000"
    assert estimator.step(known, readings[-1] + 0.02, driving, np.zeros(3)).innovation > 1
