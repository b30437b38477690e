"""The zeros of sensors that drift: by the drift's own model, and found again while the finger is known to be free."""

from dataclasses import replace

import numpy as np
import pytest
from loaded_fingers import vector

from soft_gripper.diagrams.simulation import simulate
from soft_gripper.estimators.contact import ContactShape
from soft_gripper.estimators.gaussian import GaussianShape
from soft_gripper.estimators.plane import to_base
from soft_gripper.estimators.recursive import RecursiveShape
from soft_gripper.estimators.uncertainty import Uncertainty, uncertainty_of
from soft_gripper.estimators.zeroing import recorded_zeros
from soft_gripper.fingers.statics import resting_angles
from soft_gripper.scenario.scenario_file import load_scenario
from soft_gripper.sensors.sensor_layout import SensorLayout
from soft_gripper.sensors.strain_errors import StrainErrors, disturb

PERIOD, DOWN, GRAVITY = 0.1, 9.81 + 0j, [0.0, 0.0, 9.81]
ERRORS = StrainErrors(drift=1e-3, noise=2e-3)
OPEN, PRESSED = 50, 50  # samples
ZEROED = replace(uncertainty_of(ERRORS), free_pressure=2e3)


@pytest.fixture(scope="module")
def layout(shipped_finger):
    return SensorLayout(shipped_finger, 4)


@pytest.fixture(scope="module")
def grasp(layout):
    """Pressures, readings without errors, driving torque and gravity: the finger is open, and then bent."""
    pressure = np.repeat([0.0, 60e3], [OPEN, PRESSED])
    q = resting_angles(layout.finger, pressure, np.full(pressure.shape, DOWN))
    return layout.read(q), layout.finger.pressure_torque(pressure), np.tile(vector(DOWN), (len(q), 1))


def zeros_of(layout, uncertainty, readings, driving, gravity):
    return GaussianShape(layout, uncertainty, PERIOD).zeroing.zeros_over_time(readings, driving, gravity)


@pytest.mark.parametrize("first", [0, 1])
def test_all_samples_at_once_are_one_after_the_other(layout, grasp, first):
    """Some readings are missing; the finger is open, pressed, and open again."""
    readings, driving, gravity = (np.concatenate([each, each[: OPEN // 2]]) for each in grasp)
    readings = readings + 1e-3 * np.random.default_rng(2).normal(size=readings.shape)
    readings[::7, 0] = np.nan
    zeroing = GaussianShape(layout, ZEROED, PERIOD).zeroing
    found = zeroing.zeros_over_time(readings, driving, gravity, first)
    zeros = zeroing.begin()
    for i, sample in enumerate(zip(readings, driving, gravity, strict=True)):
        zeros = zeroing.step(zeros if i > first else zeroing.begin(), *sample)
        for part, expected in zip(found, zeros, strict=True):
            np.testing.assert_array_equal(part[i], expected)
    assert found.offset.any()


def test_bands_widen_as_sensors_drift():
    """Of 4000 sensors, the standard deviation over an hour is that which is assumed of such an age, to 5 %."""
    ratios = np.ones((61, 1, 4000))
    read = disturb(ERRORS, ratios, 60.0, np.random.default_rng(1))[:, 0] - 1
    for minute in (1, 10, 60):
        assert read[minute].std() == pytest.approx(float(uncertainty_of(ERRORS).any_reading(60.0 * minute)), rel=0.05)
    assert uncertainty_of(ERRORS).any_reading(10.0) == uncertainty_of(ERRORS).any_reading()


def test_an_open_finger_is_zeroed_and_a_bent_one_keeps_its_zeros(layout, grasp):
    ideal, driving, gravity = grasp
    off = np.linspace(-0.03, 0.03, layout.readings)
    zeros = zeros_of(layout, ZEROED, ideal + off, driving, gravity)
    assert not zeros.offset[:5].any(), "the finger may still move"
    np.testing.assert_allclose(zeros.offset[10:], np.broadcast_to(off, (len(ideal) - 10, len(off))), atol=1e-6)
    np.testing.assert_allclose(zeros.age[OPEN - 1], 0.0)
    np.testing.assert_allclose(zeros.age[-1], PRESSED * PERIOD)
    corrected, (std,) = recorded_zeros(GaussianShape(layout, ZEROED, PERIOD), ideal + off, driving, gravity)
    np.testing.assert_allclose(corrected[OPEN:], ideal[OPEN:], atol=1e-6)
    assert std.shape == (len(ideal), 1)


def test_noise_is_averaged_and_lost_readings_stay_as_they_were(layout, grasp):
    ideal, driving, gravity = (np.repeat(each[:OPEN, None], 200, axis=1) for each in grasp)
    read = ideal + np.random.default_rng(2).normal(0.01, 2e-3, ideal.shape)
    read[..., 0] = np.nan
    zeros = zeros_of(layout, ZEROED, read, driving, gravity)
    assert not zeros.offset[-1, :, 0].any()
    np.testing.assert_allclose(zeros.age[-1, :, 0], OPEN * PERIOD)
    assert zeros.offset[-1, :, 1:].mean() == pytest.approx(0.01, abs=1e-4)
    # A running mean over ten samples, each with the weight 1 / 10: 1 / 19 of the variance.
    assert zeros.offset[-1, :, 1:].std() == pytest.approx(2e-3 / np.sqrt(19), rel=0.1)


def test_without_a_pressure_that_means_free_nothing_is_zeroed(layout, grasp):
    ideal, driving, gravity = grasp
    zeros = zeros_of(layout, uncertainty_of(ERRORS), ideal + 0.01, driving, gravity)
    assert not zeros.offset.any()
    np.testing.assert_allclose(zeros.age[-1], len(ideal) * PERIOD)
    assert GaussianShape(layout, Uncertainty()).zeroing is None
    assert ContactShape(layout, ZEROED, PERIOD).zeroing is not None


def test_old_zeros_make_shape_and_force_less_certain(layout, grasp):
    given = tuple(each[-1:] for each in grasp)
    for make in (GaussianShape, ContactShape):
        function = make(layout, uncertainty_of(ERRORS))
        stds = [
            np.sqrt(function(*given, std=np.full((1, 1), std)).covariance.sum())
            for std in map(function.uncertainty.any_reading, (0.0, 600.0, 3600.0))
        ]
        assert stds[0] < 0.6 * stds[1] < 0.6 * stds[2]
    usual, same = function(*given), function(*given, std=np.full((1, 1), function.uncertainty.any_reading()))
    np.testing.assert_array_equal(usual.q, same.q)


def test_a_steady_drift_is_foreseen(layout, grasp):
    """`recursive` learns the rates while the finger is free, and goes on with them while nothing is read.

    A drift is steady: what drifted in the first minute is expected in the second again.
    """
    ideal, driving, gravity = (np.repeat(each[:1], 1200, axis=0) for each in grasp)
    drifted = np.linspace(-1, 1, layout.readings) * 2e-2 * PERIOD / 60 * np.arange(1200)[:, None]
    read = np.where(np.arange(1200)[:, None] < 600, ideal + drifted, np.nan)
    function = RecursiveShape(layout, replace(uncertainty_of(ERRORS), drift=1e-2 / 60**0.5), PERIOD)
    known = function.begin()
    for sample in zip(read, driving, gravity, strict=True):
        known = function.step(known, *sample)
    np.testing.assert_allclose(function.changes(known).offset_changes, 2 * drifted[600], rtol=0.03)


def test_a_scenario_zeroes_its_sensors(layout):
    """What the blocks of a run say is what the functions say of the recorded readings."""
    sensors = "sensor.errors={drift: 0.5}", "sensor.period=0.02", "sensor.seed=3"
    steps = "pressure.steps={all: [0, 5e4]}", "pressure.settle=1.2", "pressure.hold_samples=5"
    zeroed = "estimator.uncertainty.free_pressure=2e3", "estimator.type=gaussian"
    recording = simulate(load_scenario("free_bending", (*sensors, *steps, *zeroed)))

    def of(name):
        return np.asarray(recording[f"left_finger.{name}"])[1:]

    gravity = to_base(of("X_WB"), np.array([0.0, 0.0, -9.81]))
    driving, readings = of("driving_torque"), of("strain").reshape(len(gravity), -1)
    function = GaussianShape(layout, replace(uncertainty_of(StrainErrors(drift=0.5)), free_pressure=2e3), 0.02)
    corrected, (std,) = recorded_zeros(function, readings, driving, gravity)
    assert np.abs(corrected - readings).max() > 1e-3, "something was zeroed"
    expected = function(corrected, driving, gravity, std).q
    np.testing.assert_allclose(of("estimated_joint_angles"), expected, atol=1e-9)
