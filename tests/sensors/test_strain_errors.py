"""Errors of sensors of strain and pressure: statistics, order, play operators, and their blocks."""

import math

import numpy as np
import pytest
from pydrake.common import RandomDistribution, RandomGenerator
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import DiagramBuilder
from pydrake.systems.primitives import LogVectorOutput, RandomSource, TrajectorySource
from pydrake.trajectories import PiecewisePolynomial

from soft_gripper.sensors.pressure_errors import PressureErrors
from soft_gripper.sensors.response_curve import ResponseCurve
from soft_gripper.sensors.sensor_block import SensorBlock
from soft_gripper.sensors.sensor_layout import SensorLayout
from soft_gripper.sensors.strain_errors import (
    FULL_SCALE,
    HYSTERESIS_LIMIT,
    MINUTE,
    PLAYS,
    RADII,
    RUN_DRAWS,
    SAMPLE_DRAWS,
    Draws,
    ReadingErrorBlock,
    StrainErrors,
    begin,
    disturb,
    draw,
    lagging_strain,
    moved_plays,
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


WIDTH = 0.02  # of the stroke


def lag(strain, width=WIDTH):
    """The strain with hysteresis along a path, (T,)."""
    plays, found = np.zeros((PLAYS, 1)), []
    for value in strain[:, None]:
        plays = moved_plays(plays, value)
        found.append(lagging_strain(plays, value, width)[0])
    return np.array(found)


def cycle(low, high, samples=2000):
    """Up, down and up again."""
    up = np.linspace(low, high, samples + 1)
    return np.concatenate([up, up[-2::-1], up[1:]])


def loop(low, high, samples=2000, width=WIDTH):
    """The strain with hysteresis on the way down and on the way up again, both by growing strain."""
    found = lag(cycle(low, high, samples), width)
    return found[samples : 2 * samples + 1][::-1], found[2 * samples :]


@pytest.mark.parametrize("width", [WIDTH, HYSTERESIS_LIMIT])
@pytest.mark.parametrize(("low", "high"), [(0.0, 0.1), (-0.2, 0.3), (0.05, 0.07)])
def test_the_loop_is_as_wide_as_its_share_of_the_stroke(low, high, width):
    """Less twice the least radius; on unloading, more is read than on loading."""
    down, up = loop(low, high, width=width)
    stroke = high - low
    assert (down - up).max() == pytest.approx(width * (stroke - 2 * RADII.min()), rel=1e-3)
    assert (down - up).max() == pytest.approx(width * stroke, rel=0.05)
    assert (down - up).min() > -1e-12


def test_at_the_limit_readings_still_follow_a_small_reversal():
    found = lag(np.array([0.0, 0.1, 0.1 - 1e-5, 0.1 + 1e-5]), HYSTERESIS_LIMIT)
    assert found[2] < found[1] < found[3]
    assert pytest.approx(1 / np.maximum(1 - RADII / FULL_SCALE, 0).sum(), rel=0.02) == HYSTERESIS_LIMIT


def test_first_stretched_to_full_scale_a_sensor_reads_it():
    assert lag(np.linspace(0, FULL_SCALE, 100))[-1] == pytest.approx(FULL_SCALE, abs=1e-12)


def test_a_recording_has_the_same_loop():
    strain = cycle(0.0, 0.1, 200)
    found = disturb(StrainErrors(hysteresis=WIDTH), 1 + strain[:, None], 0.01, np.random.default_rng(1))
    np.testing.assert_allclose(found[:, 0], 1 + lag(strain), rtol=0, atol=1e-14)


SAMPLES = 60
ERRORS = StrainErrors(
    *(0.1, 0.3, 0.02, 0.01, 1e-3, 1e-3, 1e-3, 2.0, 2e-3), (0.9, 1.09), 1e-4, 2, dropout=0.1, dead=(1,)
)


@pytest.fixture
def layout(shipped_finger):
    return SensorLayout(shipped_finger, 3, response=ResponseCurve(((0.9, -0.3), (1.0, 0.0), (1.1, 0.2))))


def disturbed_ramp(layout, errors, seed):
    """Ideal and disturbed readings of steadily moved joints between the samples, (T, R) each, and the draws."""
    builder = DiagramBuilder()
    motion = PiecewisePolynomial.FirstOrderHold([0.0, 1.0], np.linspace([0.0] * 12, [0.3] * 12, 2).T)
    source = builder.AddSystem(TrajectorySource(motion))
    sensor = builder.AddSystem(SensorBlock(layout, PERIOD))
    block = builder.AddSystem(ReadingErrorBlock(layout, errors, PERIOD))
    normal = block.GetInputPort("standard_normal")
    random = builder.AddSystem(RandomSource(RandomDistribution.kGaussian, normal.size(), PERIOD))
    builder.Connect(source.get_output_port(), sensor.get_input_port())
    builder.Connect(sensor.GetOutputPort("strain"), block.GetInputPort("ideal_strain"))
    builder.Connect(random.get_output_port(), normal)
    ports = sensor.GetOutputPort("strain"), block.GetOutputPort("strain"), random.get_output_port()
    logs = [LogVectorOutput(port, builder, PERIOD) for port in ports]
    simulator = Simulator(builder.Build())
    context = simulator.get_mutable_context()
    random.SetRandomContext(random.GetMyMutableContextFromRoot(context), RandomGenerator(seed))
    simulator.Initialize()
    simulator.AdvanceTo(PERIOD * (SAMPLES + 0.5))
    # A log at a time still shows the sample before: the first one twice.
    strain, disturbed, draws = (log.FindLog(context).data().T for log in logs)
    return strain[1:], disturbed[1:], draws.reshape(len(draws), -1, layout.readings)


def test_a_block_gives_what_a_recording_does(layout):
    strain, disturbed, draws = disturbed_ramp(layout, ERRORS, seed=1)
    used = Draws(draws[0, :RUN_DRAWS], np.concatenate([draws[:1], draws[2:]])[:, RUN_DRAWS:])
    expected = layout.response.reading(disturb(ERRORS, layout.response.ratio(strain), PERIOD, used))
    assert len(strain) == SAMPLES
    assert np.isnan(expected[:, 1]).all()
    assert np.isfinite(np.delete(expected, 1, axis=1)).mean() > 0.8
    np.testing.assert_allclose(disturbed, expected, rtol=0, atol=1e-12)


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
    found = disturbed(errors, np.full((100, 5000, 1), 1e5), rng(3))[..., 0] - 1e5
    assert found.mean(axis=0).std() == pytest.approx(math.hypot(1000, 300, 5), rel=0.05)
    assert (found - found.mean(axis=0)).std() == pytest.approx(50, rel=0.02)
