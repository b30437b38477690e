"""What is wrong with finger and sensors is learnt in free motion, kept under load, and what fails is left out."""

from dataclasses import replace
from typing import NamedTuple

import numpy as np
import pytest
from fingers_in_space import torque_covariance
from loaded_fingers import Push, in_balance, vector

from soft_gripper.arrays import Array
from soft_gripper.diagrams.simulation import simulate
from soft_gripper.estimators.finger_shape import position_std
from soft_gripper.estimators.recursive import FilterState, RecursiveShape
from soft_gripper.estimators.uncertainty import EXACT, Uncertainty, uncertainty_of
from soft_gripper.fingers.finger import Finger
from soft_gripper.fingers.kinematics import forward_kinematics
from soft_gripper.fingers.statics import resting_angles, softened
from soft_gripper.scenario.scenario_file import load_scenario
from soft_gripper.sensors.sensor_layout import SensorLayout, extension_ratios
from soft_gripper.sensors.strain_errors import StrainErrors, disturb

PERIOD, NOISE = 0.01, 2e-3
DOWN = 9.81 + 0j  # the finger hangs
UNCERTAIN = Uncertainty(
    reading=NOISE, bend_per_pressure=0.05, pressure=500.0, gain=0.01, offset=1e-3, drift=3e-4, load_pressure=1.5e5
)
FORCE, PLACE, HELD = 0.8, 0.09, 90e3  # N, m, Pa
SHARES = np.linspace(0, 1, 30)  # of force and pressure, as they rise


class Motion(NamedTuple):
    """What truly happens."""

    q: Array  # (T, N) rad
    driving: Array  # (T, N) N m


@pytest.fixture(scope="module")
def free(shipped_finger: Finger) -> Motion:
    """Twelve seconds of free motion, from straight to far bent, back and forth."""
    time = np.arange(1200) * PERIOD
    pressure = 60e3 * (1 - np.cos(2 * np.pi * time / 6)) - 20e3 * np.sin(2 * np.pi * time / 4)
    return Motion(
        resting_angles(shipped_finger, pressure, np.full(time.shape, DOWN)), shipped_finger.pressure_torque(pressure)
    )


@pytest.fixture(scope="module")
def grasp(free: Motion, shipped_finger: Finger) -> Motion:
    """The same, then a force that comes in a third of a second with the pressure, and stays."""
    rise = [in_balance(shipped_finger, share * HELD, DOWN, [Push(PLACE, share * FORCE)]) for share in SHARES]
    q = np.concatenate([free.q, rise, np.tile(rise[-1], (170, 1))])
    held = shipped_finger.pressure_torque(np.concatenate([HELD * SHARES, np.full(170, HELD)]))
    return Motion(q, np.concatenate([free.driving, held]))


@pytest.fixture(scope="module")
def layout(shipped_finger: Finger) -> SensorLayout:
    return SensorLayout(shipped_finger, 2, borders=(1 / 3,))


def read(layout: SensorLayout, motion: Motion, seed: int = 1, **errors: float) -> Array:
    ratios = disturb(StrainErrors(noise=NOISE, **errors), extension_ratios(layout, motion.q), PERIOD, rng(seed))  # type: ignore[arg-type]
    return layout.response.reading(ratios)


def rng(seed: int) -> np.random.Generator:
    return np.random.default_rng(seed)


def tip_errors(finger: Finger, true: Array, q: Array) -> Array:
    """mm."""
    tips = [forward_kinematics(angles, finger.segment_length).tip for angles in (true, q)]
    return 1e3 * np.abs(tips[1] - tips[0])


def last_known(shape: RecursiveShape, readings: Array, driving: Array):
    known = shape.begin()
    for sample in zip(readings, driving, strict=True):
        known = shape.step(known, *sample, vector(DOWN))
    return known


@pytest.mark.slow
def test_under_load_nothing_is_learnt_and_force_and_place_are_found(grasp, layout):
    shape, readings = RecursiveShape(layout, UNCERTAIN), read(layout, grasp)
    found = shape(readings, grasp.driving, vector(DOWN))
    assert np.mean(found.contact.force[-100:]) == pytest.approx(FORCE, rel=0.05)
    assert np.mean(found.contact.arc_length[-100:]) == pytest.approx(PLACE, abs=3e-3)
    assert not np.any(found.contact.force[600:1195])
    before, after = (last_known(shape, readings[:end], grasp.driving[:end]) for end in (1250, 1400))
    assert before.loaded
    assert after.loaded
    others, offsets, rates = np.split(np.arange(5, len(before.mean)), [-2 * layout.readings, -layout.readings])
    kept = np.append(others, rates)
    np.testing.assert_array_equal(before.mean[kept], after.mean[kept])
    drifted = before.mean[offsets] + 150 * PERIOD * before.mean[rates]
    np.testing.assert_allclose(after.mean[offsets], drifted, rtol=1e-9, err_msg="go on at the rates that were learnt")


@pytest.mark.slow
def test_a_dead_sensor_widens_the_band(grasp, layout):
    shape, readings = RecursiveShape(layout, UNCERTAIN), read(layout, grasp)
    dead = readings.copy()
    dead[1250:, 3] = np.nan  # the outer one of the second section, as it is pressed
    whole, broken = (shape(each, grasp.driving, vector(DOWN)) for each in (readings, dead))
    assert np.isfinite(broken.q).all()
    band = [position_std(layout.finger, found.q[-1], found.covariance[-1]) for found in (whole, broken)]
    assert (band[1][1:] > band[0][1:]).all()
    assert band[1][-1] > 1.1 * band[0][-1]


class Learner(NamedTuple):
    """A step of the filter from its beginning, by a finger that bends little, and how readings depend on states."""

    shape: RecursiveShape
    driving: Array
    columns: Array  # (R, n) by differences: load, share of the bend, pressure, gains, offsets
    expected: Array  # (R,) strains, if nothing is wrong


@pytest.fixture(scope="module")
def learner(layout: SensorLayout) -> Learner:
    """At 40 kPa, without weight."""
    return learner_of(layout, UNCERTAIN)


def learner_of(layout: SensorLayout, assumed: Uncertainty) -> Learner:
    shape, finger, readings = RecursiveShape(layout, assumed), layout.finger, layout.readings
    driving = finger.pressure_torque(40e3)
    _, modes = np.linalg.eigh(torque_covariance(finger, assumed.load_pressure))

    def strains(state: Array) -> Array:
        load, (share, pressure), gains, offsets = np.split(state, [5, 7, 7 + readings])
        torque = driving * (1 + share) + pressure * finger.pressure_gain + modes[:, :-6:-1] @ load
        strain: Array = (1 + gains) * (extension_ratios(layout, finger.angle(torque)) - 1) + offsets
        return strain

    steps = np.concatenate([np.full(5, 1e-4), [1e-4, 10.0], np.full(2 * readings, 1e-4)])
    sides = [
        [strains(sign * step * unit) for sign in (1, -1)] for step, unit in zip(steps, np.eye(len(steps)), strict=True)
    ]
    columns = np.array([(more - less) / (2 * step) for (more, less), step in zip(sides, steps, strict=True)]).T
    return Learner(shape, driving, columns, strains(np.zeros(len(steps))))


def before(learner: Learner) -> Array:
    """Variances of the states as the first sample is read: what is assumed, and what a period adds, (n,)."""
    assumed, finger, readings = learner.shape.uncertainty, learner.shape.layout.finger, learner.shape.layout.readings
    loads = np.linalg.eigvalsh(torque_covariance(finger, assumed.load_pressure))[:-6:-1]
    slow = [assumed.bend_per_pressure, assumed.pressure]
    slow += [assumed.gain] * readings + [assumed.offset] * readings
    walks = [1e-3, 0.0] + [1e-3] * readings + [assumed.drift] * readings
    return np.concatenate([loads * (1 + PERIOD * 0.15**2), np.square(slow) + PERIOD * np.square(walks)])


def stepped(learner: Learner, wrong: Array, known: FilterState | None = None) -> FilterState:
    """After a sample whose readings are off by so much, (..., R)."""
    read = learner.shape.layout.response.reading(1 + learner.expected + wrong)
    known = learner.shape.begin(wrong.shape[:-1]) if known is None else known
    return learner.shape.step(known, read, np.broadcast_to(learner.driving, (*wrong.shape[:-1], 12)), np.zeros(3))


WRONG = 1e-3 * np.array([1.0, -2.0, 1.5, 1.0])
SLOW = slice(5, 15)  # states that are slow, but for the rates of drift, which a sample does not see


def test_a_free_sample_corrects_what_is_slow_as_least_squares_do_with_30_times_the_noise(learner: Learner) -> None:
    """No load; a sample counts little, since errors of sensors are not white."""
    known, slow = stepped(learner, WRONG), SLOW
    assert not known.loaded
    columns, variances = learner.columns[:, slow], before(learner)[slow]
    rows = np.vstack([np.diag(variances**-0.5), columns / (np.sqrt(30) * NOISE)])
    right = np.concatenate([np.zeros(len(variances)), WRONG / (np.sqrt(30) * NOISE)])
    expected = np.linalg.lstsq(rows, right, rcond=None)[0]
    np.testing.assert_array_equal(known.mean[:5], 0.0)
    sizes = np.sqrt(variances)
    np.testing.assert_allclose(known.mean[slow] / sizes, expected / sizes, rtol=0.02, atol=2e-4)
    covariance = np.linalg.inv(rows.T @ rows)
    np.testing.assert_allclose(
        known.covariance[slow, slow] / np.outer(sizes, sizes), covariance / np.outer(sizes, sizes), atol=2e-3
    )


def test_what_is_slow_goes_astray_as_it_is_believed_to(layout: SensorLayout) -> None:
    """Of states that are known at first, and of which a sample says next to nothing, the walk of a period is left."""
    learner = learner_of(layout, Uncertainty(reading=1.0, gain=0.01, drift=2e-3))
    begin = learner.shape.begin()
    known = stepped(learner, np.zeros(layout.readings), begin._replace(covariance=0 * begin.covariance))
    rates = [2e-3 / 60**0.5 / 3600**0.5] * layout.readings  # those of 2e-3 in the root of a minute change in an hour
    expected = np.array([1e-3, 0.0] + [1e-3] * layout.readings + [PERIOD * each for each in rates] + rates) ** 2
    found = np.diagonal(known.covariance)[SLOW.start :]
    np.testing.assert_allclose(found, expected * PERIOD, rtol=1e-3)


def test_hysteresis_of_a_finger_that_has_straightened_is_no_load(layout: SensorLayout) -> None:
    """Whose model is exact, and which nothing touches; a force of 0.4 N on its tip still is one."""
    pressure = np.concatenate([np.linspace(0, 150e3, 10), np.full(20, 150e3), np.linspace(150e3, 0, 10), np.zeros(40)])
    driving, errors = layout.finger.pressure_torque(pressure), StrainErrors(hysteresis=0.01, noise=NOISE, drift=1e-3)
    free = resting_angles(layout.finger, pressure, np.full(pressure.shape, DOWN))
    touched = free.copy()
    touched[10:30] = in_balance(layout.finger, 150e3, DOWN, [Push(layout.finger.length, 0.4)])
    ratios = np.stack([extension_ratios(layout, q) for q in (free, touched)], axis=1)
    readings = layout.response.reading(disturb(errors, ratios, 0.1, rng(1)))
    shape = RecursiveShape(layout, replace(uncertainty_of(errors), bend_per_pressure=EXACT), 0.1)
    gravity = np.broadcast_to(vector(DOWN), (len(pressure), 2, 3))
    loaded = shape.over_time(readings, np.repeat(driving[:, None], 2, axis=1), gravity).loaded
    assert not loaded[:, 0].any()
    assert loaded[15:30, 1].all()
    assert not loaded[-20:, 1].any()


def test_the_band_of_a_free_finger_holds_whatever_hysteresis_teaches_it(layout: SensorLayout) -> None:
    """Of twenty sets of sensors, while the finger closes and opens twice; it bends a twentieth less than assumed."""
    period, errors = 0.05, StrainErrors(hysteresis=0.01, gain_error=0.01, noise=NOISE)
    pressure = np.tile(75e3 * (1 - np.cos(2 * np.pi * np.arange(0, 4, period) / 4)), 2)
    q = resting_angles(layout.finger, pressure, np.full(pressure.shape, DOWN))
    ratios = np.repeat(extension_ratios(layout, q)[:, None], 20, axis=1)
    readings = layout.response.reading(disturb(errors, ratios, period, rng(1)))
    assumed = SensorLayout(softened(layout.finger, 1.05), 2, borders=layout.borders)
    shape = RecursiveShape(assumed, uncertainty_of(errors, None, 0.05), period)
    driving = np.repeat(layout.finger.pressure_torque(pressure)[:, None], 20, axis=1)
    found = shape(readings, driving, np.broadcast_to(vector(DOWN), (len(q), 20, 3)))
    off = 1e-3 * tip_errors(layout.finger, q[:, None], found.q)
    band = position_std(layout.finger, found.q, found.covariance)[..., -1]
    late = slice(20, None)
    assert 0.9 < np.mean(off[late] <= 1.96 * band[late]) < 0.995
    assert np.mean(off) < 0.6e-3


def test_gains_and_bend_are_never_less_known_than_declared(layout: SensorLayout) -> None:
    """After ten minutes in which nothing is read, whose walks alone would come as far as 2.4 %."""
    shape = RecursiveShape(layout, Uncertainty(gain=0.01, bend_per_pressure=0.005), period=6.0)
    known, nothing = shape.begin(), np.full(layout.readings, np.nan)
    for _ in range(100):
        known = shape.step(known, nothing, layout.straight, np.zeros(3))
    changes = shape.changes(known)
    assert float(changes.bend_change_std) == pytest.approx(0.005)
    np.testing.assert_allclose(changes.gain_changes_std, 0.01)


def test_a_load_is_estimated_with_what_is_slow_counted_and_kept(learner: Learner) -> None:
    """Schmidt's filter: the gain is that of all states, of which only the load moves; the load may jump by a fifth."""
    load = np.array([0.05, -0.01, 0.005, 0.0, 0.0])
    wrong = learner.columns[:, :5] @ load
    known, variances = stepped(learner, wrong), before(learner)
    assert known.loaded
    jump = np.concatenate([0.2**2 * variances[:5] / (1 + PERIOD * 0.15**2), np.zeros(len(variances) - 5)])
    results = []
    for variance in (variances, variances + jump):
        spread = (learner.columns * variance) @ learner.columns.T + NOISE**2 * np.eye(len(wrong))
        results.append(variance[:5] * (learner.columns[:, :5].T @ np.linalg.solve(spread, wrong)))
    np.testing.assert_array_equal(known.mean[5:], 0.0)
    assert min(np.abs(known.mean[:5] - each).max() / np.abs(each).max() for each in results) < 0.02


def test_a_load_that_jumps_is_believed_to_have_done_so(learner: Learner) -> None:
    """Even where it was next to certain that there was none: by a fifth of a usual one."""
    begin = learner.shape.begin()
    covariance, variances = begin.covariance.copy(), before(learner)
    covariance[:5, :5] *= 1e-6
    variances[:5] *= (1e-6 + PERIOD * 0.15**2 + 0.2**2) / (1 + PERIOD * 0.15**2)
    wrong = learner.columns[:, :5] @ np.array([0.05, -0.01, 0.005, 0.0, 0.0])
    known = stepped(learner, wrong, begin._replace(covariance=covariance))
    spread = (learner.columns * variances) @ learner.columns.T + NOISE**2 * np.eye(len(wrong))
    expected = variances[:5] * (learner.columns[:, :5].T @ np.linalg.solve(spread, wrong))
    np.testing.assert_allclose(known.mean[:5], expected, atol=0.02 * np.abs(expected).max())


def test_a_difference_that_lasts_is_a_load_though_each_sample_could_be_noise(layout: SensorLayout) -> None:
    """Half as large again as the noise: an average of many samples has a fifth of it."""
    learner = learner_of(layout, Uncertainty(reading=NOISE, bend_per_pressure=0.0))
    wrong, known, loaded = 1.5 * NOISE * np.array([1.0, -1.0, 1.0, -1.0]), learner.shape.begin(), []
    for _ in range(20):
        known = stepped(learner, wrong, known)
        loaded.append(bool(known.loaded))
    assert not any(loaded[:2])
    assert any(loaded)


def test_a_reading_that_is_missing_or_an_outlier_counts_for_nothing(learner: Learner) -> None:
    """As if the sensor were not there: the others alone are fitted."""
    for lost in (np.nan, 0.5):
        wrong = WRONG.copy()
        wrong[0] = lost  # the inner path, which hardly reads the bend: the section is not blind
        known, slow = stepped(learner, wrong), SLOW
        variances, sizes = before(learner)[slow], np.sqrt(before(learner)[slow])
        rows = np.vstack([np.diag(1 / sizes), learner.columns[1:, slow] / (np.sqrt(30) * NOISE)])
        right = np.concatenate([np.zeros(len(variances)), WRONG[1:] / (np.sqrt(30) * NOISE)])
        expected = np.linalg.lstsq(rows, right, rcond=None)[0]
        np.testing.assert_allclose(known.mean[slow] / sizes, expected / sizes, rtol=0.02, atol=5e-4)
        assert known.difference[0] == 0.0
        np.testing.assert_allclose(known.difference[1:], 0.1 * WRONG[1:], rtol=1e-6)


def test_a_finger_that_is_not_seen_counts_as_loaded_after_five_samples(learner: Learner) -> None:
    blind, known, loaded = np.array([0.0, 0.0, 0.0, np.nan]), stepped(learner, np.zeros(4)), []
    for _ in range(8):
        known = stepped(learner, blind, known)
        loaded.append(bool(known.loaded))
    assert not any(loaded[:4])
    assert any(loaded[4:6])


def test_a_load_ends_later_than_it_begins(learner: Learner) -> None:
    """Differences that last, of rising size: between the two limits a finger stays what it was, free or loaded."""
    wrong = np.linspace(0, 6e-3, 400)[:, None] * np.array([1.0, -1.0, 1.0, -1.0])
    lasting = learner.shape.begin((400,))._replace(difference=wrong)
    free, loaded = (
        stepped(learner, wrong, lasting._replace(loaded=np.full(400, flag))).loaded for flag in (False, True)
    )
    assert not loaded[0]
    assert free[-1]
    assert 0.4 * loaded.sum() < free.sum() < 0.95 * loaded.sum()


def test_the_covariance_of_the_angles_counts_what_no_state_explains(layout: SensorLayout) -> None:
    found = [learner_of(layout, replace(UNCERTAIN, angle=angle)) for angle in (0.0, 5e-3)]
    exact, doubted = (each.shape.estimate(each.shape.begin(), each.driving).covariance for each in found)
    np.testing.assert_allclose(doubted - exact, 25e-6 * np.eye(12), atol=1e-12)


@pytest.mark.parametrize("ratio", [0.9, 1.1])
def test_a_loaded_finger_of_another_stiffness_has_the_shape_that_is_read(shipped_finger, ratio):
    """Loaded from the first sample, and bent further in steps: what it bends further than nominal is never learnt."""
    true, assumed = SensorLayout(shipped_finger, 4), SensorLayout(softened(shipped_finger, ratio), 4)
    shape, load = RecursiveShape(assumed, Uncertainty(bend_per_pressure=0.1)), -0.03 * np.linspace(1, 0, 12)
    known = shape.begin()
    for pressure in np.repeat([50e3, 100e3, 150e3], 40):
        driving = shipped_finger.pressure_torque(pressure)
        q = (driving + load) / shipped_finger.stiffness
        known = shape.step(known, true.read(q), assumed.finger.pressure_torque(pressure), np.zeros(3))
    assert known.loaded
    assert shape.changes(known).bend_change == 0
    assert tip_errors(shipped_finger, q, known.q) < 0.1, "mm; as gaussian has"


def test_the_covariance_of_a_loaded_shape_holds_in_every_direction(shipped_finger):
    """Loads drawn from their prior: errors squared, normalised by their covariance, are 1 for each joint in the mean.

    A load has more modes than the filter has states: without their bends, errors along them count fiftyfold.
    """
    layout, draws, random = SensorLayout(shipped_finger, 4), 200, rng(3)
    shape = RecursiveShape(layout, Uncertainty(reading=NOISE), PERIOD)
    straight = shape.mechanics.bent_finger(layout.straight)
    covariance = shape.mechanics.load_covariance(straight, layout.straight)
    root = np.linalg.cholesky(covariance + 1e-15 * np.eye(shipped_finger.segments))
    loaded = random.normal(size=(draws, len(root))) @ root.T
    q = np.concatenate([np.zeros((20, *loaded.shape)), np.tile(loaded, (250, 1, 1))])
    noise = random.normal(0, NOISE, (*q.shape[:-1], layout.readings))
    state = shape.begin((draws,))
    for sample in layout.response.reading(1 + layout.predict(q) + noise):
        state = shape.step(state, sample, np.zeros_like(loaded), np.zeros(3))
    estimate, is_loaded = shape.estimate(state, np.zeros_like(loaded)), state.loaded
    assert is_loaded.mean() > 0.9
    variances, directions = np.linalg.eigh(estimate.covariance[is_loaded])
    errors = (np.swapaxes(directions, -1, -2) @ (estimate.q - loaded)[is_loaded][..., None])[..., 0]
    squares = (errors**2 / variances).mean(axis=0)
    assert 0.5 < squares.mean() < 1.7
    assert squares.max() < 5


@pytest.mark.parametrize("ratio", [0.9, 1.1])
def test_a_force_is_that_of_the_stiffness_that_free_motion_teaches(shipped_finger, ratio):
    """Bends of a softer finger are due to less force; by the nominal stiffness it would be wrong by a tenth."""
    finger, forces, places = softened(shipped_finger, ratio), [0.4, 0.8], np.array([0.08, 0.105])
    layout, period = SensorLayout(shipped_finger, 3), 0.05
    pressure = np.append(60e3 * (1 - np.cos(2 * np.pi * np.arange(0, 12, period) / 6)), np.full(40, 90e3))
    q = np.repeat(resting_angles(finger, pressure, np.full(pressure.shape, DOWN))[:, None], 2, axis=1)
    q[-40:] = [in_balance(finger, 90e3, DOWN, [Push(*push)]) for push in zip(places, forces, strict=True)]
    driving = np.repeat(shipped_finger.pressure_torque(pressure)[:, None], 2, axis=1)
    gravity = np.broadcast_to(vector(DOWN), (*driving.shape[:2], 3))
    contact = (
        RecursiveShape(layout, Uncertainty(), period)
        .at(np.array([len(q) - 1]), layout.read(q), driving, gravity)
        .contact
    )
    np.testing.assert_allclose(contact.force[0], forces, rtol=0.04)
    np.testing.assert_allclose(contact.arc_length[0], places, atol=4e-3)


def test_the_lag_of_a_finger_that_moves_teaches_nothing():
    """A step of pressure bends it unevenly for a while; sensors are ideal, and the model is exact."""
    data = simulate(load_scenario("box_grasp", ["estimator.type=recursive"])).data
    assert float(np.abs(data["left_finger.bend_change"]).max()) < 0.02
    force, true = (data[f"left_finger.{name}"].values[-1] for name in ("transverse_force", "true_transverse_force"))
    np.testing.assert_allclose(force, true, rtol=0.02)
