"""Calibration: gains, offsets and the ratio of a finger that is other than assumed are found again."""

from dataclasses import replace

import numpy as np
import pytest

from soft_gripper.estimators.calibration import FreeBending, calibrate
from soft_gripper.fingers.finger_parts import CreepBranch
from soft_gripper.fingers.statics import resting_angles, softened
from soft_gripper.sensors.sensor_layout import SensorLayout, extension_ratios

GRAVITY = 9.81 * np.exp(0.3j)
PRESSURE = np.repeat(np.linspace(-30e3, 120e3, 6), 20)


def free_bending(layout, ratio, gains, offsets, noise=0.0):
    """What sensors of these gains and offsets read along a finger that bends by `ratio` further."""
    gravity = np.full(PRESSURE.shape, GRAVITY)
    q = resting_angles(softened(layout.finger, ratio), PRESSURE, gravity)
    ratios = 1 + gains * (extension_ratios(layout, q) - 1) + offsets
    return FreeBending(PRESSURE, gravity, ratios + noise * np.random.default_rng(1).standard_normal(ratios.shape))


def errors(readings, seed=2):
    """Gains with a mean of 1, and offsets."""
    gains, offsets = np.random.default_rng(seed).standard_normal((2, readings)) * [[0.05], [0.005]]
    return 1 + gains - gains.mean(), offsets


@pytest.mark.slow
@pytest.mark.parametrize("one_sided", [False, True])
@pytest.mark.parametrize("ratio", [0.8, 1.25])
def test_without_noise_everything_is_found(tapered_finger, ratio, one_sided):
    layout = SensorLayout(tapered_finger, 5, one_sided=one_sided)
    gains, offsets = errors(layout.readings)
    found = calibrate(layout, free_bending(layout, ratio, gains, offsets))
    assert found.bend_ratio == pytest.approx(ratio, rel=1e-4)
    np.testing.assert_allclose(found.gains, gains, rtol=0, atol=1e-4)
    np.testing.assert_allclose(found.offsets, offsets, rtol=0, atol=1e-5)
    assert found.residual < 1e-6


@pytest.mark.slow
def test_outliers_do_little_harm(shipped_finger):
    layout = SensorLayout(shipped_finger, 4)
    gains, offsets = errors(8)
    samples = free_bending(layout, 1.1, gains, offsets, noise=1e-3)
    samples.ratios[::15, 3] += 0.1
    found = calibrate(layout, samples)
    assert found.bend_ratio == pytest.approx(1.1, rel=0.01)
    np.testing.assert_allclose(found.gains, gains, rtol=0, atol=0.04)
    np.testing.assert_allclose(found.offsets, offsets, rtol=0, atol=1e-3)


def test_a_common_gain_is_taken_for_bend(shipped_finger):
    """Documented: strain and pressure do not tell them apart."""
    layout = SensorLayout(shipped_finger, 4)
    found = calibrate(layout, free_bending(layout, 1.0, np.full(8, 1.1), np.zeros(8)))
    assert found.gains.mean() == pytest.approx(1.0)
    assert found.bend_ratio == pytest.approx(1.1, rel=0.01)


@pytest.mark.slow
def test_a_finger_that_creeps_is_calibrated_as_it_rests(shipped_finger):
    """It bends as one does that is softer by what has crept away."""
    creeps = SensorLayout(replace(shipped_finger, creep=(CreepBranch(0.15, 0.3), CreepBranch(0.05, 2.0))), 4)
    softer = SensorLayout(softened(shipped_finger, 1 / 0.8), 4)
    found = calibrate(creeps, free_bending(softer, 1.1, np.ones(8), np.zeros(8)))
    assert found.bend_ratio == pytest.approx(1.1, rel=1e-4)
