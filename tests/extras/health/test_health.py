"""Health: each fault is named, healthy fingers are not blamed, and dropped readings count for nothing."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.special import chdtri
from scipy.stats import multivariate_normal

from soft_gripper.diagrams.simulation import simulate
from soft_gripper.errors import InputError
from soft_gripper.estimators.uncertainty import Uncertainty, uncertainty_of
from soft_gripper.extras.health.faults import FAULTS, Hypotheses
from soft_gripper.extras.health.health_filter import (
    _JUMP_PROBABILITY,
    _MAX_MISFIT,
    WINDOW_SAMPLES,
    HealthFilter,
    _Observation,
    _update_states,
)
from soft_gripper.extras.health.health_monitor import named_fault
from soft_gripper.fingers.kinematics import gravity_torque, in_space
from soft_gripper.scenario.scenario_file import load_scenario
from soft_gripper.sensors.calibrated_states import CalibratedStates
from soft_gripper.sensors.fitted_states import FittedStates, Widths
from soft_gripper.sensors.sensor_layout import SensorLayout
from soft_gripper.sensors.strain_errors import SensorFault, StrainErrors, disturb

PERIOD, GRAVITY = 0.01, 9.81 + 0j  # s, m/s^2: the finger hangs
REALISTIC = StrainErrors(hysteresis=0.01, gain_error=0.01, drift=0.001, noise=0.002)
ONSET = 2.5  # s


@pytest.fixture(scope="module")
def layout(shipped_finger):
    return SensorLayout(shipped_finger, 4)


def pressures(seed, steps=7):
    """A new pressure every second, smoothed, Pa, (T,)."""
    command = np.repeat(np.append(0.0, np.random.default_rng(seed).uniform(20e3, 130e3, steps - 1)), 100)
    lagging = np.zeros(len(command))
    for i in range(1, len(command)):
        lagging[i] = lagging[i - 1] + 0.1 * (command[i] - lagging[i - 1])
    return lagging


def free_angles(finger, pressure):
    """Joint angles of a finger that touches nothing, (T, N)."""
    q = np.zeros((len(pressure), finger.segments))
    for _ in range(20):
        q = finger.angle(finger.pressure_torque(pressure) + gravity_torque(finger, q, np.full((1, 1), GRAVITY)))
    return q


def probabilities(layout, readings, pressure, errors=REALISTIC, share=0.005):
    """Of FAULTS after every window, (L, 8); `share` is the uncertainty of the bend per pressure."""
    assumed = replace(uncertainty_of(errors), bend_per_pressure=share)
    health, found = HealthFilter(layout, assumed, PERIOD), []
    memory = health.begin()
    for i, (sample, inside) in enumerate(zip(readings, pressure, strict=True), start=1):
        memory = health.step(memory, sample, layout.finger.pressure_torque(inside), in_space(np.array(GRAVITY)))
        if i % WINDOW_SAMPLES == 0:
            found.append(health.probabilities(memory))
    return np.array(found)


def read(layout, pressure, errors, seed):
    ratios = layout.response.ratio(layout.read(free_angles(layout.finger, pressure)))
    return layout.response.reading(disturb(errors, ratios, PERIOD, np.random.default_rng(seed)))


@pytest.mark.slow
@pytest.mark.parametrize(
    "errors", [StrainErrors(), StrainErrors(noise=1e-3), REALISTIC, StrainErrors(quantization=1e-3)]
)
def test_a_healthy_finger_is_not_blamed(layout, errors):
    """Drawn errors of several kinds of sensors, of which some repeat themselves for long."""
    for seed in range(3):
        pressure = pressures(seed)
        assert not named_fault(probabilities(layout, read(layout, pressure, errors, seed), pressure, errors)).any()


@pytest.mark.parametrize("softer", [0.9, 1.1])
def test_a_finger_that_is_not_as_stiff_as_declared_is_not_blamed(layout, softer):
    """By twice the standard deviation declared; with an exact model declared the same finger has a fault."""
    pressure = pressures(0)
    ratios = layout.response.ratio(layout.read(softer * free_angles(layout.finger, pressure)))
    readings = layout.response.reading(disturb(REALISTIC, ratios, PERIOD, np.random.default_rng(0)))
    blamed = [named_fault(probabilities(layout, readings, pressure, share=share)).any() for share in (0.05, 0.002)]
    assert blamed == [False, True]


@pytest.mark.parametrize(
    ("kind", "reading", "size", "name"),
    [
        ("dead", 5, None, "dead"),
        ("dead", 1, 0.0, "dead"),
        ("offset", 6, 0.04, "slipped"),
        ("offset", 2, -0.04, "slipped"),
        ("loose", 6, 0.6, "slipped"),
        ("drifting", 3, 0.01, "drifting"),
        ("drifting", 4, -0.015, "drifting"),
        ("saturated", 6, 0.05, "saturated"),
    ],
)
def test_a_fault_of_a_sensor_is_named(layout, kind, reading, size, name):
    pressure = pressures(5)
    errors = replace(REALISTIC, faults=(SensorFault(kind, reading, ONSET, size),))
    found = named_fault(probabilities(layout, read(layout, pressure, errors, 5), pressure))
    before = round(ONSET / PERIOD) // WINDOW_SAMPLES
    assert not found[:before].any()
    assert FAULTS[int(found[-1])] == name


def test_a_leak_is_named(layout):
    pressure = pressures(2)
    reached = np.where(np.arange(len(pressure)) * PERIOD < ONSET, pressure, 0.6 * pressure)
    found = named_fault(probabilities(layout, read(layout, reached, REALISTIC, 2), pressure))
    assert FAULTS[int(found[-1])] == "leak"


def test_a_softer_part_is_named(layout):
    """The compliance of the outer half is 2.2 times what was built."""
    finger, pressure = layout.finger, pressures(3)
    softer = np.where(np.arange(finger.segments) < finger.segments // 2, 1.0, 2.2)
    ratios = layout.response.ratio(layout.read(softer * free_angles(finger, pressure)))
    readings = layout.response.reading(disturb(REALISTIC, ratios, PERIOD, np.random.default_rng(3)))
    assert FAULTS[int(named_fault(probabilities(layout, readings, pressure))[-1])] == "cut"


def test_a_finger_whose_drive_leaves_its_calibration_is_not_blamed(layout):
    """It bends up to a fifth further above 60 kPa, where the monitor is told that less is known."""
    inside = np.linspace(0, 60e3, 13)
    drive = np.column_stack([layout.finger.pressure_torque(inside)[:, 0], 0 * inside, 9.81 + 0 * inside])
    states = np.hstack([layout.measured(layout.read(free_angles(layout.finger, inside))), drive])
    fitted = FittedStates(states, np.append(np.full(layout.readings, 0.03), [np.std(drive[:, 0]), 9.81, 9.81]))
    calibrated = CalibratedStates(fitted, Widths(np.array([1e-3]), 0.03), np.inf, layout.sections)
    pressure, blamed = pressures(1, steps=4), []
    further = 1 + 0.2 * np.maximum(pressure - 60e3, 0) / 60e3
    ratios = layout.response.ratio(layout.read(further[:, None] * free_angles(layout.finger, pressure)))
    readings = layout.response.reading(disturb(REALISTIC, ratios, PERIOD, np.random.default_rng(1)))
    for states_of in (calibrated, None):
        blamed.append(named_fault(probabilities(replace(layout, calibrated=states_of), readings, pressure)).any())
    assert blamed == [False, True]


def test_what_a_look_shows_of_a_cut_is_linearised(layout):
    """By finite differences of the readings of a finger that is softer from a joint on, by its part of the state."""
    health, q = HealthFilter(layout), np.linspace(0.03, 0.02, layout.finger.segments)
    hypotheses, values = health.hypotheses, len(layout.matrix)
    cut = hypotheses.indices_of("cut")[3]
    state = np.zeros((2, len(hypotheses.kind), 2 * values + layout.readings + 3))
    load, softer, more = np.linspace(-0.02, 0.05, values), 1.4, 0.1
    f, g = values + layout.readings, values + layout.readings + 2
    state[:, cut, :values], state[:, cut, f], state[:, cut, g] = load, softer, more
    from_cut = np.arange(len(q)) >= hypotheses.joint[cut]
    driving = layout.finger.pressure_torque(60e3)
    driven = layout.matrix @ (driving / layout.finger.stiffness)

    def readings(load, softer, more=more):
        bends = load + more * driven
        bent = layout.matrix @ (softer * from_cut * (q + np.linalg.pinv(layout.matrix) @ bends))
        return layout.predict(q) + hypotheses.load_response @ (bends + bent)

    memory = health.begin()
    memory = memory._replace(sums=memory.sums + np.array([[0], [WINDOW_SAMPLES], [0], [WINDOW_SAMPLES]]))
    window = health._summarize(memory, q, np.zeros(values), np.zeros(layout.readings))
    window = window._replace(measured=readings(load, softer))
    found, step = health._observation(state, window, q, health._bend_map(q, driving)), 1e-6
    by_load = [(readings(load + step * e, softer) - window.measured) / step for e in np.eye(values)]
    np.testing.assert_allclose(found.state_map[0, cut][:, :values], np.transpose(by_load), atol=1e-6)
    by_size = (readings(load, softer + step) - window.measured) / step
    np.testing.assert_allclose(found.state_map[0, cut][:, f], by_size, atol=1e-6)
    by_more = (readings(load, softer, more + step) - window.measured) / step
    np.testing.assert_allclose(found.state_map[0, cut][:, g], by_more, atol=1e-6)
    left = found.values[0, cut] - found.state_map[0, cut] @ state[0, cut]
    np.testing.assert_allclose(left, 0, atol=1e-12)
    expected = health.uncertainty.reading**2 / WINDOW_SAMPLES + (1e-4 * hypotheses.full_scale) ** 2
    np.testing.assert_allclose(np.diagonal(found.noise[0]), expected)


SHORT = ["pressure.steps.all=[0, 60e3, 20e3]", "pressure.settle=0.9", "pressure.hold_samples=10", "record.truth=forces"]
WATCHED = [*SHORT, "sensor.errors.preset=realistic", "estimator.type=gaussian", "estimator.health=true"]


def test_a_run_names_the_faults_of_both_fingers_and_drops_the_sensor():
    fault = "sensor.faults=[{kind: offset, finger: left_finger, section: 2, time: 1.5, size: 0.05}]"
    faults = [*WATCHED, fault, "pressure.leaks={right_finger: 0.4}", "pressure.leak_time=1.3"]
    recording, unwatched = (
        simulate(load_scenario("free_bending", [*faults, *more])) for more in ([], ["estimator.health=false"])
    )
    for finger, name in (("left_finger", "slipped"), ("right_finger", "leak")):
        found = recording[f"{finger}.fault"].values
        assert not found[:120].any()
        assert FAULTS[int(found[-1])] == name
    usable = recording["left_finger.usable_strain"].values[-1]
    assert np.isnan(usable[1, 2])
    assert np.isfinite(usable).sum() == 7
    late = slice(200, None)
    error, without = (run["left_finger.fingertip_error"].values[late].mean() for run in (recording, unwatched))
    assert error < without / 2
    band = recording["left_finger.position_std"].values[:, -1]
    assert band[-1] > 1.2 * band[100]


def test_it_refuses_a_finger_in_space():
    changes = ["estimator.health=true", "estimator.type=gaussian", "sensor.layout=four_faces"]
    with pytest.raises(InputError, match=r"estimator.*health.*bend in their plane"):
        simulate(load_scenario("turned_box_grasp", changes))


def test_errors_of_gains_grow_with_the_strain_and_drift_with_time(layout):
    """A sensor whose gain is off by g errs by g times the change of its strain, and no more at rest."""
    share, torque = 0.03, layout.finger.pressure_torque(60e3)
    q = layout.finger.angle(torque)
    moved = layout.predict(q) - layout.predict(0 * q)
    values = len(layout.matrix)
    lasting = np.arange(values, values + layout.readings)

    def variances(gain, change, drift=0.0):
        health = HealthFilter(layout, Uncertainty(gain=gain, drift=drift), PERIOD)
        memory = health.begin()
        both = [np.stack([part, part]) for part in memory[:2]]
        return health._predict(*both, change, 0.1, memory.age)[1][0][..., lasting, lasting]

    grown = variances(share, layout.matrix @ q) - variances(0.0, layout.matrix @ q)
    np.testing.assert_allclose(grown, np.broadcast_to((share * moved) ** 2, grown.shape), rtol=1e-3)
    at_rest = np.zeros(values)
    np.testing.assert_array_equal(variances(share, at_rest), variances(0.0, at_rest))
    drifted = variances(0.0, at_rest, drift=1e-3) - variances(0.0, at_rest)
    np.testing.assert_allclose(drifted, 1e-3**2 * WINDOW_SAMPLES * PERIOD, rtol=1e-6)


def of_contact(layout, load, softer=None):
    """Evidence per second of every hypothesis if the healthy finger bears `load`, rad, and the others none, (K,).

    A cut finger that is `softer` by a share of the compliance bears it too.
    """
    health, values = HealthFilter(layout, Uncertainty(), PERIOD), len(layout.matrix)
    memory, evidence = health.begin(), np.ones(len(health.hypotheses.kind))
    mean = np.zeros_like(memory.mean)
    mean[0, :values] = load
    mean[health.hypotheses.indices_of("held"), :values] = load
    if softer is not None:
        (
            mean[health.hypotheses.indices_of("cut"), :values],
            mean[health.hypotheses.indices_of("cut"), values + layout.readings],
        ) = (
            load,
            softer,
        )
    covariance = 1e-6 * np.eye(mean.shape[1]) + np.zeros_like(memory.covariance)
    q = layout.finger.angle(layout.finger.pressure_torque(60e3))
    return health.hypotheses, health._contact_evidence(mean, covariance, q, evidence) / (WINDOW_SAMPLES * PERIOD)


def test_the_evidence_of_a_load_is_that_of_one_look_a_second(layout):
    """exp(-X / 2), up to a limit; what noise leaves of one contact is held by chance at most, and more is not."""
    misfits, held = [], []
    for size in np.geomspace(1e-3, 1.0, 24):
        hypotheses, found = of_contact(layout, size * np.array([1.0, -1.0, 1.0, -1.0]))
        misfits += [2 * found[hypotheses.indices_of("offset")[0]]]
        held += [found[hypotheses.indices_of("held")[0]]]
    misfits, held = np.array(misfits), np.array(held)
    by_chance, hardly = misfits < chdtri(2, 0.05), misfits > chdtri(2, 1e-3)
    assert by_chance.sum() > 2
    assert hardly.sum() > 2
    np.testing.assert_allclose(held[by_chance], 0, atol=1e-12)
    assert (held[hardly] > 0).all()
    assert misfits.max() == pytest.approx(_MAX_MISFIT)


def test_a_load_may_be_further_from_one_contact_the_more_a_cut_changes(layout):
    hypotheses, *found = of_contact(layout, 0.03 * np.array([1.0, -1.0, 1.0, -1.0]), 0.0)
    for softer in (0.5, 1.0):
        found += [of_contact(layout, 0.03 * np.array([1.0, -1.0, 1.0, -1.0]), softer)[1]]
    as_healthy, less, more = np.array(found)[:, hypotheses.indices_of("cut")]
    np.testing.assert_allclose(as_healthy, 0, atol=1e-9)
    assert (less > 0.1).all()
    assert (more > less).all()


def test_a_load_that_follows_the_drive_is_likelier_than_one_that_jumps():
    """The likelihood of a window is that of a normal density with the odds of its load, and the likelier one counts."""
    rng, states, readings = np.random.default_rng(0), 3, 2
    H, noise, mean = rng.normal(size=(1, 1, readings, states)), np.eye(readings)[None], np.zeros((1, 1, states))
    covariance = np.stack([np.eye(states), 4 * np.eye(states)])[:, None, None]
    chosen = []
    for size in np.linspace(0, 8, 30):
        z = size * np.array([0.8, -0.6])
        found = _update_states(mean, covariance, _Observation(H, z[None, None], noise))
        spreads = [H[0, 0] @ each[0, 0] @ H[0, 0].T + noise[0] for each in covariance]
        densities = [multivariate_normal(np.zeros(readings), spread).logpdf(z) for spread in spreads]
        logs = np.array(densities) + np.log([1 - _JUMP_PROBABILITY, _JUMP_PROBABILITY])
        expected = logs.max() + readings / 2 * np.log(2 * np.pi)
        assert found.log_likelihood[0, 0] == pytest.approx(expected)
        chosen += [int(logs.argmax())]
        gain = covariance[chosen[-1], 0, 0] @ H[0, 0].T @ np.linalg.inv(spreads[chosen[-1]])
        np.testing.assert_allclose(found.mean[0, 0], gain @ z, atol=1e-12)
        after = covariance[chosen[-1], 0, 0] - gain @ H[0, 0] @ covariance[chosen[-1], 0, 0]
        np.testing.assert_allclose(found.covariance[0, 0], after, atol=1e-12)
    assert chosen == sorted(chosen)
    assert set(chosen) == {0, 1}
    assert _JUMP_PROBABILITY < 0.1  # seldom: not even once a second


def test_a_healthy_finger_is_blamed_less_than_once_a_year(layout):
    """The likelihood ratio since any onset is a martingale, which exceeds 1 / p with a probability of p at most."""
    windows = 365 * 86400 / (WINDOW_SAMPLES * PERIOD)
    odds = np.exp(Hypotheses(layout).log_prior[1:]).sum()
    assert windows * odds < 1


def test_samples_at_which_a_reading_repeats_itself_or_changes_are_counted(layout):
    """A sample counts where it was read; one at which no reading changes says nothing of repetitions."""
    health = HealthFilter(layout, Uncertainty(reading=2e-3), PERIOD)
    memory, rng = health.begin(), np.random.default_rng(6)
    readings = np.tile(layout.read(layout.straight), (3 * WINDOW_SAMPLES, 1))
    readings[:, 1:] += 1e-3 * rng.standard_normal((3 * WINDOW_SAMPLES, layout.readings - 1))
    readings[::3, 2] = np.nan
    for sample in readings:
        memory = health.step(memory, sample, np.zeros(layout.finger.segments), np.zeros(3))
    repeated, changed = memory.counts
    later = 3 * WINDOW_SAMPLES - 1  # the first has none before it
    np.testing.assert_array_equal(repeated, [later, *[0] * (layout.readings - 1)])
    assert changed[0] == 0
    np.testing.assert_array_equal(changed[3:], later)
    assert changed[2] == np.isfinite(readings[1:, 2]).sum() - 1


@pytest.mark.parametrize("hostile", [np.nan, np.inf, 1e308])
@pytest.mark.parametrize("which", [0, 1, 2])  # readings, driving torque, gravity
@pytest.mark.filterwarnings("ignore::RuntimeWarning")
def test_inputs_that_are_not_finite_leave_nothing_behind(layout, hostile, which):
    """A window later every probability is a number again, and the finger is as healthy as before."""
    health = HealthFilter(layout, replace(uncertainty_of(REALISTIC), bend_per_pressure=0.005), PERIOD)
    memory, still = health.begin(), (layout.read(layout.straight), np.zeros(layout.finger.segments), np.zeros(3))
    for number in range(4 * WINDOW_SAMPLES):
        sample = [part.copy() for part in still]
        if number == WINDOW_SAMPLES + 3:
            sample[which][0] = hostile
        memory = health.step(memory, *sample)
    assert np.isfinite(health.sensor_probabilities(memory)).all()
    assert health.probabilities(memory)[0] > 0.5
