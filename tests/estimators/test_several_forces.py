"""Several forces on one side: none pulls, and their sum and centre are those of the forces that bend a finger."""

import numpy as np
import pytest
from scipy.optimize import nnls

from soft_gripper.estimators.contact import (
    SEVERAL_NEAREST,
    Bends,
    Fit,
    fit_several_forces,
    unit_torques,
)
from soft_gripper.fingers.kinematics import forward_kinematics
from soft_gripper.sensors.sensor_layout import SensorLayout

USUAL = 2.0  # N


@pytest.fixture(params=[4, 12])
def layout(request, shipped_finger):
    return SensorLayout(shipped_finger, request.param)


def bends_of(layout, q, s, forces, std=2e-4):
    """What forces (F) at places (F) do to the bends of samples (K, N)."""
    chain = forward_kinematics(q, layout.finger.segment_length)
    unit = unit_torques(chain, np.broadcast_to(s, (len(q), len(s)))).across
    theta = layout.sums((np.array(forces)[:, None] * unit).sum(axis=-2) / layout.finger.stiffness)
    covariance = np.broadcast_to(std**2 * np.eye(layout.sections), (len(q), layout.sections, layout.sections))
    return Bends(theta, covariance, np.broadcast_to(1 / layout.finger.stiffness, q.shape))


def fitted(layout, q, bends, side, friction=0.45) -> Fit:
    return fit_several_forces(layout, q, bends, np.full(len(q), side), USUAL, friction)


@pytest.mark.parametrize("side", [1.0, -1.0])
@pytest.mark.parametrize("places", [(0.5, 0.9), (0.6, 0.85), (0.45, 1.0)])
def test_sum_and_centre_of_two_forces_are_found(layout, bent, side, places):
    q, s = bent(3, 12) / 4, np.array(places) * layout.finger.length
    fit = fitted(layout, q, bends_of(layout, q, s, [0.8 * side, 0.6 * side]), side)
    np.testing.assert_allclose(fit.contact.force, 1.4 * side, rtol=0.06)
    np.testing.assert_allclose(fit.contact.arc_length, s @ [0.8, 0.6] / 1.4, atol=0.03 * layout.finger.length)
    assert (np.abs(fit.contact.force - 1.4 * side) < 2 * fit.contact.force_std).all()
    assert (fit.misfit < 0.1).all()


def test_bends_follow_from_the_torque_that_is_found(layout, bent):
    q = bent(2, 12) / 4
    bends = bends_of(layout, q, np.array([0.05, 0.1]), [0.8, 0.6])
    torque = fitted(layout, q, bends, 1.0).torque
    np.testing.assert_allclose(layout.sums(torque * bends.compliance), bends.theta, atol=1e-4)


def test_no_force_pulls(layout, bent):
    """Bends of forces on the other side are explained by none, whose place is none."""
    q = bent(2, 12) / 4
    bends = bends_of(layout, q, np.array([0.05, 0.1]), [0.8, 0.6])
    fit = fitted(layout, q, bends, -1.0)
    assert not fit.contact.force.any()
    assert not fit.torque.any()
    assert np.isnan(fit.contact.arc_length).all()
    assert (fit.contact.force_std > 0).all()


def test_friction_widens_the_uncertainty(layout, bent):
    q, s = bent(2, 12) / 4, np.array([0.6, 0.9]) * layout.finger.length
    bends = bends_of(layout, q, s, [-0.8, -0.6], 1e-4)
    rubbing = fitted(layout, q, bends, -1.0).contact
    smooth = fitted(layout, q, bends, -1.0, 0.0).contact
    assert (rubbing.force_std > smooth.force_std).all()
    assert (rubbing.arc_length_std > smooth.arc_length_std).all()


def test_uncertainty_is_that_of_the_forces_beside_each_other(layout):
    """Of what presses and the places beside it, by the information of prior and bends; without friction.

    That of the sum and of the centre have the covariance between neighbours in them, which nearly cancels.
    """
    s = np.linspace(SEVERAL_NEAREST, 1, 29) * layout.finger.length
    q, std, at = np.zeros((1, 12)), 5e-4, 14
    fit = fitted(layout, q, bends_of(layout, q, s[[at]], [0.8], std), 1.0, 0.0)
    units = np.array([bends_of(layout, q, s[[i]], [1.0]).theta[0] for i in range(29)]).T
    force, center = fit.contact.force[0], fit.contact.arc_length[0]
    rows = np.vstack([units / std, np.eye(29) / USUAL])
    presses = nnls(rows, np.concatenate([0.8 * units[:, at] / std, np.zeros(29)]))[0] > 0
    near = np.convolve(presses, np.ones(3), "same") > 0
    part = units[:, near] / std
    covariance = np.linalg.inv(part.T @ part + np.eye(near.sum()) / USUAL**2)
    for found, weights in (
        (fit.contact.force_std, np.ones(near.sum())),
        (fit.contact.arc_length_std, (s[near] - center) / force),
    ):
        assert found[0] == pytest.approx(np.sqrt(weights @ covariance @ weights), rel=1e-6)


def test_errors_lie_within_two_standard_deviations(shipped_finger):
    """Of one force and of two, between the places where they are looked for, in noise."""
    layout, rng, count = SensorLayout(shipped_finger, 4), np.random.default_rng(8), 200
    for forces, s in (([0.8], np.array([0.0817])), ([0.8, 0.6], np.array([0.0583, 0.1021]))):
        bends = bends_of(layout, np.zeros((count, 12)), s, forces, 4e-4)
        noisy = bends._replace(theta=bends.theta + 4e-4 * rng.standard_normal((count, 4)))
        contact = fitted(layout, np.zeros((count, 12)), noisy, 1.0).contact
        assert (np.abs(contact.force - sum(forces)) < 2 * contact.force_std).mean() > 0.9
        center = s @ forces / sum(forces)
        assert (np.abs(contact.arc_length - center) < 2 * contact.arc_length_std).mean() > 0.9


def test_a_force_at_one_place_might_press_beside_it(layout):
    """So its place is uncertain, though there is no other; here it presses where one is looked for."""
    place = SEVERAL_NEAREST * layout.finger.length + 0.003 * 14  # the places are 3 mm apart
    bends = bends_of(layout, np.zeros((1, 12)), np.array([place]), [0.8], 1e-3)
    contact = fitted(layout, np.zeros((1, 12)), bends, 1.0).contact
    assert contact.arc_length == pytest.approx(place, abs=1e-3)
    assert contact.arc_length_std > 1e-3


def test_a_load_that_is_spread_has_its_sum_and_its_middle(layout, bent):
    q, s = bent(2, 12) / 4, np.linspace(0.5, 0.9, 9) * layout.finger.length
    fit = fitted(layout, q, bends_of(layout, q, s, [0.1] * 9), 1.0)
    np.testing.assert_allclose(fit.contact.force, 0.9, rtol=0.05)
    np.testing.assert_allclose(fit.contact.arc_length, 0.7 * layout.finger.length, rtol=0.03)
    assert (fit.contact.arc_length > SEVERAL_NEAREST * layout.finger.length).all()


def test_a_batch_is_its_samples(layout, bent):
    q = bent(3, 12) / 4
    bends = bends_of(layout, q, np.array([0.05, 0.1]), [0.8, 0.6])
    fit = fitted(layout, q, bends, 1.0)
    for i in range(3):
        alone = fitted(layout, q[[i]], Bends(*(values[[i]] for values in bends[:3])), 1.0)
        pairs = zip((*fit.contact, fit.torque, fit.misfit), (*alone.contact, alone.torque, alone.misfit), strict=True)
        for whole, part in pairs:
            np.testing.assert_allclose(whole[i], part[0], rtol=1e-6, atol=1e-9)
