"""Calibration: gains, offsets and the ratio of a finger unlike the nominal one are found again, with bands."""

from dataclasses import replace

import numpy as np
import pytest
from loaded_fingers import Push, in_balance

from soft_gripper.extras.hardware.free_bending import GAIN, RATIO, SOUGHT, FreeBending, calibrate
from soft_gripper.fingers.finger_parts import CreepBranch
from soft_gripper.fingers.kinematics import forward_kinematics
from soft_gripper.fingers.statics import FacePress, resting_angles, softened, strengthened
from soft_gripper.sensors.sensor_layout import SensorLayout, extension_ratios
from soft_gripper.sensors.strain_errors import StrainErrors, begin, disturb, draw

GRAVITY = 9.81 * np.exp(0.3j)
SPREAD = np.array([SOUGHT["pressure"], SOUGHT["response"]])
LEVELS = 0, 40, 80, 120, 150, 110, 70, 30, 0, -30, 0, 60, 120, 60, 0  # kPa
HELD, PERIOD, TIP = 20, 0.05, 3e-4  # samples; s; m
BENCH = StrainErrors(hysteresis=0.01, gain_error=0.03, offset=0.005, drift=1e-3, noise=2e-3)


def free_bending(layout, ratio=1.0, errors=None, seed=1, tip=False, gravity=GRAVITY, curvature=0.0):
    """What is recorded of a finger that bends by `ratio` further, and true gains and offsets."""
    steps = [np.append(np.linspace(p, q, 10), np.full(HELD, q)) for p, q in zip((0, *LEVELS), LEVELS, strict=False)]
    pressure = 1e3 * np.concatenate(steps)
    hold = np.concatenate([np.append(np.full(15, -1), np.full(HELD - 5, i)) for i in range(len(LEVELS))])
    q = resting_angles(softened(layout.finger, ratio), pressure, np.full(pressure.shape, gravity))
    rng, errors = np.random.default_rng(seed), errors or StrainErrors()
    draws = draw(rng, (len(q), layout.readings))
    strain = extension_ratios(layout, q) - 1
    ratios = disturb(errors, 1 + strain + curvature * strain**2, PERIOD, draws)
    place = forward_kinematics(q, layout.finger.segment_length).points[:, -1]
    place = place + TIP * (rng.standard_normal(len(q)) + 1j * rng.standard_normal(len(q)))
    time, gravities = PERIOD * np.arange(len(q)), np.full(pressure.shape, gravity)
    true = begin(errors, draws.run)
    return FreeBending(time, pressure, gravities, ratios, hold, place if tip else None), true.gain, true.offset


@pytest.mark.parametrize(("one_sided", "ratio"), [(False, 0.8), (False, 1.25), (True, 1.25)])
def test_without_errors_everything_is_found(tapered_finger, ratio, one_sided):
    layout = SensorLayout(tapered_finger, 3, one_sided=one_sided)
    found = calibrate(layout, [free_bending(layout, ratio)[0]])
    assert found.bend_ratio == pytest.approx(ratio, rel=2e-3)
    np.testing.assert_allclose(found.gains, 1, atol=2e-3)
    np.testing.assert_allclose(found.offsets, 0, atol=2e-5)
    assert abs(found.hysteresis) < 1e-4
    assert found.residual < 1e-5


def test_states_are_the_true_strains_of_the_holds(tapered_finger):
    """Of sensors with an offset: estimators look there how far their own calibrated strains are from them."""
    layout, pressure = SensorLayout(tapered_finger, 3), 1e3 * np.array(LEVELS)
    found = calibrate(layout, [free_bending(layout, 1.1, StrainErrors(offset=0.01))[0]])
    q = resting_angles(softened(tapered_finger, 1.1), pressure, np.full(pressure.shape, GRAVITY))
    states = found.states.fitted.states[:, : layout.readings]
    np.testing.assert_allclose(states, extension_ratios(layout, q) - 1, atol=1e-4)


def test_errors_of_a_bench_are_found_if_the_tip_is_measured(shipped_finger):
    """Gains of the outer path within 0.5 %, offsets within 1e-3; the inner path hardly stretches, and it says so."""
    layout = SensorLayout(shipped_finger, 2)
    samples, gains, offsets = free_bending(layout, 1.1, BENCH, tip=True)
    found = calibrate(layout, [samples])
    assert found.tip_measured
    assert found.bend_ratio == pytest.approx(1.1, rel=3e-3)
    np.testing.assert_allclose(found.gains[2:], gains[2:], rtol=5e-3)
    np.testing.assert_allclose(found.offsets, offsets, atol=1e-3)
    assert found.hysteresis == pytest.approx(0.01, abs=2e-3)
    assert np.all(found.gain_stds[:2] > 0.5 * GAIN)


@pytest.mark.slow
@pytest.mark.parametrize("tip", [False, True])
def test_bands_cover_the_truth_in_50_draws(shipped_finger, tip):
    layout, within, errors = SensorLayout(shipped_finger, 2), [], []
    for seed in range(50):
        ratio = 1 + 0.1 * np.random.default_rng(seed).standard_normal()
        samples, gains, offsets = free_bending(layout, ratio, BENCH, seed, tip)
        found = calibrate(layout, [samples])
        true, value = np.concatenate([[ratio], gains, offsets]), [[found.bend_ratio], found.gains, found.offsets]
        std = np.concatenate([[found.bend_ratio_std], found.gain_stds, found.offset_stds])
        errors.append(np.concatenate(value) - true)
        within.append(np.abs(errors[-1]) < 1.96 * std)
    assert np.mean(within) > 0.95
    assert np.min(np.mean(within, axis=0)) > 0.88
    rms = np.sqrt(np.mean(np.square(errors), axis=0))
    assert rms[5:].max() < 4e-4
    if tip:
        assert rms[3:5].max() < 3e-3


@pytest.mark.slow
def test_an_offset_of_the_pressure_and_a_curvature_are_found_if_the_tip_is_measured(shipped_finger):
    """In 12 draws of all errors: bands hold, and they are narrower than what was assumed by a factor of 3 or more."""
    layout, within, errors = SensorLayout(shipped_finger, 2), [], []
    for seed in range(12):
        offset, curvature = SPREAD * np.random.default_rng(seed).standard_normal(2)
        samples, _, offsets = free_bending(layout, 1.1, BENCH, seed, tip=True, curvature=curvature)
        found = calibrate(layout, [replace(samples, pressure=samples.pressure + offset)], ("pressure", "response"))
        true = np.array([offset, curvature, *offsets])
        value = np.array([found.pressure_offset, found.response_curvature, *found.offsets])
        std = np.array([found.pressure_offset_std, found.response_curvature_std, *found.offset_stds])
        errors.append(value - true)
        within.append(np.abs(errors[-1]) < 1.96 * std)
    assert np.mean(within) > 0.9
    assert np.all(std[:2] < SPREAD / 3)
    assert np.all(np.sqrt(np.mean(np.square(errors), axis=0))[:2] < SPREAD / 3)


def test_a_hold_in_which_the_finger_is_touched_is_doubtful(shipped_finger):
    layout = SensorLayout(shipped_finger, 4)
    samples, *_ = free_bending(layout, 1.1, replace(BENCH, hysteresis=0.0), tip=True)
    touched = samples.hold == 3
    samples.ratios[touched, 4:] -= 0.02
    found = calibrate(layout, [samples])
    (hold,) = found.doubtful
    assert hold[1] == pytest.approx(samples.time[touched].mean())
    assert found.bend_ratio == pytest.approx(1.1, rel=0.01)


@pytest.mark.slow
def test_a_finger_that_creeps_is_calibrated_as_it_rests(shipped_finger):
    """It bends as one does that is softer by what has crept away."""
    creeps = SensorLayout(replace(shipped_finger, creep=(CreepBranch(0.15, 0.3), CreepBranch(0.05, 2.0))), 4)
    softer = SensorLayout(softened(shipped_finger, 1 / 0.8), 4)
    found = calibrate(creeps, [free_bending(softer, 1.1)[0]])
    assert found.bend_ratio == pytest.approx(1.1, rel=2e-3)


def test_without_a_tip_and_weight_the_bend_is_as_uncertain_as_the_mean_of_the_gains(shipped_finger):
    """Eight readings count, each with the prior of its gain; how strains grow unevenly with the bend says little."""
    layout = SensorLayout(shipped_finger, 4)
    for ratio in (0.8, 1.25):
        found = calibrate(layout, [free_bending(layout, ratio, gravity=0j)[0]])
        assert 0.8 < found.bend_ratio_std / ratio * np.sqrt(8 / GAIN**2 + 1 / RATIO**2) < 1
        with_tip = calibrate(layout, [free_bending(layout, ratio, gravity=0j, tip=True)[0]])
        assert with_tip.bend_ratio_std < 0.3 * found.bend_ratio_std


def pressed(layout, strength, place, friction=0.0, errors=None, seed=1):
    """A recording of a finger that is stronger than nominal and presses, by the balance of `in_balance`."""
    force = np.repeat([0.0, 0.5, 0.0, 0.8, 0.0, 0.3, 0.0], 40)
    pressure = np.where(force > 0, 7e4, 0.0)
    hold = np.where(np.arange(len(force)) % 40 < 15, -1, np.arange(len(force)) // 40)
    finger = strengthened(layout.finger, strength)
    face = float(finger.section(place).inner_face)
    levels = {0.0: in_balance(finger, 0.0, GRAVITY)}
    for f in (0.3, 0.5, 0.8):
        driven = replace(finger, pressure_law=None)
        levels[f] = in_balance(driven, 7e4 * strength, GRAVITY, [Push(place, f, f * friction, face)])
    q = np.array([levels[f] for f in force])
    draws = draw(np.random.default_rng(seed), (len(q), layout.readings))
    ratios = disturb(errors or StrainErrors(), extension_ratios(layout, q), PERIOD, draws)
    press = FacePress(force, np.full(len(force), place))
    gravity = np.full(len(force), GRAVITY)
    return FreeBending(PERIOD * np.arange(len(force)), pressure, gravity, ratios, hold, press=press)


@pytest.mark.parametrize("strength", [0.85, 1.0, 1.2])
def test_measured_forces_tell_the_strength_of_a_finger(shipped_finger, strength):
    """Free bending tells nothing of it; with forces at two places friction is told apart from it."""
    layout = SensorLayout(shipped_finger, 2, borders=(1 / 3,))
    free = free_bending(SensorLayout(strengthened(shipped_finger, strength), 2, borders=(1 / 3,)))[0]
    presses = [pressed(layout, strength, place, 0.2) for place in (0.07, 0.1)]
    found = calibrate(layout, [free, *presses])
    assert found.strength == pytest.approx(strength, abs=2 * found.strength_std + 2e-3)
    assert found.strength_std < 0.03
    assert found.friction == pytest.approx(0.2, abs=0.05)
    assert len(found.states.fitted.states) == len(LEVELS) + 4 * len(presses)  # of the free finger
    blind = calibrate(layout, [free])
    assert (blind.strength, blind.strength_std) == (1.0, 0.0)


def test_a_force_tells_no_common_gain_from_the_bend(shipped_finger):
    """Both say how much strain there is per load: it is hardly better known, and a measured tip still tells it."""
    layout = SensorLayout(shipped_finger, 2, borders=(1 / 3,))
    free = free_bending(layout, errors=BENCH)[0]
    presses = [pressed(layout, 1.0, place, errors=BENCH) for place in (0.07, 0.1)]
    stds = [calibrate(layout, recordings).bend_ratio_std for recordings in ([free], [free, *presses])]
    assert 0.6 < stds[1] / stds[0] < 1
    assert calibrate(layout, [free_bending(layout, errors=BENCH, tip=True)[0]]).bend_ratio_std < 0.2 * stds[0]


def test_a_measured_tip_tells_how_the_bend_varies_along_the_finger(shipped_finger):
    """Of a finger that is graded by +-8 %; sensors alone leave about what was known before."""
    layout, stds = SensorLayout(shipped_finger, 4), []
    for tip in (True, False):
        graded = replace(layout, finger=softened(shipped_finger, 1.05, 0.08))
        samples, gains, _ = free_bending(graded, errors=BENCH, tip=tip)
        found = calibrate(layout, [samples], ["variation"])
        assert abs(found.bend_variation - 0.08) < 2 * found.bend_variation_std
        stds.append(found.bend_variation_std)
        if tip:
            np.testing.assert_allclose(found.gains[4:], gains[4:], rtol=0.03)
    assert stds[0] < 0.5 * SOUGHT["variation"] < stds[1] < SOUGHT["variation"]
