"""The lag of a free finger, and what `contact` states of a finger that moves: with Drake's plant as the truth."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from soft_gripper.diagrams.simulation import simulate
from soft_gripper.estimators.contact import ContactShape
from soft_gripper.estimators.force_posterior import MOVING, NOTHING
from soft_gripper.estimators.free_motion import FreeMotion, Lag
from soft_gripper.estimators.mechanics import Mechanics
from soft_gripper.estimators.uncertainty import Uncertainty
from soft_gripper.scenario.scenario_file import load_scenario
from soft_gripper.sensors.sensor_layout import SensorLayout
from studies.contacts.contacts import read_finger

PERIOD, G = 0.01, 9.81
EXACT, ASSUMED = "estimator.uncertainty={bend_per_pressure: 0.005}", Uncertainty(bend_per_pressure=0.005)
STEPS = [0.0, 80e3, 150e3, 30e3, 0.0]  # Pa
BEGINS = 0.5  # s, until a finger that begins straight rests under its weight


def motion_of(finger):
    return FreeMotion(Mechanics(SensorLayout(finger, 2), Uncertainty()), PERIOD)


def stepped(sections=2):
    steps = [f"pressure.steps.all={STEPS}", "pressure.settle=0.5", "pressure.hold_samples=10"]
    return load_scenario("free_bending", ["estimator.type=contact", EXACT, f"sensor.sections={sections}", *steps])


def test_a_step_is_that_of_the_differential_equation(shipped_finger):
    """M q'' + b K q' = K (p - q) , without weight, from rest; integrated by an independent solver."""
    finger, motion = shipped_finger, motion_of(shipped_finger)
    driving, K = finger.pressure_torque(100e3), np.diag(finger.stiffness)
    inverse, N = np.linalg.inv(finger.mass_matrix()), finger.segments

    def flow(_, state):
        q, rate = state[:N], state[N:]
        return np.concatenate([rate, inverse @ (driving - K @ q - finger.relaxation_time * K @ rate)])

    solved = solve_ivp(flow, (0, 20 * PERIOD), np.zeros(2 * N), "Radau", rtol=1e-9, atol=1e-10).y[:, -1]
    torques = np.concatenate([np.zeros((1, N)), np.broadcast_to(driving, (21, N))])  # at rest, then a step
    q, rate, _, rest = motion.motion_over_time(torques, np.zeros((22, 3)), np.zeros((22, 3)))[-1]
    np.testing.assert_allclose(np.concatenate([q, rate]), solved, atol=1e-6)
    np.testing.assert_allclose(rest, driving / finger.stiffness)
    lag = motion.lag(np.stack([q, rate, rest, rest]))
    np.testing.assert_allclose(lag.damping + lag.inertia, rest - q)


def test_a_finger_on_an_accelerated_base_hangs_as_under_another_weight(shipped_finger):
    """Thrown forward for long enough, it rests where gravity less the acceleration bends it."""
    motion, acceleration, time = motion_of(shipped_finger), 3.0, PERIOD * np.arange(400)
    poses = np.zeros((400, 3, 4))
    poses[:, :, :3], poses[:, 0, 3] = np.eye(3), acceleration * time**2 / 2
    found = motion.acceleration(motion.middles_over_time(poses.reshape(400, 12)))
    np.testing.assert_allclose(found[3:], [[acceleration, 0, 0]] * 397, atol=1e-9)
    gravity = np.tile([0.0, 0.0, -G], (400, 1))
    q, _, _, rest = motion.motion_over_time(np.zeros((400, 12)), gravity, gravity - found)[-1]
    mechanics = motion.mechanics
    bent = mechanics.weight(mechanics.bent_finger(q), np.array([-acceleration, 0.0, -G])) / shipped_finger.stiffness
    np.testing.assert_allclose(q, bent, atol=1e-6)
    assert np.abs(q - rest).max() > 1e-3


def test_after_a_sample_that_is_not_finite_the_finger_is_taken_to_rest(shipped_finger):
    motion = motion_of(shipped_finger)
    driving = np.full((3, 12), 0.02)
    driving[1] = np.nan
    q, rate, _, rest = motion.motion_over_time(driving, *2 * [np.tile([0.0, 0.0, G], (3, 1))])[-1]
    np.testing.assert_array_equal(q, rest)
    assert not rate.any()


def test_lag_that_could_be_taken_for_a_contact_is_said_to_be_unknown(shipped_finger):
    layout, contact = SensorLayout(shipped_finger, 2), ContactShape(SensorLayout(shipped_finger, 2), ASSUMED)
    driving = shipped_finger.pressure_torque(80e3)
    q, behind = driving / shipped_finger.stiffness, np.full(12, 0.03)
    given = layout.read(q - behind), driving, np.zeros(3)
    lag, more = Lag(0.5 * behind, 0.5 * behind), layout.read(q - 5 * behind)
    assert contact(*given).contact.force != 0
    assert np.isnan(contact(*given, lag).contact.force)
    assert contact.posterior(*given, lag).answer == MOVING
    assert contact(more, *given[1:], lag).contact.force > 0


@pytest.mark.parametrize("sections", [2, 4])
def test_no_force_is_stated_of_a_finger_that_moves_in_free_air(sections):
    data, layout = simulate(stepped(sections)).data, SensorLayout(read_finger(), sections)
    force, answer = (data[f"left_finger.contact_{name}"].values.ravel() for name in ("force", "answer"))
    assert np.nanmax(np.abs(force)) < 0.1
    began = data["time"].values > BEGINS
    assert set(answer[began]) == {NOTHING, MOVING}
    readings = data["left_finger.strain"].values.reshape(len(force), -1)
    found = ContactShape(layout, ASSUMED)(
        readings, data["left_finger.driving_torque"].values, np.array([0.0, 0.0, G])
    ).contact.force
    assert np.abs(found[began]).max() > 0.3, "without the lag, a force would be stated"
