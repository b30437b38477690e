"""Estimates from joint angles of many environments: those of the blocks in a diagram, for the same angles."""

import numpy as np
import pytest

from soft_gripper.diagrams.simulation import simulate
from soft_gripper.errors import InputError
from soft_gripper.extras.export.sensed import sensed_fingers
from soft_gripper.scenario.scenario_file import load_scenario

SHORT = ("pressure.settle=0.2", "pressure.hold_samples=5", "pressure.steps.all=[120e3]")


def recorded(name, overrides):
    """The scenario and, of its left finger, what the blocks compute at every sample; each is an environment here."""
    scenario = load_scenario(name, [*SHORT, *overrides])
    recording = simulate(scenario)
    return scenario, lambda signal: recording[f"left_finger.{signal}"].values[2:]


def estimated(finger, of, q):
    return finger.estimate(finger.read(q), of("sampled_pressure")[:, None], of("X_WB").reshape(-1, 3, 4))


@pytest.mark.parametrize("estimator", ["arcs", "gaussian", "contact"])
def test_estimates_are_those_of_the_diagram(estimator):
    """At rest, if the estimator of the diagram counts the motion of the finger as uncertainty."""
    long = ["pressure.settle=3"] if estimator == "contact" else []
    scenario, of = recorded("free_bending", [f"estimator.type={estimator}", *long])
    finger, q = sensed_fingers(scenario)["left_finger"], of("sampled_joint_angles")
    np.testing.assert_allclose(finger.read(q), of("strain").reshape(len(q), -1), rtol=0, atol=1e-12)
    shape = estimated(finger, of, q)
    rows = slice(None) if shape.contact is None else slice(-1, None)
    np.testing.assert_allclose(shape.q[rows], of("estimated_joint_angles")[rows], rtol=0, atol=1e-9)
    assert np.ptp(shape.q) > 0.05
    if shape.contact is not None:
        np.testing.assert_allclose(shape.contact.force[rows], of("contact_force")[rows], rtol=0, atol=1e-9)


def test_leading_axes_are_free_and_the_base_stands_where_a_run_begins():
    finger = sensed_fingers(load_scenario("free_bending"))["right_finger"]
    q = np.random.default_rng(0).uniform(0, 0.1, (3, 4, 12))
    readings, pressure = finger.read(q), np.full((3, 4, 1), 50e3)
    shape = finger.estimate(readings, pressure)
    assert shape.q.shape == (3, 4, 12)
    alone = finger.estimate(readings[2, 1], pressure[2, 1], finger.X_WB)
    np.testing.assert_allclose(shape.q[2, 1], alone.q, rtol=0, atol=1e-12)


def test_weight_acts_as_the_base_is_posed():
    """Upside down a finger hangs by the opposite of its weight: as in a world whose gravity is turned around."""
    up = ["gravity=[0, 0, 9.81]", "estimator.type=gaussian"]
    here, turned = (sensed_fingers(load_scenario("free_bending", o))["left_finger"] for o in (up[1:], up))
    readings, pressure = here.read(np.full(12, 0.05)), np.array([50e3])
    X_WB = np.diag([1.0, -1.0, -1.0]) @ here.X_WB
    expected = turned.estimate(readings, pressure)
    np.testing.assert_allclose(here.estimate(readings, pressure, X_WB).q, expected.q, rtol=0, atol=1e-12)
    assert np.abs(here.estimate(readings, pressure).q - expected.q).max() > 1e-5


@pytest.mark.parametrize(
    ("name", "overrides", "message"),
    [
        ("free_bending", ["estimator.type=recursive"], "estimator.type = 'recursive': depends on all samples before"),
        (
            "free_bending",
            ["estimator.type=gaussian", "estimator.uncertainty.free_pressure=2e3"],
            "estimator.uncertainty.free_pressure = 2000.0: zeroes sensors by the samples before",
        ),
        ("tendon_grasp", [], "tendons = 1: finger 'left_finger' has them"),
    ],
)
def test_what_remembers_is_refused(name, overrides, message):
    with pytest.raises(InputError, match=message):
        sensed_fingers(load_scenario(name, overrides))


def test_arrays_of_other_sizes_are_refused():
    finger = sensed_fingers(load_scenario("free_bending"))["left_finger"]
    with pytest.raises(InputError, match=r"joint positions = \(5, 11\): the last axis must have 12 entries"):
        finger.read(np.zeros((5, 11)))
    with pytest.raises(InputError, match=r"pressure = \(5,\): the last axis must have 1 entries"):
        finger.estimate(finger.read(np.zeros((5, 12))), np.zeros(5))
