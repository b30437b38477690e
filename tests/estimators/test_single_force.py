"""The single force that explains bends: where everything is linear, and what is chosen of two fits."""

import numpy as np
import pytest

from soft_gripper.estimators.contact import TIP_ZONE, Bends, Fit, choose, fit_single_force, misfit, put, unit_torques
from soft_gripper.estimators.estimate import ContactForce
from soft_gripper.fingers.kinematics import forward_kinematics
from soft_gripper.sensors.sensor_layout import SensorLayout

USUAL = 2.0  # N
STD = 2e-4  # rad, of the bends


@pytest.fixture
def layout(shipped_finger):
    return SensorLayout(shipped_finger, 4)


def bends_of(layout, q, s, force, std=STD):
    """What a force does to the bends of a finger about the shape q, and its torque."""
    chain = forward_kinematics(q, layout.finger.segment_length)
    torque = force * unit_torques(chain, np.array([s])).across[0]
    compliance = 1 / layout.finger.stiffness
    return Bends(layout.sums(torque * compliance), std**2 * np.eye(layout.sections), compliance), torque


@pytest.mark.parametrize("force", [-1.0, 0.2, 1.0])
@pytest.mark.parametrize("s", [0.045, 0.06, 0.0712, 0.11])
def test_the_force_that_bends_a_finger_is_found(layout, bent, s, force):
    q = bent(12) / 2
    bends, torque = bends_of(layout, q, s, force)
    fit = fit_single_force(layout, q, bends, USUAL)
    assert fit.contact.force == pytest.approx(force, rel=5e-3)
    assert fit.contact.arc_length == pytest.approx(s, abs=0.2e-3)
    np.testing.assert_allclose(fit.torque, torque, atol=5e-3 * np.abs(torque).max())


def test_place_and_force_are_the_best_of_a_fine_grid(layout, bent):
    """Of bends that no force has: the largest explained part, by brute force."""
    q, theta = bent(12) / 4, np.array([-0.03, -0.015, -0.004, 0.0005])
    bends = Bends(theta, STD**2 * np.eye(4), 1 / layout.finger.stiffness)
    s = np.linspace(0.1, 1 - TIP_ZONE, 5000) * layout.finger.length
    chain = forward_kinematics(q, layout.finger.segment_length)
    a = layout.sums(unit_torques(chain, s).across * bends.compliance)
    force = (a @ theta / STD**2) / ((a**2).sum(axis=-1) / STD**2 + USUAL**-2)
    best = (((theta - force[:, None] * a) ** 2).sum(axis=-1) / STD**2 + (force / USUAL) ** 2).argmin()
    fit = fit_single_force(layout, q, bends, USUAL)
    assert fit.contact.arc_length == pytest.approx(s[best], abs=0.2e-3)
    assert fit.contact.force == pytest.approx(force[best], rel=5e-3)


@pytest.mark.parametrize("usual", [0.2, 1.0])
def test_a_force_is_the_smaller_the_less_readings_say_beside_what_is_usual(layout, usual):
    """Bends read as badly as they are large; the ridge of least squares, worked out at the place that is found."""
    q, std = np.zeros(12), 0.02
    bends, _ = bends_of(layout, q, 0.06, 1.0, std)
    contact = fit_single_force(layout, q, bends, usual).contact
    a = bends_of(layout, q, float(contact.arc_length), 1.0)[0].theta
    rows, right = np.append(a / std, 1 / usual)[:, None], np.append(bends.theta / std, 0.0)
    assert contact.force == pytest.approx(np.linalg.lstsq(rows, right, rcond=None)[0][0], rel=1e-6)
    assert 0 < contact.force < 1


def test_the_smallest_force_is_chosen_where_the_readings_do_not_decide(shipped_finger):
    """Two sections of which only the first is bent: it presses as far out as it can without bending the second."""
    layout = SensorLayout(shipped_finger, 2)
    bends = Bends(np.array([-0.02, 0.0]), 1e-6 * np.eye(2), 1 / shipped_finger.stiffness)
    contact = fit_single_force(layout, np.zeros(12), bends, USUAL).contact
    assert contact.arc_length == pytest.approx(shipped_finger.joint_arc_lengths[6], abs=0.3e-3)


@pytest.mark.parametrize(("place", "at_tip"), [(0.95, False), (0.965, True), (0.98, True), (1.0, True)])
def test_within_a_twenty_fifth_of_the_length_a_force_presses_on_the_tip(layout, place, at_tip):
    """Its place is then uncertain by half of that zone."""
    q, length = np.full(12, 0.1), layout.finger.length
    contact = fit_single_force(layout, q, bends_of(layout, q, place * length, 1.0)[0], USUAL).contact
    assert (contact.arc_length == length) == at_tip
    assert (contact.arc_length_std == pytest.approx(0.02 * length)) == at_tip


@pytest.mark.parametrize("along", [-1.0, -0.5, 0.5, 1.5])
def test_a_force_on_the_tips_edge_has_any_direction(layout, along):
    """Pulling back along the finger it seems to press before the tip, but leaves much unexplained there."""
    q, finger = np.full(12, 0.1), layout.finger
    unit = unit_torques(forward_kinematics(q, finger.segment_length), np.array([finger.length]))
    torque = unit.across[0] + along * (unit.along[0] - float(finger.section(finger.length).inner_face))
    bends = Bends(layout.sums(torque / finger.stiffness), STD**2 * np.eye(4), 1 / finger.stiffness)
    contact = fit_single_force(layout, q, bends, USUAL).contact
    assert contact.force == pytest.approx(1.0, rel=1e-3)
    assert contact.arc_length == finger.length


def test_uncertainty_without_friction_is_that_of_noise(layout, monkeypatch):
    """The bends of one force with noise, 400 times over: as scattered as it is said to be."""
    monkeypatch.setattr("soft_gripper.estimators.contact.FRICTION", 0.0)
    rng, std = np.random.default_rng(6), 5e-4
    bends, _ = bends_of(layout, np.zeros(12), 0.08, 0.6, std)
    theta = bends.theta + std * rng.standard_normal((400, 4))
    covariance = np.broadcast_to(bends.covariance, (400, 4, 4))
    contact = fit_single_force(layout, np.zeros((400, 12)), Bends(theta, covariance, bends.compliance), USUAL).contact
    assert contact.force.std() == pytest.approx(contact.force_std.mean(), rel=0.15)
    assert contact.arc_length.std() == pytest.approx(contact.arc_length_std.mean(), rel=0.15)


def test_friction_widens_the_uncertainty(layout, monkeypatch):
    """Of a bent finger; along a straight one it is as a force that presses elsewhere, and only the place is open."""
    for angle, force_too in ((0.1, True), (0.0, False)):
        bends, _ = bends_of(layout, np.full(12, angle), 0.08, -0.6)
        contacts = []
        for friction in (0.25, 0.0):
            monkeypatch.setattr("soft_gripper.estimators.contact.FRICTION", friction)
            contacts.append(fit_single_force(layout, np.full(12, angle), bends, USUAL).contact)
        rubbing, smooth = contacts
        assert rubbing.force == pytest.approx(smooth.force)
        assert (rubbing.force_std > 1.2 * smooth.force_std) == force_too
        assert rubbing.arc_length_std > 2 * smooth.arc_length_std


def test_misfit_is_chi_squared():
    left = np.array([[1.0, 2.0], [0.5, -1.0]])
    weights = np.linalg.inv(np.array([[2.0, 1.0], [1.0, 3.0]]))
    np.testing.assert_allclose(misfit(left, weights), [left[0] @ weights @ left[0], left[1] @ weights @ left[1]])


def fit_of(value, count):
    values = np.full(count, value)
    return Fit(ContactForce(values, values, values, values), np.full((count, 3), value), values)


def test_one_fit_is_chosen_or_put_in_the_places_of_another():
    chosen = np.array([True, False, True])
    for found in (choose(chosen, fit_of(1.0, 3), fit_of(2.0, 3)), put(chosen, fit_of(1.0, 2), fit_of(2.0, 3))):
        for values in (*found.contact, found.misfit, *found.torque.T):
            np.testing.assert_array_equal(values, [1.0, 2.0, 1.0])


def test_what_a_fit_is_put_into_stays_as_it_was():
    into = fit_of(2.0, 3)
    put(np.array([True, False, True]), fit_of(1.0, 2), into)
    assert (into.torque == 2.0).all()
