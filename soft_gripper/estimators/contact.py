"""Shape and contact forces of a finger with few contacts: in most grasps, a finger touches one object.

Free bending under driving torque and weight, q_0, is subtracted from the measured bends. If the remainder is within
noise and uncertainty, there is no contact. Otherwise, the single force that best explains it is found
(`fit_single_force`); if that leaves more than noise and there are enough sections, several forces on one side
(`fit_several_forces`). The remaining residual is shared among the joints as in `gaussian`, so that every measured bend
is matched. With fewer than two working sections, the shape is that of `gaussian`, and the force is unknown.

Force and place of a single contact from a curved shape: Rucker and Webster (2011, doi 10.1109/IROS.2011.6094526) for
continuum robots; from sparse readings: arXiv 2109.12469.

What a force on a finger does to its joints.

A force of 1 N at arc length s presses across the finger, from the inner to the outer side: it points along -i d ,
with d the direction of the link that it presses on. At a joint i before it, at r_i, it has the torque

    Im conj(r(s) - r_i) (-i d)  =  - Re conj(r(s) - r_i) d ,

which opens the finger. One along the finger, toward the tip, in the line of the neutral axis has  Im conj(r(s) - r_i)
d . A force that rubs on a face at the offset o from the axis has the torque -o more; the inner face is close to the
axis.

One force on a finger, from the bends that driving torque and weight do not explain.

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

Forces on several places of one side, from the bends that driving torque and weight do not explain.

Forces f_m >= 0 at many places bend the sections by  M f . Those that leave least unexplained, with a little weight on
their squares so that there is one answer, are a non-negative least-squares problem (Lawson and Hanson 1974, ch. 23).
Few of them are not zero: a contact only pushes, and that alone makes it sparse (Slawski and Hein 2013, doi
10.1214/13-EJS868). How uncertain their sum and centre are follows from those that are not zero and the places beside
them, with friction along the finger at each.

The posterior of a single force (`force_posterior`) counts all places, sides and directions instead of the best.

Leading axes are free; K samples, M places, S sections, N joints.

The edge of the tip may be pressed in any direction because a flat face that a bent finger meets pushes along its own
normal. Without this the force in a box grasp is off by 25 %.
"""

import math
from dataclasses import dataclass, field
from functools import cache, cached_property
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import nnls
from scipy.special import chdtri

from soft_gripper.arrays import Array, Planar
from soft_gripper.estimators.estimate import ContactForce, ShapeEstimate
from soft_gripper.estimators.force_posterior import Cells, ContactPosterior, posterior
from soft_gripper.estimators.gaussian import GaussianShape, gain_of
from soft_gripper.estimators.mechanics import PlanarMechanics
from soft_gripper.estimators.uncertainty import Uncertainty
from soft_gripper.fingers.finger import Finger
from soft_gripper.fingers.kinematics import Chain, forward_kinematics
from soft_gripper.sensors.measurement import UNKNOWN, MeasurementModel


class UnitTorques(NamedTuple):
    """Torques of forces of 1 N at the joints, each (..., M, N) N m."""

    across: Array  # of forces that press from the inner side
    along: Array  # of forces toward the tip


def unit_torques(chain: Chain, s: Array) -> UnitTorques:
    """Torques of forces of 1 N on the axis of a finger.

    Args:
        chain: where the bent finger lies, of leading axes (...).
        s: arc lengths where they press, m, (..., M).
    """
    sites = chain.at(s)
    return UnitTorques(sites.torques(-sites.normals), sites.torques(sites.directions))


def face_offset(finger: Finger, s: Array, side: Array) -> Array:
    """Distance of a face from the neutral axis, m, (...): the inner face where `side` is positive, else the outer."""
    section = finger.section(s)
    offset: Array = np.where(side > 0, section.inner_face, section.outer_face)
    return offset


NEAREST = 0.1  # of the length from the base: search begins there
FRICTION = 0.25  # of the force: standard deviation of the friction along the finger
TIP_ZONE = 0.04  # of the length from the tip: a force estimated there is taken to press on the tip's edge
NEAR_TIP = 0.1  # of the length: within it, the tip's edge is tried if a force on the side leaves much unexplained
_UNLIKELY = 9.0  # in variances
_PLACES = 28, 9, 9  # of each scan
_FINER = 4  # refinement factor between scans
_DS = 1e-3  # m, for finite differences


class Fit(NamedTuple):
    """The forces that best explain the bends."""

    contact: ContactForce  # each (...)
    torque: Array  # (..., N) N m, at the joints
    misfit: Array  # (...) of the bends, normalised by the variances: chi-squared if only noise is left


class Bends(NamedTuple):
    """The bends to be explained."""

    theta: Array  # (..., S) rad, bends of the sections beyond those of driving torque and weight
    covariance: Array  # (..., S, S) rad^2
    compliance: Array  # (..., N) or (N) rad/(N m), of the joints


def fit_single_force(layout: MeasurementModel, q: Array, bends: Bends, usual: float) -> Fit:
    """The single force that best explains the bends.

    Args:
        layout: the nominal sensors and finger.
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


def _best(layout: MeasurementModel, chain: Chain, bends: Bends, weights: Array, usual: float, s: Array) -> Array:
    """The location among s, (..., M) m, at which a force leaves the smallest residual, (..., 1)."""
    a = (unit_torques(chain, s).across * bends.compliance[..., None, :]) @ layout.matrix.T
    weighted = a @ weights
    explained = (weighted * bends.theta[..., None, :]).sum(axis=-1)
    gain = explained**2 / ((weighted * a).sum(axis=-1) + 1 / usual**2)
    return np.take_along_axis(s, gain.argmax(axis=-1)[..., None], axis=-1)


def _fit_aside(layout: MeasurementModel, chain: Chain, bends: Bends, weights: Array, usual: float, place: Array) -> Fit:
    """The force across the finger at a location, (..., 1) m."""
    finger, A, around = layout.finger, layout.matrix, place + _DS * np.array([-1.0, 0.0, 1.0])
    torques = unit_torques(chain, around)
    before, unit, after = np.moveaxis(torques.across, -2, 0)
    a = (unit * bends.compliance) @ A.T
    weighted = (a[..., None, :] @ weights)[..., 0, :]
    force = (weighted * bends.theta).sum(axis=-1) / ((weighted * a).sum(axis=-1) + 1 / usual**2)
    moved = force[..., None] * (after - before) / (2 * _DS)
    rubbing = torques.along[..., 1, :] - face_offset(finger, place, force[..., None]) * (unit != 0)
    friction = FRICTION * force[..., None] * ((rubbing * bends.compliance) @ A.T)
    uncertain = bends.covariance + friction[..., :, None] * friction[..., None, :]
    by_both = np.stack([a, (moved * bends.compliance) @ A.T], axis=-1)
    weights = np.linalg.inv(uncertain)
    stds = np.sqrt(_variance(by_both, weights, np.array([usual, finger.length / 2])))
    contact = ContactForce(force, place[..., 0], stds[..., 0], stds[..., 1])
    return Fit(contact, force[..., None] * unit, misfit(bends.theta - force[..., None] * a, weights))


def _fit_tip(layout: MeasurementModel, chain: Chain, bends: Bends, usual: float, across: Array) -> Fit:
    """The force on the tip's edge, in any direction; `across`, (...) N, is its approximate transverse component."""
    finger, across = layout.finger, across[..., None]
    s = np.broadcast_to([finger.length - _DS, finger.length], (*chain.tip.shape, 2))
    torques = unit_torques(chain, s)
    before, unit = np.moveaxis(torques.across, -2, 0)
    units = np.stack([unit, torques.along[..., 1, :] - face_offset(finger, s[..., 1:], across)], axis=-1)
    by_both = layout.matrix @ (units * bends.compliance[..., None])
    place_std = TIP_ZONE * finger.length / 2
    moved = (across * (unit - before) / _DS * bends.compliance) @ layout.matrix.T * place_std
    weights = np.linalg.inv(bends.covariance + moved[..., :, None] * moved[..., None, :])
    weighted = np.swapaxes(by_both, -1, -2) @ weights
    prior = np.diag([usual**-2.0, usual**-2.0])
    both = np.linalg.solve(weighted @ by_both + prior, weighted @ bends.theta[..., None])
    force_std = np.sqrt(_variance(by_both, weights, np.array([usual, usual]))[..., 0])
    contact = ContactForce(both[..., 0, 0], s[..., 1], force_std, np.full_like(force_std, place_std))
    return Fit(contact, (units @ both)[..., 0], misfit(bends.theta - (by_both @ both)[..., 0], weights))


def misfit(left: Array, weights: Array) -> Array:
    """Normalised squared residual of bends, (..., S) rad, (...)."""
    return ((left[..., None, :] @ weights)[..., 0, :] * left).sum(axis=-1)


def _variance(by_both: Array, weights: Array, usual: Array) -> Array:
    """Variances, (..., 2), of two unknowns with sensitivities (..., S, 2); `usual` are prior standard deviations."""
    information = np.swapaxes(by_both, -1, -2) @ weights @ by_both + np.diag(usual**-2.0)
    return np.diagonal(np.linalg.inv(information), axis1=-2, axis2=-1)


SEVERAL_NEAREST = 0.3  # of the length from the base: search begins there
_SEVERAL_PLACES = 29


def fit_several_forces(layout: MeasurementModel, q: Array, bends: Bends, side: Array, usual: float) -> Fit:
    """The forces on one side that best explain the bends, as their sum and centre.

    Args:
        layout: the nominal sensors and finger.
        q: joint angles, rad, about as they are, (K, N).
        bends: what is to be explained, of K samples.
        side: 1 for the inner, -1 for the outer side, (K).
        usual: standard deviation of usual forces, N.
    """
    finger, chain = layout.finger, forward_kinematics(q, layout.finger.segment_length)
    s = np.linspace(SEVERAL_NEAREST, 1, _SEVERAL_PLACES) * finger.length
    unit = unit_torques(chain, np.broadcast_to(s, (len(q), _SEVERAL_PLACES)))
    torques = side[:, None, None] * unit.across
    rubbing = unit.along - face_offset(finger, s, side[:, None])[..., None] * (unit.across != 0)
    responses, frictions = (_responses(layout, bends, torque) for torque in (torques, rubbing))
    whitening = np.linalg.inv(np.linalg.cholesky(bends.covariance))
    theta = (whitening @ bends.theta[..., None])[..., 0]
    forces = np.array([_fit(*sample, usual) for sample in zip(whitening @ responses, theta, strict=True)])
    total = forces.sum(axis=-1)
    pressing = np.where(total > 0, total, np.nan)[:, None]
    center = forces @ s[:, None] / pressing
    after = _covariance(responses, frictions, forces, bends.covariance, usual)
    stds = (_std_of_sum(after, weights) for weights in (np.ones_like(forces), (s - center) / pressing))
    left = bends.theta - (responses @ forces[..., None])[..., 0]
    contact = ContactForce(side * total, center[:, 0], *stds)
    return Fit(contact, (forces[:, None, :] @ torques)[:, 0], misfit(left, np.linalg.inv(bends.covariance)))


def _responses(layout: MeasurementModel, bends: Bends, torques: Array) -> Array:
    """Bends of the sections, (K, S, M), due to torques, (K, M, N)."""
    return layout.matrix @ np.swapaxes(torques * bends.compliance[..., None, :], -1, -2)


def _fit(responses: Array, bends: Array, usual: float) -> Array:
    """The forces of one sample at M places, N; whitened."""
    ridge = np.eye(responses.shape[-1]) / usual
    forces, _ = nnls(np.vstack([responses, ridge]), np.concatenate([bends, np.zeros(len(ridge))]))
    return forces


def _covariance(responses: Array, frictions: Array, forces: Array, of_bends: Array, usual: float) -> Array:
    """The covariance of the forces, (K, M, M) N^2, each of which may equally press on the adjacent location."""
    pressing = forces > 0
    near = pressing | ~pressing.any(axis=-1, keepdims=True)  # if none is found, there may be one anywhere
    near[:, 1:] |= pressing[:, :-1]
    near[:, :-1] |= pressing[:, 1:]
    friction = FRICTION * forces[:, None, :] * frictions
    uncertain = of_bends + friction @ np.swapaxes(friction, -1, -2)
    before = usual**2 * near[..., None] * np.eye(forces.shape[-1])
    shared = before @ np.swapaxes(responses, -1, -2)
    return before - shared @ np.linalg.solve(responses @ shared + uncertain, np.swapaxes(shared, -1, -2))


def _std_of_sum(covariance: Array, weights: Array) -> Array:
    """The standard deviation of a weighted sum of the forces, (K)."""
    return np.sqrt(((weights[:, None, :] @ covariance)[:, 0] * weights).sum(axis=-1))


_FEWEST_PLACES = 48  # cells along the finger; joints are at their ends, for friction on a face jumps there
# m, standard deviation of the lever at the joint next to a contact, which may lie on both of its links.
STRADDLED = 1.5e-3
CONE = 0.45  # largest coefficient of friction reckoned with
_SLIDING = 0.25  # probability of friction at either end of the cone; sliding contacts are there
_RUBS = CONE * np.linspace(-1, 1, 5)  # friction per force
_EDGE_RUBS = 0.6 + 0.3 * np.arange(4)  # the same on the tip's edge, toward the tip or the base
_EDGE_CELLS = 2  # nearest the tip, where it may be the edge that is pressed
_ON_EDGE = 0.3  # probability of that, there


@cache
def _cell_table(count: int) -> tuple[NDArray[np.int_], NDArray[np.int_], Array, Array, Array]:
    """Place, side, friction per force, its standard deviation and prior probability of every cell, (C) each.

    `count` is the number of places.
    """
    rows: list[tuple[int, int, float, float]] = []
    inside = (1 - 2 * _SLIDING) / (len(_RUBS) - 2)
    on_face = np.array([_SLIDING, *[inside] * (len(_RUBS) - 2), _SLIDING])
    edges = np.concatenate([-_EDGE_RUBS, _EDGE_RUBS])
    for side in (-1, 1):
        for place in range(count):
            on_edge = _ON_EDGE * (place >= count - _EDGE_CELLS)
            rows += [(place, side, rub, share * (1 - on_edge)) for rub, share in zip(_RUBS, on_face, strict=True)]
            rows += [(place, side, rub, on_edge / len(edges)) for rub in edges if on_edge]
    places, sides, rubs, shares = (np.array(column) for column in zip(*rows, strict=True))
    widths = np.where(np.abs(rubs) > CONE + 1e-9, np.diff(_EDGE_RUBS)[0], np.diff(_RUBS)[0])
    return places, sides, rubs, widths / np.sqrt(12), shares / (2 * count)


def force_cells(layout: MeasurementModel, q: Array, compliance: Array) -> Cells:
    """The cells of the posterior: places of equal length on both sides, and friction.

    Args:
        layout: the nominal sensors and finger.
        q: joint angles, rad, about as they are, (..., N).
        compliance: of the joints, rad/(N m), (..., N) or (N).
    """
    finger = layout.finger
    count = finger.segments * 2 * math.ceil(_FEWEST_PLACES / (2 * finger.segments))
    place, side, rub, rub_std, prior = _cell_table(count)
    s = np.linspace(0, finger.length, 2 * count + 1)  # ends and middles
    torques = unit_torques(forward_kinematics(q, finger.segment_length), np.broadcast_to(s, (*q.shape[:-1], len(s))))
    to_bends = np.swapaxes(layout.matrix * np.asarray(compliance)[..., None, :], -1, -2)
    across, along = torques.across @ to_bends, torques.along @ to_bends
    middles = s[1::2]
    turned = (middles[:, None] > finger.joint_arc_lengths) @ to_bends  # by 1 N m on the face
    faces = [along[..., 1::2, :] - face_offset(finger, middles, one)[:, None] * turned for one in np.array([-1, 1])]
    rubbing = np.concatenate(faces, axis=-2)[..., place + count * (side > 0), :]
    moved = np.diff(across[..., ::2, :], axis=-2)[..., place, :] / math.sqrt(12)
    nearest = np.abs(middles[:, None] - finger.joint_arc_lengths).argmin(axis=-1)
    straddled = STRADDLED * to_bends[..., nearest, :][..., place, :]
    response = side[:, None] * across[..., 1::2, :][..., place, :] + rub[:, None] * rubbing
    return Cells(response, np.stack([moved, rub_std[:, None] * rubbing, straddled], axis=-2), place, side, prior)


_PASSES = 2  # under an elastic law, whose slope is first evaluated at the most probable shape
_AT_ONCE = 16  # samples of which the posterior is computed together
_CHANCE = 1e-3  # probability that noise alone exceeds the noise level


@dataclass(frozen=True)
class ContactShape:
    """The estimator `contact` of one finger; a ShapeFunction."""

    layout: MeasurementModel
    uncertainty: Uncertainty = field(default_factory=Uncertainty)

    def __call__(self, readings: Array, driving: Array, gravity: Planar | complex) -> ShapeEstimate:
        """Joint angles, their covariance and the contact force; see ShapeFunction."""
        layout, finger, assumed = self.layout, self.layout.finger, self.uncertainty
        gaussian = self._gaussian(readings, driving, gravity)
        z, variance = layout.linear(readings, assumed.any_reading).uncertain_by(assumed.gain)
        q = gaussian.q
        known = driving + self._mechanics.weight(q, gravity)
        for _ in range(1 if finger.elastic_law is None else _PASSES):
            fit = explain(layout, self.uncertainty, q, self._unexplained(q, z, variance, driving, known))
            q = finger.angle(known + fit.torque)
        gain, _ = gain_of(layout.matrix, self._mechanics.prior(gaussian.q, gaussian.q, driving), variance)
        q = q + (gain @ (z - q @ layout.matrix.T)[..., None])[..., 0]
        return ShapeEstimate(q, gaussian.covariance, fit.contact)

    def posterior(self, readings: Array, driving: Array, gravity: Planar | complex) -> ContactPosterior:
        """What the readings say of one contact, with whatever trades off against it; see ShapeFunction.

        The stiffness may be as wrong as the bend per driving torque: then a share of the measured bends is.
        """
        layout, assumed = self.layout, self.uncertainty
        q = self._gaussian(readings, driving, gravity).q
        z, variance = layout.linear(readings, assumed.any_reading).uncertain_by(assumed.gain)
        known = driving + self._mechanics.weight(q, gravity)
        bends = self._unexplained(q, z, variance, driving, known)
        stiffness = assumed.bend_per_pressure * z
        bends = bends._replace(covariance=bends.covariance + stiffness[..., :, None] * stiffness[..., None, :])
        read = (variance < UNKNOWN / 2).sum(axis=-1, dtype=float)
        return posterior_in_plane(layout, assumed, q, bends, read)

    def _unexplained(self, q: Array, z: Array, variance: Array, driving: Array, known: Array) -> Bends:
        """The part of the measured values not due to driving torque and weight, `known`, (..., N) N m, near q."""
        A, mechanics = self.layout.matrix, self._mechanics
        of_model = A @ mechanics.of_model(q, driving) @ A.T
        unexplained = z - mechanics.unloaded(q, known) @ A.T
        return Bends(unexplained, of_model + variance[..., None] * np.eye(len(A)), mechanics.compliance(q))

    @property
    def _mechanics(self) -> PlanarMechanics:
        return self._gaussian.mechanics

    @cached_property
    def _gaussian(self) -> GaussianShape:
        return GaussianShape(self.layout, self.uncertainty)


def posterior_in_plane(
    layout: MeasurementModel, uncertainty: Uncertainty, q: Array, bends: Bends, read: Array | None = None
) -> ContactPosterior:
    """What bends that driving torque and weight do not explain say of one contact.

    Args:
        layout: the nominal sensors and finger.
        uncertainty: says which forces and places are possible.
        q: joint angles, rad, about as they are, (..., N).
        bends: what is to be explained.
        read: number of sections that are read, (...); None: all.
    """
    shape, length = q.shape[:-1], layout.finger.length
    q, bends = _flat(q, bends)
    read = np.broadcast_to(float(len(layout.matrix)) if read is None else read, shape).reshape(-1)
    largest, nearest = uncertainty.largest_force, uncertainty.nearest_contact * length
    parts = []
    for at in _batches(len(q)):
        some = Bends(*(each[at] for each in bends))
        cells = force_cells(layout, q[at], some.compliance)
        parts.append(posterior(some.theta, some.covariance, read[at], cells, length, largest, nearest))
    joined = (np.concatenate(values) for values in zip(*parts, strict=True))
    return ContactPosterior(*(values.reshape((*shape, *values.shape[1:])) for values in joined))


def explain(layout: MeasurementModel, uncertainty: Uncertainty, q: Array, bends: Bends) -> Fit:
    """The contact that best explains the bends not due to driving torque and weight.

    NaN where fewer than two sections are read.

    Args:
        layout: the nominal sensors and finger.
        uncertainty: says how large loads usually are.
        q: joint angles, rad, about as they are, (..., N).
        bends: what is to be explained.
    """
    shape, finger = q.shape[:-1], layout.finger
    usual = float(uncertainty.load_pressure * finger.pressure_gain.max() / (finger.length / 2))
    fit = _explain(layout, *_flat(q, bends), usual)
    contact = ContactForce(*(values.reshape(shape) for values in fit.contact))
    return Fit(contact, fit.torque.reshape(q.shape), fit.misfit.reshape(shape))


def _explain(layout: MeasurementModel, q: Array, bends: Bends, usual: float) -> Fit:
    """The same for K samples; `usual` is the magnitude of a usual force, N."""
    sections = (np.diagonal(bends.covariance, axis1=-2, axis2=-1) < UNKNOWN / 2).sum(axis=-1)
    noise = _quantiles(len(layout.matrix))
    remaining = misfit(bends.theta, np.linalg.inv(bends.covariance))
    nan = np.full(len(q), np.nan)
    unknown = Fit(ContactForce(nan, nan, nan, nan), np.zeros_like(q), remaining)
    if (sections < 2).all():
        return unknown
    fit = fit_single_force(layout, q, bends, usual)
    several = (sections > 2) & (fit.misfit > noise[np.maximum(sections - 2, 0)])
    several &= fit.contact.arc_length < layout.finger.length
    if several.any():
        part, side = Bends(*(values[several] for values in bends)), np.sign(fit.contact.force[several])
        fit = put(several, fit_several_forces(layout, q[several], part, side, usual), fit)
    free = Fit(ContactForce(np.zeros(len(q)), nan, fit.contact.force_std, nan), np.zeros_like(q), remaining)
    return choose(sections < 2, unknown, choose(remaining < noise[sections], free, fit))


def _batches(count: int) -> list[slice]:
    """Samples of which the cells are small enough for a processor's cache."""
    return [slice(begin, begin + _AT_ONCE) for begin in range(0, max(count, 1), _AT_ONCE)]


def _flat(q: Array, bends: Bends) -> tuple[Array, Bends]:
    """The same with a single leading axis."""
    joints, count = q.shape[-1], bends.theta.shape[-1]
    compliance = np.broadcast_to(bends.compliance, q.shape).reshape(-1, joints)
    covariance = np.broadcast_to(bends.covariance, (*q.shape[:-1], count, count)).reshape(-1, count, count)
    return q.reshape(-1, joints), Bends(bends.theta.reshape(-1, count), covariance, compliance)


@cache
def _quantiles(most: int) -> Array:
    """Misfit thresholds for noise, by degrees of freedom from 0 to `most`; for 0, that of 1."""
    quantiles: Array = chdtri(np.maximum(np.arange(most + 1), 1), _CHANCE)
    return quantiles
