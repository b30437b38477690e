"""StrainErrors: what every error does to extension ratios, by its definition, one at a time and in order."""

import math

import numpy as np
import pytest

from soft_gripper.sensors.strain_errors import (
    MINUTE,
    PLAYS,
    RUN_DRAWS,
    SAMPLE_DRAWS,
    Draws,
    StrainErrors,
    begin,
    disturb,
    draw,
    stack_memory,
)

PERIOD = 0.01  # s


def rng(seed=7):
    return np.random.default_rng(seed)


def ramp(samples=50, readings=3):
    """Extension ratios that grow, differently for every reading."""
    return 1 + np.linspace(0, 0.1, samples)[:, None] * np.linspace(-0.5, 1.0, readings)


def held(samples, *shape, ratio=1.1):
    return np.full((samples, *shape), ratio)


def test_creep_follows_its_closed_form():
    """Of a strain that is there from the first sample on: all but a share at once, that with a time constant."""
    errors = StrainErrors(creep=0.3, creep_time=0.2)
    found = disturb(errors, held(100, 1), PERIOD, rng())[:, 0]
    time = PERIOD * np.arange(100)
    np.testing.assert_allclose(found, 1 + 0.1 * (1 - 0.3 * np.exp(-time / 0.2)), rtol=0, atol=1e-14)


def test_gain_and_offset_are_drawn_once_a_run_for_every_sensor():
    errors = StrainErrors(gain_error=0.02, offset=0.003)
    draws = draw(rng(), (50, 3))
    gain, offset = 1 + 0.02 * draws.run[0], 0.003 * draws.run[1]
    expected = 1 + (ramp() - 1) * gain + offset
    np.testing.assert_allclose(disturb(errors, ramp(), PERIOD, draws), expected, rtol=0, atol=1e-15)
    many = disturb(errors, held(2, 20000, 1), PERIOD, rng())[0] - 1
    assert many.mean() == pytest.approx(0.1, abs=1e-4)
    assert many.std() == pytest.approx(math.hypot(0.02 * 0.1, 0.003), rel=0.02)


@pytest.mark.slow
def test_drift_is_steady_and_has_its_standard_deviation_after_a_minute():
    samples = round(MINUTE / 0.1) + 1
    drifted = disturb(StrainErrors(drift=0.001), held(samples, 5000, 1, ratio=1.0), 0.1, rng())[..., 0] - 1
    assert drifted[-1].std() == pytest.approx(0.001, rel=0.03)
    np.testing.assert_allclose(drifted[samples // 2], drifted[-1] / 2, rtol=0, atol=1e-12)


def test_low_frequency_noise_is_a_stationary_gauss_markov_process():
    """As wide in the first sample as later, and correlated as exp(-time / correlation time)."""
    errors = StrainErrors(low_frequency_noise=0.002, correlation_time=0.5)
    noise = disturb(errors, held(51, 20000, 1), PERIOD, rng())[..., 0] - 1.1
    np.testing.assert_allclose(noise.std(axis=1), 0.002, rtol=0.04)
    assert np.corrcoef(noise[0], noise[-1])[0, 1] == pytest.approx(math.exp(-1), abs=0.02)


def test_noise_is_white():
    noise = disturb(StrainErrors(noise=0.002), held(5000, 4), PERIOD, rng()) - 1.1
    np.testing.assert_allclose(noise.std(axis=0), 0.002, rtol=0.05)
    assert abs(np.corrcoef(noise[1:, 0], noise[:-1, 0])[0, 1]) < 0.05
    assert abs(np.corrcoef(noise.T)[0, 1]) < 0.05


def test_saturation_and_quantization():
    errors = StrainErrors(saturation=(0.99, 1.0425), quantization=0.01)
    found = disturb(errors, ramp(), PERIOD, rng())
    np.testing.assert_allclose(found, 0.01 * np.round(np.clip(ramp(), 0.99, 1.0425) / 0.01), rtol=0, atol=1e-15)
    assert (found.min(), found.max()) == pytest.approx((0.99, 1.04))


@pytest.mark.parametrize("delay", [1, 3])
def test_delay_is_of_whole_samples(delay):
    """Until the first sample has arrived, it is what is read."""
    found = disturb(StrainErrors(delay=delay), ramp(), PERIOD, rng())
    np.testing.assert_allclose(found[delay:], ramp()[:-delay], rtol=0, atol=1e-15)
    np.testing.assert_allclose(found[:delay], ramp()[:1].repeat(delay, axis=0), rtol=0, atol=1e-15)


@pytest.mark.slow
@pytest.mark.parametrize("dropout", [0.05, 1.0])
def test_dropout_has_its_frequency(dropout):
    lost = np.isnan(disturb(StrainErrors(dropout=dropout), held(5000, 4), PERIOD, rng()))
    np.testing.assert_allclose(lost.mean(axis=0), dropout, atol=0.01)


def test_dead_sensors_read_nothing():
    found = disturb(StrainErrors(dead=(0, 2)), ramp(), PERIOD, rng())
    assert np.isnan(found[:, [0, 2]]).all()
    np.testing.assert_allclose(found[:, 1], ramp()[:, 1], rtol=0, atol=1e-15)


def test_errors_act_in_their_order():
    """Offset and noise are not crept; what is read out is quantized last, and then late."""
    errors = StrainErrors(
        creep=0.5, creep_time=1e9, gain_error=0.1, offset=0.01, noise=0.02, quantization=0.05, delay=1
    )
    draws = Draws(np.array([[1.0], [2.0], [0.0], [0.0]]), np.zeros((3, SAMPLE_DRAWS, 1)))
    draws.samples[:, 0, 0] = [0.0, 3.0, -1.0]
    found = disturb(errors, held(3, 1, ratio=1.2), PERIOD, draws)[:, 0]
    before = 1 + 0.5 * 0.2 * 1.1 + 0.02 + 0.02 * np.array([0.0, 3.0])
    np.testing.assert_allclose(found[1:], 0.05 * np.round(before / 0.05), rtol=0, atol=1e-8)


EVERYTHING = StrainErrors(
    *(0.1, 0.3, 0.02, 0.01, 1e-3, 1e-3, 1e-3, 2.0, 2e-3), (0.9, 1.09), 1e-4, 2, dropout=0.1, dead=(1,)
)


def test_many_seeds_at_once_are_as_one_by_one():
    draws = draw(rng(), (50, 6, 3))
    together = disturb(EVERYTHING, ramp()[:, None].repeat(6, axis=1), PERIOD, draws)
    for seed in range(6):
        own = Draws(draws.run[seed], draws.samples[:, seed])
        np.testing.assert_array_equal(together[:, seed], disturb(EVERYTHING, ramp(), PERIOD, own))


def test_shapes_of_the_draws_and_of_the_memory_of_several_sets():
    draws = draw(rng(), (50, 2, 6, 3))
    assert (draws.run.shape, draws.samples.shape) == ((2, 6, RUN_DRAWS, 3), (50, 2, 6, SAMPLE_DRAWS, 3))
    assert stack_memory(begin(EVERYTHING, draws.run)).shape == (2, 6, 8 + PLAYS + EVERYTHING.delay, 3)


def test_what_creeps_reaches_the_hysteresis_late():
    """A sensor all of whose strain comes late has not moved yet, and no play operator has."""
    errors = StrainErrors(creep=1.0, creep_time=1e9, hysteresis=0.05)
    ratios = np.repeat([1.0, 1.2, 0.9], 5)[:, None]
    np.testing.assert_allclose(disturb(errors, ratios, 0.01, np.random.default_rng(0)), 1.0, atol=1e-6)
