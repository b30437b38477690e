"""Health: each fault is named, healthy fingers are not blamed, and dropped readings count for nothing."""

from dataclasses import replace

import numpy as np
import pytest
from refusals import refused

from soft_gripper.diagrams.simulation import simulate
from soft_gripper.errors import InputError
from soft_gripper.estimators.contact import ContactShape
from soft_gripper.estimators.faults import FAULTS, Hypotheses
from soft_gripper.estimators.gaussian import GaussianShape
from soft_gripper.estimators.health import LOOK, HealthFilter
from soft_gripper.estimators.health_monitor import HealthMonitor, named
from soft_gripper.estimators.uncertainty import Uncertainty, uncertainty_of
from soft_gripper.fingers.kinematics import gravity_torque
from soft_gripper.scenario.scenario_file import load_scenario
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
    """Of FAULTS after every look, (L, 8); `share` is the uncertainty of the bend per pressure."""
    assumed = replace(uncertainty_of(errors), bend_per_pressure=share)
    health, found = HealthFilter(layout, assumed, PERIOD), []
    known = health.begin()
    for i, (sample, inside) in enumerate(zip(readings, pressure, strict=True), start=1):
        known = health.step(known, sample, layout.finger.pressure_torque(inside), GRAVITY)
        if i % LOOK == 0:
            found.append(health.probabilities(known))
    return np.array(found)


def read(layout, pressure, errors, seed):
    ratios = layout.response.ratio(layout.read(free_angles(layout.finger, pressure)))
    return layout.response.reading(disturb(errors, ratios, PERIOD, np.random.default_rng(seed)))


def test_a_cut_may_begin_at_every_half_of_a_section_and_nowhere_else(layout):
    """Four sections of three joints each."""
    hypotheses = Hypotheses(layout)
    assert hypotheses.joint[hypotheses.of("cut")].tolist() == [0, 1, 3, 4, 6, 7, 9, 10]


@pytest.mark.slow
@pytest.mark.parametrize(
    "errors", [StrainErrors(), StrainErrors(noise=1e-3), REALISTIC, StrainErrors(quantization=1e-3)]
)
def test_a_healthy_finger_is_not_blamed(layout, errors):
    """Drawn errors of several kinds of sensors, of which some repeat themselves for long."""
    for seed in range(3):
        pressure = pressures(seed)
        assert not named(probabilities(layout, read(layout, pressure, errors, seed), pressure, errors)).any()


@pytest.mark.parametrize("softer", [0.9, 1.1])
def test_a_finger_that_is_not_as_stiff_as_declared_is_not_blamed(layout, softer):
    """By twice the standard deviation declared; with an exact model declared the same finger has a fault."""
    for seed in range(2):
        pressure = pressures(seed)
        ratios = layout.response.ratio(layout.read(softer * free_angles(layout.finger, pressure)))
        readings = layout.response.reading(disturb(REALISTIC, ratios, PERIOD, np.random.default_rng(seed)))
        blamed = [named(probabilities(layout, readings, pressure, share=share)).any() for share in (0.05, 0.002)]
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
    found = named(probabilities(layout, read(layout, pressure, errors, 5), pressure))
    before = round(ONSET / PERIOD) // LOOK
    assert not found[:before].any()
    assert FAULTS[int(found[-1])] == name


def test_a_leak_is_named(layout):
    pressure = pressures(2)
    reached = np.where(np.arange(len(pressure)) * PERIOD < ONSET, pressure, 0.6 * pressure)
    found = named(probabilities(layout, read(layout, reached, REALISTIC, 2), pressure))
    assert FAULTS[int(found[-1])] == "leak"


def test_a_softer_part_is_named(layout):
    """The compliance of the outer half is 2.2 times what was built."""
    finger, pressure = layout.finger, pressures(3)
    softer = np.where(np.arange(finger.segments) < finger.segments // 2, 1.0, 2.2)
    ratios = layout.response.ratio(layout.read(softer * free_angles(finger, pressure)))
    readings = layout.response.reading(disturb(REALISTIC, ratios, PERIOD, np.random.default_rng(3)))
    assert FAULTS[int(named(probabilities(layout, readings, pressure))[-1])] == "cut"


def test_what_a_look_shows_of_a_cut_is_linearised(layout):
    """By finite differences of the readings of a finger that is softer from a joint on, by its part of the state."""
    health, q = HealthFilter(layout), np.linspace(0.03, 0.02, layout.finger.segments)
    hypotheses, values = health.hypotheses, len(layout.matrix)
    cut = hypotheses.of("cut")[3]
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
        return layout.predict(q) + hypotheses.by_load @ (bends + bent)

    known = health.begin()
    look = health._seen(known._replace(sums=known.sums + np.array([[0], [LOOK], [0], [LOOK]])), q, np.zeros(values))
    look = look._replace(measured=readings(load, softer))
    found, step = health._observation(state, look, q, health._beyond_free(q, driving)), 1e-6
    by_load = [(readings(load + step * e, softer) - look.measured) / step for e in np.eye(values)]
    np.testing.assert_allclose(found.by_state[0, cut][:, :values], np.transpose(by_load), atol=1e-6)
    by_size = (readings(load, softer + step) - look.measured) / step
    np.testing.assert_allclose(found.by_state[0, cut][:, f], by_size, atol=1e-6)
    by_more = (readings(load, softer, more + step) - look.measured) / step
    np.testing.assert_allclose(found.by_state[0, cut][:, g], by_more, atol=1e-6)
    left = found.values[0, cut] - found.by_state[0, cut] @ state[0, cut]
    np.testing.assert_allclose(left, 0, atol=1e-12)


def test_a_reading_that_is_lost_for_good_is_dead(layout):
    pressure = pressures(1, 4)
    readings = read(layout, pressure, REALISTIC, 1)
    readings[250:, 5] = np.nan
    assert FAULTS[int(named(probabilities(layout, readings, pressure))[-1])] == "dead"


def test_samples_that_are_lost_now_and_then_are_no_fault(layout):
    errors, pressure = replace(REALISTIC, dropout=0.1), pressures(1, 4)
    assert not named(probabilities(layout, read(layout, pressure, errors, 1), pressure, errors)).any()


def test_a_loose_strand_at_the_base_looks_like_a_force_there(layout):
    """Not found: a force within the first section bends nothing else, so that no reading contradicts it."""
    pressure = pressures(4)
    errors = replace(REALISTIC, faults=(SensorFault("loose", 4, ONSET, 0.5),))
    found = probabilities(layout, read(layout, pressure, errors, 4), pressure)
    further = replace(REALISTIC, faults=(SensorFault("loose", 6, ONSET, 0.5),))
    assert found[-1, 0] > probabilities(layout, read(layout, pressure, further, 4), pressure)[-1, 0]


def test_what_is_dropped_counts_for_nothing(layout):
    """The oracle conditions a dense Gaussian on the readings that are left."""
    finger, assumed = layout.finger, Uncertainty(reading=2e-3)
    driving = finger.pressure_torque(np.array(90e3))
    q0 = finger.angle(driving)
    readings = layout.read(q0 + 0.001 * np.sin(np.arange(finger.segments)))
    wrong, dropped = readings.copy(), readings.copy()
    wrong[5] += 0.05
    dropped[5] = np.nan
    estimate = GaussianShape(layout, assumed)
    found, spoilt, whole = (estimate(values, driving, 0j) for values in (dropped, wrong, readings))
    prior, kept = estimate.mechanics.prior(q0, q0, driving), np.arange(8) != 5
    A, sensitivity = np.tile(layout.matrix, (2, 1))[kept], layout.sensitivity.ravel()[kept]
    z = layout.inverse(layout.measured(readings).reshape(2, 4)).ravel()[kept]
    noise = np.diag((assumed.reading / sensitivity) ** 2)
    gain = prior @ A.T @ np.linalg.inv(A @ prior @ A.T + noise)
    q = q0 + gain @ (z - A @ q0)
    assert np.allclose(found.q, q, atol=1e-9)
    assert np.allclose(found.covariance, prior - gain @ A @ prior, atol=1e-12)
    assert np.abs(spoilt.q - whole.q).max() > 10 * np.abs(found.q - whole.q).max()
    assert np.trace(found.covariance) > np.trace(whole.covariance)
    assert np.isfinite(ContactShape(layout, assumed)(dropped, driving, 0j).q).all()


SHORT = ["pressure.steps.all=[0, 60e3, 20e3]", "pressure.settle=0.9", "pressure.hold_samples=10", "record.truth=forces"]
WATCHED = [*SHORT, "sensor.errors.preset=realistic", "estimator.type=gaussian", "estimator.health=true"]


def test_a_run_names_the_fault_and_drops_the_sensor():
    fault = "sensor.faults=[{kind: offset, finger: left_finger, section: 2, time: 1.5, size: 0.05}]"
    recording = simulate(load_scenario("free_bending", [*WATCHED, fault]))
    unwatched = simulate(load_scenario("free_bending", [*WATCHED, fault, "estimator.health=false"]))
    assert FAULTS[int(recording["left_finger.fault"].values[-1])] == "slipped"
    assert not recording["right_finger.fault"].values.any()
    usable = recording["left_finger.usable_strain"].values[-1]
    assert np.isnan(usable[1, 2])
    assert np.isfinite(usable).sum() == 7
    late = slice(200, None)
    error, without = (run["left_finger.fingertip_error"].values[late].mean() for run in (recording, unwatched))
    assert error < without / 2
    band = recording["left_finger.position_std"].values[:, -1]
    assert band[-1] > 1.2 * band[100]


def test_a_leak_of_a_run_is_named():
    leak = ["pressure.leaks={right_finger: 0.4}", "pressure.leak_time=1.3"]
    recording = simulate(load_scenario("free_bending", [*WATCHED, *leak]))
    assert FAULTS[int(recording["right_finger.fault"].values[-1])] == "leak"
    assert not recording["left_finger.fault"].values.any()


def test_every_kind_has_hypotheses(layout):
    hypotheses = Hypotheses(layout)
    assert set(hypotheses.kind) == set(range(len(FAULTS)))
    assert np.exp(hypotheses.log_prior[1:]).sum() == pytest.approx(hypotheses.usual.probability)


def test_it_refuses_a_finger_in_space():
    changes = ["estimator.health=true", "estimator.type=gaussian", "sensor.layout=four_faces"]
    with pytest.raises(InputError, match=r"estimator.*health.*bend in their plane"):
        simulate(load_scenario("turned_box_grasp", changes))


@pytest.mark.parametrize(
    ("override", "field"),
    [
        ("sensor.faults=[{kind: dead, section: 9}]", "sensor.faults[0].section"),
        ("sensor.faults=[{kind: dead, path: top}]", "sensor.faults[0].path"),
        ("sensor.faults=[{kind: broken}]", "sensor.faults[0].kind"),
        ("sensor.faults=[{kind: offset}]", "sensor.faults[0].size"),
        ("sensor.faults=[{kind: loose, size: 1.5}]", "sensor.faults[0].size"),
        ("pressure.leaks={all: 1.2}", "pressure.leaks.all"),
    ],
)
def test_faults_that_cannot_be(override, field):
    with refused(field):
        load_scenario("free_bending", [override])


@pytest.mark.parametrize("override", ["sensor.faults=[{finger: thumb}]", "pressure.leaks={thumb: 0.2}"])
def test_fingers_that_there_are_not(override):
    with pytest.raises(InputError, match="thumb"):
        simulate(load_scenario("free_bending", [*SHORT, override]))


def test_the_monitor_says_what_it_puts_out(layout):
    monitor = HealthMonitor(HealthFilter(layout), np.zeros(3))
    ports = {monitor.get_output_port(i).get_name() for i in range(monitor.num_output_ports())}
    assert ports == {"fault_probabilities", "fault", "sensor_fault", "usable_strain"}
