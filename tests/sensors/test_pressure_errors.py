"""PressureErrors: statistics, delay, and numbers that are refused."""

import math

import numpy as np
import pytest

from soft_gripper.sensors.pressure_errors import PressureErrors


def rng(seed=3):
    return np.random.default_rng(seed)


def disturbed(errors, pressure, rng):
    """Disturbs a recording of pressures, (T, ..., 1) Pa; for many seeds, repeated along a seed axis."""
    samples, *seeds, one = np.shape(pressure)
    run, each = errors.draws
    memory, found = errors.begin(rng.standard_normal((*seeds, run, one))), np.empty(np.shape(pressure))
    draws = rng.standard_normal((samples, *seeds, each, one))
    for i, ideal in enumerate(pressure):
        memory, found[i] = errors.step(memory, ideal, draws[i])
    return found


def test_noise_is_white_and_gain_and_offset_belong_to_a_run():
    errors = PressureErrors(gain_error=0.01, offset=300.0, noise=50.0)
    found = disturbed(errors, np.full((100, 5000, 1), 1e5), rng())[..., 0] - 1e5
    assert found.mean(axis=0).std() == pytest.approx(math.hypot(1000, 300, 5), rel=0.05)
    assert (found - found.mean(axis=0)).std() == pytest.approx(50, rel=0.02)
