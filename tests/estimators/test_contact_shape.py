"""Force and place from fingers in static balance with known forces, and as uncertain as noise and friction have it."""

from dataclasses import replace

import numpy as np
import pytest
from loaded_fingers import Push, in_balance, torque_of, vector

from soft_gripper.estimators.contact import (
    ContactShape,
    LinearizedResidual,
    SurfaceContact,
)
from soft_gripper.estimators.gaussian import GaussianShape
from soft_gripper.estimators.mechanics import Mechanics
from soft_gripper.estimators.uncertainty import EXACT, Uncertainty
from soft_gripper.fingers.finger_parts import ElasticLaw
from soft_gripper.fingers.kinematics import forward_kinematics
from soft_gripper.sensors.sensor_layout import SensorLayout, extension_ratios

TWO, FOUR = {"sections": 2, "borders": (1 / 3,)}, {"sections": 4}
PLACES = [0.4, 0.6, 0.8, 0.95, 1.0]  # of the length
SOFTENING = ElasticLaw((-30.0, -8.0, 8.0, 30.0), (-0.23, -0.1, 0.1, 0.23), (-0.2, -0.088, 0.088, 0.2))
BOTH = pytest.mark.parametrize("sections", [TWO, FOUR], ids=["two", "four"])
SIDES = pytest.mark.parametrize("side", [1, -1], ids=["inner", "outer"])


def readings(layout, q, noise=0.0, rng=None):
    ratios = extension_ratios(layout, q)
    return layout.response.reading(ratios if rng is None else ratios + noise * rng.standard_normal(ratios.shape))


def estimated(layout, q, pressure, gravity=0j, **assumed):
    """By the exact model, which is declared to be exact."""
    shape = ContactShape(layout, Uncertainty(bend_per_pressure=EXACT, **assumed))
    return shape(readings(layout, q), layout.finger.pressure_torque(pressure), vector(gravity))


def face(finger, s, side):
    section = finger.section(s)
    return float(section.inner_face if side > 0 else section.outer_face)


@BOTH
@SIDES
@pytest.mark.parametrize("place", PLACES)
def test_a_single_force_is_found(shipped_finger, sections, side, place):
    """Whatever the pressure, however gravity pulls."""
    layout, rng = SensorLayout(shipped_finger, **sections), np.random.default_rng(3)
    s = place * shipped_finger.length
    for _ in range(2):
        pressure, gravity = rng.uniform(0, 150e3), 9.81 * np.exp(1j * rng.uniform(-np.pi, np.pi))
        force = side * rng.uniform(0.3, 1.5)
        q = in_balance(shipped_finger, pressure, gravity, [Push(s, force)])
        found = estimated(layout, q, pressure, gravity)
        # Two sections can hardly distinguish a force on the tip from one in another direction a little before it.
        error = 0.05 if (place, layout.sections) == (1.0, 2) else 0.01
        assert found.contact.force == pytest.approx(force, rel=error)
        assert found.contact.arc_length == pytest.approx(s, abs=0.005 * shipped_finger.length)
        tips = [forward_kinematics(angles, shipped_finger.segment_length).tip for angles in (q, found.q)]
        assert abs(tips[0] - tips[1]) < 0.2e-3


@pytest.mark.parametrize(
    ("wrong", "assumed"),
    [
        ({"gain": 1.03}, {"gain": 0.03}),
        ({"offset": 3e-3}, {"offset": 3e-3}),
        ({"offset": 3e-3}, {"drift": 3e-3 / np.sqrt(60)}),
    ],
)
def test_what_a_sensor_is_believed_to_err_is_not_taken_for_a_force(shipped_finger, wrong, assumed):
    """A sensor that reads 3 % too much, or too much by an offset; of one that is assumed exact it is a force."""
    layout = SensorLayout(shipped_finger, **TWO)
    ratios = extension_ratios(layout, in_balance(shipped_finger, 80e3, 0j))
    ratios[-1] = 1 + wrong.get("gain", 1.0) * (ratios[-1] - 1) + wrong.get("offset", 0.0)
    given = layout.response.reading(ratios), shipped_finger.pressure_torque(80e3), np.zeros(3)
    assert ContactShape(layout, Uncertainty(bend_per_pressure=EXACT))(*given).contact.force != 0
    assert ContactShape(layout, Uncertainty(bend_per_pressure=EXACT, **assumed))(*given).contact.force == 0


def test_noise_is_rarely_taken_for_a_force(shipped_finger):
    """A thousandth of the time, as it is chosen: of 2000 readings, less than 8."""
    layout, rng = SensorLayout(shipped_finger, **TWO), np.random.default_rng(5)
    free = in_balance(shipped_finger, 80e3, 0j)
    q = free * (1 + 0.005 * rng.standard_normal((2000, 1))) + 2e-4 * rng.standard_normal((2000, 12))
    read = readings(layout, q, 1e-4, rng)
    driving = shipped_finger.pressure_torque(np.full(2000, 80e3))
    found = ContactShape(layout)(read, driving, np.zeros(3)).contact.force
    assert np.count_nonzero(found) < 8


@pytest.mark.parametrize("lost", [None, 0, 1])
def test_with_one_section_the_force_is_unknown_and_the_shape_the_most_probable(shipped_finger, lost):
    """With one on the finger, or one of two that reads anything."""
    layout = SensorLayout(shipped_finger, 1 if lost is None else 2)
    q = in_balance(shipped_finger, 80e3, 9.81, [Push(0.1, 0.5)])
    read = readings(layout, q)
    if lost is not None:
        read[[lost, lost + 2]] = np.nan
    found, shape = (
        make(layout)(read, shipped_finger.pressure_torque(80e3), vector(9.81)) for make in (ContactShape, GaussianShape)
    )
    assert all(np.isnan(value).all() for value in found.contact)
    np.testing.assert_allclose(found.q, shape.q, rtol=0, atol=1e-4)
    np.testing.assert_array_equal(found.covariance, shape.covariance)


def test_a_section_that_is_missing_of_four_leaves_the_force(shipped_finger):
    layout = SensorLayout(shipped_finger, **FOUR)
    read = readings(layout, in_balance(shipped_finger, 80e3, 9.81, [Push(0.09, 0.8)]))
    shape = ContactShape(layout, Uncertainty(bend_per_pressure=EXACT))
    for lost in range(4):
        spoiled = read.copy()
        spoiled[[lost, lost + 4]] = np.nan
        contact = shape(spoiled, shipped_finger.pressure_torque(80e3), vector(9.81)).contact
        assert contact.force == pytest.approx(0.8, rel=0.02)
        assert contact.arc_length == pytest.approx(0.09, abs=1e-3)


@BOTH
@SIDES
@pytest.mark.parametrize("place", [0.5, 0.8, 1.0])
def test_a_single_force_is_found_under_an_elastic_law(shipped_finger, sections, side, place):
    """Where it bends the finger out of one piece of the law into another."""
    finger = replace(shipped_finger, elastic_law=SOFTENING)
    q = in_balance(finger, 60e3, 9.81, [Push(place * finger.length, side * 0.5)])
    contact = estimated(SensorLayout(finger, **sections), q, 60e3, 9.81).contact
    assert contact.force == pytest.approx(side * 0.5, rel=0.035)
    assert contact.arc_length == pytest.approx(place * finger.length, abs=0.005 * finger.length)


def test_every_measured_bend_is_met(shipped_finger, bent):
    """Of shapes that no few forces explain, as closely as by the most probable shape."""
    layout, assumed = SensorLayout(shipped_finger, **FOUR), Uncertainty(reading=1e-6)
    q = np.repeat(bent(5, 4) / 4, 3, axis=-1)
    driving = shipped_finger.pressure_torque(np.full(5, 5e4))
    found = ContactShape(layout, assumed)(readings(layout, q), driving, np.zeros(3))
    np.testing.assert_allclose(layout.sums(found.q), layout.sums(q), rtol=0, atol=1e-6)


@pytest.mark.parametrize("share", [0.54, 0.79])
def test_a_contact_on_two_links_turns_the_joint_between_them(shipped_finger, share):
    """Its torques are those of a rubbing force and, at that joint alone, of a lever of a millimetre."""
    layout, q, s = SensorLayout(shipped_finger, **FOUR), np.zeros((3, 12)), share * shipped_finger.length
    compliance = 1 / shipped_finger.stiffness
    next_joint = np.arange(12) == np.abs(shipped_finger.joint_arc_lengths - s).argmin()
    push = Push(s, 0.8, 0.45 * 0.8, face(shipped_finger, s, 1))
    torque = torque_of(shipped_finger, q[0], push) + 0.8 * 1e-3 * next_joint
    mechanics = Mechanics(layout, Uncertainty(friction=0.9))
    residual, covariance = (
        np.tile(layout.sums(torque * compliance), (3, 1)),
        np.tile((2e-4) ** 2 * np.eye(4), (3, 1, 1)),
    )
    left = LinearizedResidual(q, mechanics.bent_finger(q), layout.matrix, np.full(3, 4.0), residual, covariance)
    contact = SurfaceContact(mechanics)
    found = contact.best_contact(contact.explain(left))[1]
    np.testing.assert_allclose(found - torque, 0, atol=0.2e-3)
