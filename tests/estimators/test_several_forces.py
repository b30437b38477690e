"""Several forces on one side: none pulls, and their sum and centre are those of the forces that bend a finger."""

from types import SimpleNamespace

import numpy as np
import pytest
from fingers_in_space import sensors, yielding
from loaded_fingers import Push, torque_of
from scipy.optimize import nnls

from soft_gripper.estimators.contact import LinearizedResidual, SurfaceContact
from soft_gripper.estimators.mechanics import Mechanics
from soft_gripper.estimators.uncertainty import Uncertainty
from soft_gripper.sensors.sensor_layout import SensorLayout

SMOOTH = 0.0101  # friction


@pytest.fixture(params=[4, 12, "space"])
def layout(request, shipped_finger):
    """Sections of a finger that only bends, and a finger that leaves its plane."""
    if request.param == "space":
        return sensors(yielding(shipped_finger), "four_faces_and_diagonal", 4)
    return SensorLayout(shipped_finger, request.param)


@pytest.fixture
def q(layout, bent):
    return np.append(bent(12) / 4, np.zeros(len(layout.straight) - 12))


def found(layout, q, s, forces, side=1, friction=0.45, std=0.01, noise=0.0):
    """What is found on a side, 1 the inner one and -1 the outer one, of forces (F) at places (F); of noise (K, S).

    `std` is that of the noise, as a share of what the largest force at the tip changes.
    """
    mechanics = Mechanics(layout, Uncertainty(friction=friction))
    contact, A = SurfaceContact(mechanics), layout.values_at(q)[1]

    def changed(*pushes):
        torque = sum(torque_of(layout.finger, q[:12], push) for push in pushes)
        return A @ (mechanics.compliance(q) * np.append(torque, np.zeros(len(q) - 12)))

    std = std * np.abs(changed(Push(layout.finger.length, 1.0))).max()
    residual = np.atleast_2d(changed(*map(Push, s, forces)) + std * noise)
    each = np.tile(q, (len(residual), 1))
    read, covariance = np.full(len(residual), float(len(A))), np.tile(std**2 * np.eye(len(A)), (len(residual), 1, 1))
    left = LinearizedResidual(each, mechanics.bent_finger(each), layout.values_at(each)[1], read, residual, covariance)
    explained, number = contact.explain(left), side if mechanics.is_planar or side > 0 else 5
    fits = [contact._fit_several_forces(k, number, explained) for k in range(len(residual))]
    fields = {name: np.squeeze([fit.fields[name] for fit in fits]) for name in fits[0].fields}
    torque = np.array([fit.torque for fit in fits])
    remaining = residual - torque * mechanics.compliance(q) @ A.T
    return SimpleNamespace(
        **fields, torque=torque, left=remaining, changed=changed, std=std, usual=mechanics.usual_force
    )


@pytest.mark.parametrize("side", [1, -1])
@pytest.mark.parametrize("places", [(0.5, 0.9), (0.6, 0.85), (0.45, 1.0)])
def test_sum_and_centre_of_two_forces_are_found(layout, q, side, places):
    s = np.array(places) * layout.finger.length
    fit = found(layout, q, s, [0.8 * side, 0.6 * side], side)
    assert fit.force == pytest.approx(1.4 * side, rel=0.06)
    assert fit.arc_length == pytest.approx(s @ [0.8, 0.6] / 1.4, abs=0.03 * layout.finger.length)
    assert abs(fit.force - 1.4 * side) < 2 * fit.force_std
    assert np.abs(fit.left).max() < fit.std, "the torque that is found explains the values"


def test_no_force_pulls(layout, q):
    """Forces on the other side are explained by none, whose place is none."""
    fit = found(layout, q, np.array([0.05, 0.1]), [0.8, 0.6], -1)
    assert fit.force == 0
    assert not fit.torque.any()
    assert not fit.vector.any()
    assert np.isnan(fit.arc_length)
    assert fit.force_std > 0


def test_uncertainty_is_that_of_the_forces_beside_each_other(layout, q):
    """Of what presses and the places beside it, by the information of prior and values; without friction.

    That of the sum and of the centre have the covariance between neighbours in them, which nearly cancels.
    """
    straight = 0 * q
    nearest, length = Uncertainty().nearest_contact, layout.finger.length
    s = (np.arange(48) + 0.5) / 48 * length
    s = s[s >= nearest * length]
    fit = found(layout, straight, s[[14]], [0.8], 1, SMOOTH, 0.02)
    units = np.array([fit.changed(Push(each, 1.0)) for each in s]).T
    rows = np.vstack([units / fit.std, np.eye(len(s)) / fit.usual])
    presses = nnls(rows, np.concatenate([0.8 * units[:, 14] / fit.std, np.zeros(len(s))]))[0] > 0
    near = np.convolve(presses, np.ones(3), "same") > 0
    part = units[:, near] / fit.std
    covariance = np.linalg.inv(part.T @ part + np.eye(near.sum()) / fit.usual**2)
    for std, weights in (
        (fit.force_std, np.ones(near.sum())),
        (fit.arc_length_std, (s[near] - fit.arc_length) / fit.force),
    ):
        assert std == pytest.approx(np.sqrt(weights @ covariance @ weights), rel=2e-3)
