"""Shape and contact forces of a finger with few contacts: in most grasps, a finger touches one object.

Free bending under driving torque and weight, q_0, is subtracted from the measured bends. If the remainder is within
noise and uncertainty, there is no contact. Otherwise, the most probable single force explains it (`force_posterior`);
if that leaves more than noise and there are enough sections, several forces on one side (`fit_several_forces`). The
remaining residual is shared among the joints as in `gaussian`, so that every measured bend is matched. With fewer than
two working sections, the shape is that of `gaussian`, and the force is unknown.

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

A force F bends the sections by  F c , where  c = A C u , with u the torque of 1 N at the joints, C their compliance and
A the sums over sections. The cells of the posterior are places on both faces: plain ones, that is without friction and
on one link, and others, with friction up to the coefficient and a contact that may lie on two links; and the edge of
the tip, which may be pressed in any direction, since a flat face that a bent finger meets pushes along its own normal.
Without this the force in a box grasp is off by 25 %.

In the most probable cell the place is found by scanning around it, with ever smaller steps, for the largest

    E(s) = (c^T W r)^2 / (c^T W c + 1 / f^2) ,   F(s) = c^T W r / (c^T W c + 1 / f^2) ,

with W the inverse covariance of the bends r and of what else is uncertain in the cell, and f the usual force: place and
force that are most probable together. What these leave is shared by friction and lever.

Forces on several places of one side, from the bends that driving torque and weight do not explain.

Forces f_m >= 0 at many places bend the sections by  M f . Those that leave least unexplained, with a little weight on
their squares so that there is one answer, are a non-negative least-squares problem (Lawson and Hanson 1974, ch. 23).
Few of them are not zero: a contact only pushes, and that alone makes it sparse (Slawski and Hein 2013, doi
10.1214/13-EJS868). How uncertain their sum and centre are follows from those that are not zero and the places beside
them, with friction along the finger at each.

Leading axes are free; K samples, M places, S sections, N joints.
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
from soft_gripper.estimators.batches import in_parts, shared
from soft_gripper.estimators.estimate import ContactForce, ShapeEstimate
from soft_gripper.estimators.force_posterior import (
    Believed,
    Cells,
    ContactPosterior,
    FittedCells,
    Forces,
    believed,
    fitted,
    in_cells,
)
from soft_gripper.estimators.free_motion import AT_REST, STILL, FreeMotion, Lag, may_exceed
from soft_gripper.estimators.gaussian import GaussianShape, gain_of
from soft_gripper.estimators.mechanics import Mechanics, PlanarMechanics, outer
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
    moving: Array = STILL  # (...) 1 where a free finger in motion may have them, else 0


def put(chosen: NDArray[np.bool_], found: Fit, into: Fit) -> Fit:
    """The fit `into`, of K samples, with that of the chosen ones, (K), in their places."""
    fields = zip((*found.contact, found.torque, found.misfit), (*into.contact, into.torque, into.misfit), strict=True)
    filled = []
    for values, before in fields:
        after = before.copy()
        after[chosen] = values
        filled.append(after)
    return Fit(ContactForce(*filled[:4]), *filled[4:])


def _of(chosen: NDArray[np.bool_], fit: Fit) -> Fit:
    """The fits of chosen samples, (K)."""
    contact = ContactForce(*(values[chosen] for values in fit.contact))
    return Fit(contact, fit.torque[chosen], fit.misfit[chosen])


def misfit(left: Array, weights: Array) -> Array:
    """Normalised squared residual of bends, (..., S) rad, (...)."""
    return ((left[..., None, :] @ weights)[..., 0, :] * left).sum(axis=-1)


SEVERAL_NEAREST = 0.3  # of the length from the base: search begins there
_SEVERAL_PLACES = 29


def fit_several_forces(
    layout: MeasurementModel, q: Array, bends: Bends, side: Array, usual: float, friction: float
) -> Fit:
    """The forces on one side that best explain the bends, as their sum and centre.

    Args:
        layout: the nominal sensors and finger.
        q: joint angles, rad, about as they are, (K, N).
        bends: what is to be explained, of K samples.
        side: 1 for the inner, -1 for the outer side, (K).
        usual: standard deviation of usual forces, N.
        friction: largest coefficient.
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
    after = _covariance(responses, friction / math.sqrt(3) * frictions, forces, bends.covariance, usual)
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
    """The covariance of the forces, (K, M, M) N^2, each of which may equally press on the adjacent location.

    `frictions` are the bends by friction of one standard deviation, per force, (K, S, M).
    """
    pressing = forces > 0
    near = pressing | ~pressing.any(axis=-1, keepdims=True)  # if none is found, there may be one anywhere
    near[:, 1:] |= pressing[:, :-1]
    near[:, :-1] |= pressing[:, 1:]
    friction = forces[:, None, :] * frictions
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
_PLAIN, _PLAIN_RUB = 0.3, 0.01  # probability of a contact without friction on one link, and the friction it may have
_SLIDING = 0.25  # probability of friction at either end of the cone; sliding contacts are there
_RUBS = 5  # cells of friction
_EDGE_RUBS = 0.6 + 0.3 * np.arange(4)  # friction per force on the tip's edge, toward the tip or the base
_EDGE_CELLS = 2  # nearest the tip, where it may be the edge that is pressed
_ON_EDGE = 0.3  # probability of that, there


class _Table(NamedTuple):
    """Cells, which are the same for all shapes of a finger, (C) each."""

    place: Array  # number, from the base
    side: Array  # -1 or 1
    rub: Array  # friction per force, toward the tip
    rub_std: Array
    straddled: Array  # m, standard deviation of the lever at the next joint
    on_edge: Array  # 1 on the edge of the tip, else 0
    prior: Array  # probability


@cache
def _cell_table(count: int, friction: float) -> _Table:
    """The cells of `count` places, with friction of coefficients up to `friction`."""
    rows: list[tuple[float, ...]] = []
    rubs, edges = friction * np.linspace(-1, 1, _RUBS), np.concatenate([-_EDGE_RUBS, _EDGE_RUBS])
    shares = np.full(_RUBS, (1 - 2 * _SLIDING) / (_RUBS - 2))
    shares[[0, -1]] = _SLIDING
    stds = np.array([rubs[1] - rubs[0], _EDGE_RUBS[1] - _EDGE_RUBS[0]]) / np.sqrt(12)
    for side in (-1, 1):
        for place in range(count):
            on_edge = _ON_EDGE * (place >= count - _EDGE_CELLS)
            rows.append((place, side, 0.0, _PLAIN_RUB, 0.0, 0.0, _PLAIN * (1 - on_edge)))
            for rub, share in zip(rubs, (1 - _PLAIN) * shares * (1 - on_edge), strict=True):
                rows.append((place, side, rub, stds[0], STRADDLED, 0.0, share))
            rows += [(place, side, rub, stds[1], STRADDLED, 1.0, on_edge / len(edges)) for rub in edges if on_edge]
    table = _Table(*np.array(rows).T)
    return table._replace(prior=table.prior / (2 * count))


def force_cells(layout: MeasurementModel, q: Array, compliance: Array, friction: float) -> Cells:
    """The cells of the posterior: places of equal length on both sides, and friction.

    Args:
        layout: the nominal sensors and finger.
        q: joint angles, rad, about as they are, (..., N).
        compliance: of the joints, rad/(N m), (..., N) or (N).
        friction: largest coefficient.
    """
    finger, count = layout.finger, _places(layout.finger)
    table = _cell_table(count, friction)
    place, side, rub, rub_std = table.place.astype(int), table.side.astype(int), table.rub, table.rub_std
    s = np.linspace(0, finger.length, 2 * count + 1)  # ends and middles
    torques = unit_torques(forward_kinematics(q, finger.segment_length), np.broadcast_to(s, (*q.shape[:-1], len(s))))
    to_bends = np.swapaxes(layout.matrix * np.asarray(compliance)[..., None, :], -1, -2)
    across, along = torques.across @ to_bends, torques.along @ to_bends
    middles = s[1::2]
    turned = (middles[:, None] > finger.joint_arc_lengths) @ to_bends  # by 1 N m on the face
    faces = [along[..., 1::2, :] - face_offset(finger, middles, one)[:, None] * turned for one in np.array([-1, 1])]
    rubbing = np.concatenate(faces, axis=-2)[..., place + count * (side > 0), :]
    moved = np.diff(across[..., ::2, :], axis=-2)[..., place, :] / math.sqrt(12)
    nearest = _next_joint(finger, middles)[place]
    levers = (
        table.straddled[:, None] * np.broadcast_to(to_bends, (*q.shape[:-1], *to_bends.shape[-2:]))[..., nearest, :]
    )
    response = side[:, None] * across[..., 1::2, :][..., place, :] + rub[:, None] * rubbing
    return Cells(response, np.stack([moved, rub_std[:, None] * rubbing, levers], axis=-2), place, side, table.prior)


def _places(finger: Finger) -> int:
    return finger.segments * 2 * math.ceil(_FEWEST_PLACES / (2 * finger.segments))


def _next_joint(finger: Finger, s: Array) -> NDArray[np.int_]:
    return np.asarray(np.abs(s[..., None] - finger.joint_arc_lengths).argmin(axis=-1))


# A cell and its neighbours, in cells. Within each, torques are linear in the place; where links meet, they jump.
_NODES = np.array([-1.5, -0.5, -0.5, 0.5, 0.5, 1.5]) + 1e-6 * np.array([1, -1, 1, -1, 1, -1])
_PARTS = np.linspace(0, 1, 65)
_BETWEEN = np.kron(np.eye(3), np.stack([1 - _PARTS, _PARTS], axis=-1))  # from the nodes to the places tried


def fit_single_force(layout: MeasurementModel, q: Array, bends: Bends, left: "Explained") -> Fit:
    """The most probable single force.

    Args:
        layout: the nominal sensors and finger.
        q: joint angles, rad, about as they are, (K, N).
        bends: what is to be explained, of K samples.
        left: the posterior of these.
    """
    finger, posterior, usual = layout.finger, left.posterior, left.forces.usual
    table, best, width = _cell_table(_places(finger), left.friction), posterior.best, finger.length / _places(finger)
    place, side, rub, rub_std, straddled, on_edge, _ = (column[best][:, None] for column in table)
    force = np.clip(np.take_along_axis(posterior.force, best[:, None], axis=-1), 0, left.forces.largest)
    middle = (place + 0.5) * width
    nodes = np.where(on_edge > 0, finger.length, np.clip(middle + width * _NODES, 0, finger.length))
    unit = unit_torques(forward_kinematics(q, finger.segment_length), np.concatenate([nodes, middle], axis=-1))
    rubbing = unit.along[:, -1] - face_offset(finger, middle, side) * (unit.across[:, -1] != 0)
    torques = side[..., None] * unit.across[:, :-1] + (rub * rubbing)[:, None, :]
    lever = straddled * (np.arange(finger.segments) == _next_joint(finger, middle))
    spreads = force[..., None] * np.stack([rub_std * rubbing, lever], axis=-2)

    def bent(torques: Array) -> Array:
        return np.asarray((torques * bends.compliance[:, None, :]) @ layout.matrix.T)

    U = bent(spreads)
    weights = np.linalg.inv(bends.covariance + np.swapaxes(U, -1, -2) @ U)
    a = _BETWEEN @ bent(torques)
    weighted = a @ weights
    explained = np.maximum((weighted @ bends.theta[..., None])[..., 0], 0)
    forces = explained / ((weighted * a).sum(axis=-1) + usual**-2)
    chosen = (explained * forces).argmax(axis=-1)
    each = np.arange(len(q))
    force = np.minimum(forces[each, chosen], left.forces.largest)
    remaining = bends.theta - force[:, None] * a[each, chosen]
    shared = (U @ weights @ remaining[..., None])[..., 0][:, None, :] @ spreads
    torque = force[:, None] * (_BETWEEN[chosen][:, None, :] @ torques)[:, 0] + shared[:, 0]
    s, signed = (_BETWEEN[chosen] * nodes).sum(axis=-1), side[:, 0] * force
    return Fit(
        ContactForce(signed, s, *_deviations(posterior, table, signed, s, width)),
        torque,
        left.found.chi_squared.min(axis=-1),
    )


def _deviations(posterior: Believed, table: _Table, force: Array, s: Array, width: float) -> tuple[Array, Array]:
    """Root mean square distances of the posterior from a force, (K) N, and a place, (K) m."""
    squares = posterior.square - 2 * table.side * posterior.mean * force[:, None] + force[:, None] ** 2
    of_force = (posterior.weight * squares).sum(axis=-1)
    of_place = (posterior.weight * (((table.place + 0.5) * width - s[:, None]) ** 2 + width**2 / 12)).sum(axis=-1)
    return np.sqrt(np.maximum(of_force, 0)), np.sqrt(of_place)


class Explained(NamedTuple):
    """Explanation of the bends of K samples by one force."""

    found: FittedCells
    posterior: Believed
    forces: Forces
    friction: float  # largest coefficient
    read: Array  # (K) number of sections that are read
    moving: Array  # (K) as of the bends


_PASSES = 2  # under an elastic law, whose slope is first evaluated at the most probable shape
_CHANCE = 1e-3  # probability that noise alone exceeds the noise level


@dataclass(frozen=True)
class ContactShape:
    """The estimator `contact` of one finger; a ShapeFunction."""

    layout: MeasurementModel
    uncertainty: Uncertainty = field(default_factory=Uncertainty)
    period: float = 0.01  # s, between the samples of a finger that moves

    def __call__(self, readings: Array, driving: Array, gravity: Planar | complex, lag: Lag = AT_REST) -> ShapeEstimate:
        """Joint angles, their covariance and the contact force; see ShapeFunction.

        `lag` is that of a free finger in motion, (..., N) rad each.
        """
        layout, finger, mechanics = self.layout, self.layout.finger, self._mechanics
        gaussian = shared(GaussianShape.__call__, self._gaussian, readings, driving, np.asarray(gravity))
        z, variance = self._measured(readings)
        q = gaussian.q
        known = driving + mechanics.weight(q, gravity)
        for _ in range(1 if finger.elastic_law is None else _PASSES):
            fit = explain(mechanics, q, self._unexplained(q, z, variance, driving, known, lag))
            q = finger.angle(known + fit.torque)
        gain, _ = gain_of(layout.matrix, mechanics.prior(gaussian.q, gaussian.q, driving), variance)
        q = q + (gain @ (z - q @ layout.matrix.T)[..., None])[..., 0]
        return ShapeEstimate(q, gaussian.covariance, fit.contact)

    def posterior(
        self, readings: Array, driving: Array, gravity: Planar | complex, lag: Lag = AT_REST
    ) -> ContactPosterior:
        """Posterior of one contact, with whatever trades off against it; see `__call__`."""
        q = shared(GaussianShape.__call__, self._gaussian, readings, driving, np.asarray(gravity)).q
        z, variance = self._measured(readings)
        known = driving + self._mechanics.weight(q, gravity)
        return posterior_in_plane(self._mechanics, q, self._unexplained(q, z, variance, driving, known, lag))

    @cached_property
    def motion(self) -> FreeMotion:
        """The motion of the finger while nothing touches it."""
        return FreeMotion(self._mechanics, self.period)

    def _measured(self, readings: Array) -> tuple[Array, Array]:
        return self.layout.linear(readings, self.uncertainty.any_reading).uncertain_by(self.uncertainty.gain)

    def _unexplained(
        self, q: Array, z: Array, variance: Array, driving: Array, known: Array, lag: Lag = AT_REST
    ) -> Bends:
        """The part of the measured values not due to driving torque and weight, `known`, (..., N) N m, near q.

        The stiffness may be as wrong as the bend per driving torque: then a share of the measured bends is.
        """
        A, mechanics, stiffness = self.layout.matrix, self._mechanics, self.uncertainty.bend_per_pressure * z
        of_model = A @ mechanics.of_model(q, driving) @ A.T + outer(stiffness)
        unexplained = z - mechanics.unloaded(q, known) @ A.T
        at_rest, of_motion = of_model + variance[..., None] * np.eye(len(A)), lag.seen_by(A)
        moving = may_exceed(of_motion, at_rest, _quantiles(len(A))[_read(at_rest)])
        return Bends(unexplained, at_rest + of_motion, mechanics.compliance(q), moving)

    @property
    def _mechanics(self) -> PlanarMechanics:
        return self._gaussian.mechanics

    @cached_property
    def _gaussian(self) -> GaussianShape:
        return GaussianShape(self.layout, self.uncertainty)


def posterior_in_plane(mechanics: Mechanics, q: Array, bends: Bends) -> ContactPosterior:
    """Posterior of one contact, from bends that driving torque and weight do not explain.

    Args:
        mechanics: those of the nominal finger, in the plane.
        q: joint angles, rad, about as they are, (..., N).
        bends: what is to be explained.
    """
    length = mechanics.layout.finger.length
    nearest = mechanics.uncertainty.nearest_contact * length

    def of_some(q: Array, *parts: Array) -> ContactPosterior:
        left = shared(_explained, mechanics, q, *parts)
        return in_cells(left.found, left.posterior, left.read, length, left.forces, nearest, left.moving)

    found: ContactPosterior = in_parts(of_some, q, *_broadcast(q, bends))
    return found


def explain(mechanics: Mechanics, q: Array, bends: Bends) -> Fit:
    """The contact that best explains the bends not due to driving torque and weight.

    NaN where fewer than two sections are read.

    Args:
        mechanics: those of the nominal finger, in the plane.
        q: joint angles, rad, about as they are, (..., N).
        bends: what is to be explained.
    """
    found: Fit = in_parts(lambda q, *parts: _explain(mechanics, q, Bends(*parts)), q, *_broadcast(q, bends))
    return found


def _explained(mechanics: Mechanics, q: Array, *parts: Array) -> Explained:
    """Explanation of the bends of K samples by one force; `parts` are those of the bends."""
    bends, assumed = Bends(*parts), mechanics.uncertainty
    forces = Forces(mechanics.usual_force, assumed.largest_force)
    read = _read(bends.covariance).astype(float)
    cells = force_cells(mechanics.layout, q, bends.compliance, assumed.friction)
    found = fitted(bends.theta, bends.covariance, cells, forces.largest)
    return Explained(found, believed(found, read, forces), forces, assumed.friction, read, bends.moving)


def _explain(mechanics: Mechanics, q: Array, bends: Bends) -> Fit:
    """The contact of K samples; where nothing is found, the deviation is that of a force on the tip.

    NaN where nothing is found of a finger that moves.
    """
    layout, finger = mechanics.layout, mechanics.layout.finger
    sections, noise, count = _read(bends.covariance), _quantiles(len(layout.matrix)), len(q)
    weights, nan = np.linalg.inv(bends.covariance), np.full(count, np.nan)
    remaining = misfit(bends.theta, weights)
    touched = (sections >= 2) & (remaining >= noise[sections])
    tip = unit_torques(forward_kinematics(q, finger.segment_length), np.full((count, 1), finger.length)).across[:, 0]
    seen = misfit((tip * bends.compliance) @ layout.matrix.T, weights) + mechanics.usual_force**-2
    known = np.where((sections < 2) | (bends.moving > 0), np.nan, 1.0)
    fit = Fit(ContactForce(0 * known, nan, known / np.sqrt(seen), nan), np.zeros_like(q), remaining)
    if not touched.any():
        return fit
    left = shared(_explained, mechanics, q, *bends)
    one = fit_single_force(layout, q, bends, left)
    several = touched & (sections > 2) & (one.misfit > noise[np.maximum(sections - 2, 0)])
    if several.any():
        part, side = Bends(*(values[several] for values in bends)), np.sign(one.contact.force[several])
        many = fit_several_forces(layout, q[several], part, side, left.forces.usual, left.friction)
        one = put(several, many, one)
    return put(touched, _of(touched, one), fit)


def _read(covariance: Array) -> NDArray[np.int_]:
    """Number of sections that are read, (...), from the covariance of their bends."""
    return np.asarray((np.diagonal(covariance, axis1=-2, axis2=-1) < UNKNOWN / 2).sum(axis=-1))


def _broadcast(q: Array, bends: Bends) -> Bends:
    """With the leading axes of the joint angles."""
    sections = bends.theta.shape[-1]
    covariance = np.broadcast_to(bends.covariance, (*q.shape[:-1], sections, sections))
    moving = np.broadcast_to(bends.moving, q.shape[:-1])
    return Bends(bends.theta, covariance, np.broadcast_to(bends.compliance, q.shape), moving)


@cache
def _quantiles(most: int) -> Array:
    """Misfit thresholds for noise, by degrees of freedom from 0 to `most`; for 0, that of 1."""
    quantiles: Array = chdtri(np.maximum(np.arange(most + 1), 1), _CHANCE)
    return quantiles
