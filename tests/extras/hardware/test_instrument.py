"""Delay, zero and drift of an instrument, of signals for which they are known."""

import numpy as np
import pytest

from soft_gripper.extras.hardware.instrument import InstrumentRun, find_instrument

PERIOD, LATE, ZEROS, DRIFT = 0.02, 0.36, (0.05, -0.02), 4e-4
TIME = PERIOD * np.arange(2000)


def force(time):
    """Presses of 4 s every 8 s, each larger than the one before."""
    number, inside = np.divmod(time, 8.0)
    return np.where((inside > 3) & (inside < 7), 0.3 + 0.1 * number, 0.0) * (time >= 0)


def run(zero, step=0.01, noise=0.01, seed=0):
    rng = np.random.default_rng(seed)
    value = force(TIME - LATE) + zero + DRIFT * TIME
    value = np.round(value / step) * step if step else value
    return InstrumentRun(TIME, value, 0.9 * force(TIME) + noise * rng.normal(size=len(TIME)), np.ones(len(TIME), bool))


def test_they_are_found_together_from_several_runs():
    runs = [run(zero, seed=seed) for seed, zero in enumerate(ZEROS)]
    found = find_instrument(runs, 0.05)
    assert found.delay == pytest.approx(LATE)
    np.testing.assert_allclose(found.zeros, ZEROS, atol=0.002)
    assert found.drift == pytest.approx(DRIFT, rel=0.1)
    corrected = found.corrected(1, runs[1])
    known = np.isfinite(corrected)
    assert known.sum() == len(TIME) - round(LATE / PERIOD)
    np.testing.assert_allclose(corrected[known], force(TIME)[known], atol=0.011)


def test_presses_that_the_estimate_misses_do_not_count_as_drift():
    """The scale is loaded for a tenth of the time in which the finger seems free."""
    one = run(ZEROS[0], step=0.0)
    value = one.value + 0.4 * (TIME > 32.5) * (TIME < 34.5)
    found = find_instrument([InstrumentRun(TIME, value, one.estimate, one.rest)], 0.05)
    assert found.drift == pytest.approx(DRIFT, rel=0.3)
    assert found.zeros[0] == pytest.approx(ZEROS[0], abs=0.01)


def test_without_a_free_finger_nothing_is_corrected_but_the_delay():
    pressed = InstrumentRun(TIME, 0.5 + force(TIME - LATE), 0.5 + force(TIME), np.ones(len(TIME), bool))
    found = find_instrument([pressed], 0.05)
    assert found.delay == pytest.approx(LATE)
    assert np.isnan([*found.zeros, found.drift]).all()
    np.testing.assert_allclose(found.corrected(0, pressed)[:100], pressed.estimate[:100])
