"""One force on a finger, from the bends that driving torque and weight do not explain.

A force F at arc length s bends the sections by  F a(s) ,  a(s) = A C u(s) , with u the torque of 1 N at the joints, C
their compliance and A the sums over sections. For bends r with the covariance R the most probable F at a given s, and
what it explains, are

    F(s) = a^T W r / (a^T W a + 1 / f^2) ,   E(s) = F(s) a^T W r ,   W = R^-1 ,

with f the standard deviation of usual forces, which decides where the readings do not: two sections of which only the
first is bent cannot tell a large force near by from a small one far out. The place with the largest E is found by
scanning, with ever smaller steps. Its uncertainty and that of the force follow from  d(F a) = a dF + F a' ds , with the
friction along the finger as a further unknown: it is anything up to the coefficient times the force, and acts on the
face, off the axis. A force that seems to press close to the tip most likely presses on the edge of the tip, where the
object's surface, not the finger's, says in which direction: it is fitted with both components, at the tip; that it
may press a little before the tip is one more unknown.

Leading axes are free; S sections, N joints.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from soft_gripper.arrays import Array
from soft_gripper.estimators.contact_levers import face_offset, unit_torques
from soft_gripper.fingers.kinematics import Chain, forward_kinematics
from soft_gripper.sensors.sensor_layout import SensorLayout
from soft_gripper.shape.estimate import ContactForce

NEAREST = 0.1  # of the length from the base, where a contact is looked for
FRICTION = 0.25  # of the force, standard deviation of what rubs along the finger
TIP_ZONE = 0.04  # of the length from the tip: a force that seems to press there presses on the tip's edge
NEAR_TIP = 0.1  # of the length: within it the tip's edge is tried where a force at the side leaves much unexplained,
_UNLIKELY = 9.0  # in variances
_PLACES = 28, 9, 9  # of each scan
_FINER = 4  # times, the steps of a scan than those of the scan before
_DS = 1e-3  # m, for differences


class Fit(NamedTuple):
    """What forces were found to explain bends best."""

    contact: ContactForce  # each (...)
    torque: Array  # (..., N) N m, at the joints
    misfit: Array  # (...) of the bends, in variances: chi-squared where nothing but noise is left


class Bends(NamedTuple):
    """What is to be explained."""

    theta: Array  # (..., S) rad, bends of the sections beyond those of driving torque and weight
    covariance: Array  # (..., S, S) rad^2
    compliance: Array  # (..., N) or (N) rad/(N m), of the joints


def fit_single_force(layout: SensorLayout, q: Array, bends: Bends, usual: float) -> Fit:
    """The single force that explains bends best.

    Args:
        layout: sensors and finger as they are believed to be.
        q: joint angles, rad, about as they are, (..., N).
        bends: what is to be explained.
        usual: standard deviation of usual forces, N.
    """
    length, weights = layout.finger.length, np.linalg.inv(bends.covariance)
    chain = forward_kinematics(q, layout.finger.segment_length)
    s = np.broadcast_to(np.linspace(NEAREST, 1, _PLACES[0]) * length, (*chain.tip.shape, _PLACES[0]))
    step = (1 - NEAREST) * length / (_PLACES[0] - 1)
    place = _best(layout, chain, bends, weights, usual, s)
    for places in _PLACES[1:]:
        s = place + step * np.linspace(-1, 1, places)
        place = _best(layout, chain, bends, weights, usual, np.clip(s, NEAREST * length, length))
        step /= _FINER
    aside, near_tip = _fit_aside(layout, chain, bends, weights, usual, place), place[..., 0] / length > 1 - NEAR_TIP
    if not near_tip.any():
        return aside
    tip = _fit_tip(layout, chain, bends, usual, aside.contact.force)
    at_tip = (place[..., 0] / length > 1 - TIP_ZONE) | (aside.misfit > np.maximum(tip.misfit, _UNLIKELY))
    return choose(near_tip & at_tip, tip, aside)


def choose(first: NDArray[np.bool_], one: Fit, other: Fit) -> Fit:
    """One fit where `first`, (...), and the other elsewhere."""
    contact = ContactForce(*(np.where(first, a, b) for a, b in zip(one.contact, other.contact, strict=True)))
    torque = np.where(first[..., None], one.torque, other.torque)
    return Fit(contact, torque, np.where(first, one.misfit, other.misfit))


def put(chosen: NDArray[np.bool_], found: Fit, into: Fit) -> Fit:
    """The fit `into`, of K samples, with that of the chosen ones, (K), in their places."""
    fields = zip((*found.contact, found.torque, found.misfit), (*into.contact, into.torque, into.misfit), strict=True)
    filled = []
    for values, before in fields:
        after = before.copy()
        after[chosen] = values
        filled.append(after)
    return Fit(ContactForce(*filled[:4]), *filled[4:])


def _best(layout: SensorLayout, chain: Chain, bends: Bends, weights: Array, usual: float, s: Array) -> Array:
    """The place among s, (..., M) m, at which a force leaves least unexplained, (..., 1)."""
    a = layout.sums(unit_torques(layout.finger, chain, s).real * bends.compliance[..., None, :])
    weighted = a @ weights
    explained = (weighted * bends.theta[..., None, :]).sum(axis=-1)
    gain = explained**2 / ((weighted * a).sum(axis=-1) + 1 / usual**2)
    return np.take_along_axis(s, gain.argmax(axis=-1)[..., None], axis=-1)


def _fit_aside(layout: SensorLayout, chain: Chain, bends: Bends, weights: Array, usual: float, place: Array) -> Fit:
    """The force across the finger at a place, (..., 1) m."""
    finger, around = layout.finger, place + _DS * np.array([-1.0, 0.0, 1.0])
    torques = unit_torques(finger, chain, around)
    before, unit, after = np.moveaxis(torques.real, -2, 0)
    a = layout.sums(unit * bends.compliance)
    weighted = (a[..., None, :] @ weights)[..., 0, :]
    force = (weighted * bends.theta).sum(axis=-1) / ((weighted * a).sum(axis=-1) + 1 / usual**2)
    moved = force[..., None] * (after - before) / (2 * _DS)
    rubbing = torques.imag[..., 1, :] - face_offset(finger, place, force[..., None]) * (unit != 0)
    friction = FRICTION * force[..., None] * layout.sums(rubbing * bends.compliance)
    uncertain = bends.covariance + friction[..., :, None] * friction[..., None, :]
    by_both = np.stack([a, layout.sums(moved * bends.compliance)], axis=-1)
    weights = np.linalg.inv(uncertain)
    stds = np.sqrt(_variance(by_both, weights, np.array([usual, finger.length / 2])))
    contact = ContactForce(force, place[..., 0], stds[..., 0], stds[..., 1])
    return Fit(contact, force[..., None] * unit, misfit(bends.theta - force[..., None] * a, weights))


def _fit_tip(layout: SensorLayout, chain: Chain, bends: Bends, usual: float, across: Array) -> Fit:
    """The force on the tip's edge, in any direction; `across`, (...) N, is about what it is across the finger."""
    finger, across = layout.finger, across[..., None]
    s = np.broadcast_to([finger.length - _DS, finger.length], (*chain.tip.shape, 2))
    before, unit = np.moveaxis(unit_torques(finger, chain, s), -2, 0)
    units = np.stack([unit.real, unit.imag - face_offset(finger, s[..., 1:], across)], axis=-1)
    by_both = np.swapaxes(layout.sums(np.swapaxes(units * bends.compliance[..., None], -1, -2)), -1, -2)
    place_std = TIP_ZONE * finger.length / 2
    moved = layout.sums(across * (unit - before).real / _DS * bends.compliance) * place_std
    weights = np.linalg.inv(bends.covariance + moved[..., :, None] * moved[..., None, :])
    weighted = np.swapaxes(by_both, -1, -2) @ weights
    prior = np.diag([usual**-2.0, usual**-2.0])
    both = np.linalg.solve(weighted @ by_both + prior, weighted @ bends.theta[..., None])
    force_std = np.sqrt(_variance(by_both, weights, np.array([usual, usual]))[..., 0])
    contact = ContactForce(both[..., 0, 0], s[..., 1], force_std, np.full_like(force_std, place_std))
    return Fit(contact, (units @ both)[..., 0], misfit(bends.theta - (by_both @ both)[..., 0], weights))


def misfit(left: Array, weights: Array) -> Array:
    """What is left unexplained of bends, (..., S) rad, in variances, (...)."""
    return ((left[..., None, :] @ weights)[..., 0, :] * left).sum(axis=-1)


def _variance(by_both: Array, weights: Array, usual: Array) -> Array:
    """Variances of two unknowns that move the bends by columns (..., S, 2), (..., 2); `usual` are those before."""
    information = np.swapaxes(by_both, -1, -2) @ weights @ by_both + np.diag(usual**-2.0)
    return np.diagonal(np.linalg.inv(information), axis1=-2, axis2=-1)
