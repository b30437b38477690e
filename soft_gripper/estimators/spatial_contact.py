"""A contact in space: the force as a vector, its place along and around the finger, and how well they are known.

Driving torque and weight leave the readings r = y - h(q) - H (q_0 - q) unexplained: q is a shape close to the true one,
first that of `gaussian`, then that under the force found so; H are the slopes of the readings there, and q_0 the joints
without a load. A load on a link, with the wrench f = (moment about the link's origin, force) in its frame, changes them
by

    G f ,   G = H C J^T ,

with J the motion of the link and C the compliance of the joints. All that lies beyond a joint turns it alike, so that
the sums of  (H C) (screw of the joint)  from the base to a link give its G.

Cells are places along the finger, faces and edges around it, each smooth or rough, and the rim and the end of the tip.
In a cell a force of 1 N presses inward; friction in both directions of the surface, the place along and across the
cell, and the link on which it acts, change its wrench linearly, each by an independent standard normal variable.
`force_posterior` says what follows for the size F of the force. These variables are then Gaussian again,

    z ~ N((I + U U^T)^-1 U (r - F c), (I + U U^T)^-1) ,   all whitened, U = F times the spreads,

which gives friction, hence the force as a vector, and the place within the cell. The contact that is reported is that
of the most probable cell; its standard deviations are over the cells that hold nearly all of the posterior, about it.

Contacts are smooth, with a probability of 0.3, or rough: the standard deviation of the friction in each direction is
then the coefficient at the limit of the cone. So a force without friction is found as closely as the readings allow,
and one at the limit is not excluded.

Leading axes are free; R readings, D joint positions, way after way, L links, P places, C cells.
"""

import math
from collections.abc import Iterator
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.special import chdtri

from soft_gripper.arrays import Array
from soft_gripper.estimators.batches import in_parts, shared
from soft_gripper.estimators.estimate import ContactForce, SpatialContact, SpatialShape
from soft_gripper.estimators.force_posterior import (
    Believed,
    Cells,
    ContactPosterior,
    FittedCells,
    Forces,
    believed,
    fitted,
    in_cells,
    modes,
)
from soft_gripper.estimators.free_motion import AT_REST, STILL, FreeMotion, Lag, may_exceed
from soft_gripper.estimators.gaussian import gain_of
from soft_gripper.estimators.mechanics import BentFinger, SpatialMechanics, outer
from soft_gripper.estimators.spatial_gaussian import SpatialGaussianShape
from soft_gripper.estimators.uncertainty import Uncertainty
from soft_gripper.fingers.finger import Finger
from soft_gripper.fingers.spatial_chain import Posture, vector_product
from soft_gripper.sensors.measurement import UNKNOWN, MeasurementModel

_FEWEST_PLACES = 48  # cells along the finger; joints are at their ends, for the torques change there
_SMOOTH, _IS_SMOOTH = 0.01, 0.3  # friction per force of a smooth contact, and the probability of one
_AROUND = 8  # faces, and the edges between them
_ON_EDGE = 0.04  # probability of each edge
_TURNED = np.radians(45) / math.sqrt(3)  # standard deviation of the direction of an edge's normal
_ON_TIP = 0.6  # probability of rim and end of the tip, relative to that of a place
_STRADDLED = 1.5e-3  # m, standard deviation of the lever at the joint next to a contact, which may lie on both links
_Z = np.array([0.0, 0.0, 1.0])
_CHANCE = 1e-3  # probability that noise alone exceeds the noise level
_PASSES = 2
FEWEST = 3  # readings, for a force to be estimated
_HEAVIEST = 96  # cells, over which means are taken
_TINY = 1e-30
# Friction along both tangents at the limit of the cone, and the place at the sides of a face, in standard deviations.
_CORNERS = np.array(
    [[i, j, 0, k] for i, j in ((-1, 0), (1, 0), (0, -1), (0, 1)) for k in (-math.sqrt(3), math.sqrt(3))]
)


class _Surface(NamedTuple):
    """A part of the surface that may be pressed; vectors in the frame of its link, (3)."""

    point: Array  # m
    normal: Array  # outward
    tangents: tuple[Array, Array]
    extents: tuple[float, float]  # m, along the tangents
    friction: float  # of the force, standard deviation
    turned: float = 0.0  # rad, standard deviation of the normal's direction, toward the second tangent

    def wrenches(self) -> Array:
        """Wrench of a force of 1 N, and its changes, (5, 6): by friction and place, along the tangents."""
        frictions = self.friction, math.hypot(self.friction, self.turned)
        rubbing = [_wrench(self.point, share * along) for share, along in zip(frictions, self.tangents, strict=True)]
        moved = [
            np.append(np.cross(extent / math.sqrt(12) * along, -self.normal), np.zeros(3))
            for extent, along in zip(self.extents, self.tangents, strict=True)
        ]
        return np.array([_wrench(self.point, -self.normal), *rubbing, *moved])


def _wrench(point: Array, force: Array) -> Array:
    return np.append(np.cross(point, force), force)


@dataclass(frozen=True, eq=False)
class SurfaceCells:
    """Where a finger may be pressed: C cells, ordered by sides around the finger and places along it."""

    place: NDArray[np.int_]  # (C)
    side: NDArray[np.int_]  # (C) from 1, the inner one, toward +y
    prior: Array  # (C)
    arc_length: Array  # (C) m
    link: NDArray[np.int_]  # (C)
    nearest: NDArray[np.int_]  # (C) joint next to it
    wrenches: Array  # (C, 5, 6) in the frame of the link
    straddled: Array  # (C, 3) N m, moment at the joint next to it
    directions: Array  # (C, 3, 3) of a force of 1 N, and what friction adds to it
    extent: Array  # (C) m, standard deviation of the place along the finger
    angle: Array  # (C) rad around the finger, from the inner side toward +y
    rough: NDArray[np.bool_]  # (C) whether friction may be large

    @classmethod
    def of(cls, finger: Finger, friction: float) -> "SurfaceCells":
        """Cells of a finger whose contacts have friction of coefficients up to `friction`."""
        place, side, share, s, surfaces = zip(*_surfaces(finger, friction), strict=True)
        joints, arc_length, wrenches = (
            finger.joint_arc_lengths,
            np.array(s),
            np.array([each.wrenches() for each in surfaces]),
        )
        middles = (np.array(place) + 0.5) / (max(place) + 1) * finger.length
        return cls(
            np.array(place),
            np.array(side),
            np.array(share) / np.sum(share),
            arc_length,
            np.searchsorted(joints, arc_length),
            np.abs(middles[:, None] - joints).argmin(axis=-1),
            wrenches,
            np.array([np.cross(_STRADDLED * _Z, -each.normal) for each in surfaces]),
            wrenches[:, :3, 3:],
            np.array([each.extents[0] * each.tangents[0][2] / math.sqrt(12) for each in surfaces]),
            np.angle(np.exp(2j * math.pi * (np.array(side) - 1) / _AROUND)),
            np.array([each.friction > _SMOOTH for each in surfaces]),
        )


def _surfaces(finger: Finger, friction: float) -> Iterator[tuple[int, int, float, float, _Surface]]:
    """Place, side, share, arc length and surface of all cells, by sides and places."""
    count = finger.segments * 2 * math.ceil(_FEWEST_PLACES / (2 * finger.segments))
    s, begins = (np.arange(count) + 0.5) / count * finger.length, np.append(0.0, finger.joint_arc_lengths)
    section = finger.section(s)
    outer, inner, width = (
        np.broadcast_to(each, s.shape) for each in (section.outer_face, section.inner_face, section.width)
    )
    heights = s - begins[np.searchsorted(begins, s) - 1]
    for side in range(_AROUND):
        on_edge = side % 2 == 1
        share = _ON_EDGE if on_edge else (1 - _ON_EDGE * _AROUND / 2) / (_AROUND / 2)
        for i in range(count):
            outline = _Outline(outer[i], inner[i], width[i])
            for rubs, likely in ((_SMOOTH, _IS_SMOOTH), (friction, 1 - _IS_SMOOTH)):
                surface = _beside(side, outline, heights[i], finger.length / count, rubs)
                yield i, side + 1, likely * share, s[i], surface
        for surface in [] if on_edge else _at_the_tip(side, outline, finger.length - begins[-1], friction):
            yield count - 1, side + 1, _ON_TIP / _AROUND, finger.length, surface


class _Outline(NamedTuple):
    """Outline of a section."""

    outer: float  # m, along x
    inner: float  # m
    width: float  # m

    def toward(self, side: int) -> tuple[Array, Array, float, float]:
        """Middle of a face or edge, the outward normal, the depth behind it, and its extent across, m."""
        normal, across = _normal(side)
        half = np.array([(self.inner - self.outer) / 2, self.width / 2, 0.0])
        middle = np.array([(self.inner + self.outer) / 2, 0.0, 0.0])
        point = middle + np.round(normal * math.sqrt(2)).clip(-1, 1) * half
        return point, normal, float(np.abs(normal) @ half), 2 * float(np.abs(across) @ half)


def _normal(side: int) -> tuple[Array, Array]:
    """The outward normal of a face or edge, and the direction across it, (3) each."""
    angle = 2 * math.pi * side / _AROUND
    return np.array([math.cos(angle), math.sin(angle), 0.0]), np.array([-math.sin(angle), math.cos(angle), 0.0])


def _beside(side: int, outline: _Outline, height: float, extent: float, friction: float) -> _Surface:
    """A face, or the edge between two, at a height above the origin of its link."""
    point, normal, _, reach = outline.toward(side)
    across, on_edge = _normal(side)[1], side % 2 == 1
    reach, turned = (0.0, _TURNED) if on_edge else (reach, 0.0)
    return _Surface(point + height * _Z, normal, (_Z, across), (extent, reach), friction, turned)


def _at_the_tip(side: int, outline: _Outline, height: float, friction: float) -> list[_Surface]:
    """The rim of a face at the tip, and the part of its end beside that face."""
    point, normal, depth, reach = outline.toward(side)
    across, rim, up = _normal(side)[1], (normal + _Z) / math.sqrt(2), (_Z - normal) / math.sqrt(2)
    return [
        _Surface(point + height * _Z, rim, (across, up), (reach, 0.0), friction, _TURNED),
        _Surface(point - depth / 2 * normal + height * _Z, _Z, (across, normal), (reach, depth), friction),
    ]


class SpatialPosterior(NamedTuple):
    """Knowledge of one contact in space; forces are absolute values."""

    known: ContactPosterior
    mode_sides: Array  # (..., 2) rad around the finger, of the modes, as `SpatialContact.side`


class Unexplained(NamedTuple):
    """Readings that driving torque and weight do not explain, and the shape about which they are linearized."""

    q: Array  # (..., D)
    at: BentFinger  # at q
    slopes: Array  # H, (..., R, D)
    read: Array  # (...) number of readings
    residual: Array  # r, (..., R)
    covariance: Array  # (..., R, R), of noise, model and motion
    moving: Array = STILL  # (...) 1 where a free finger in motion may have them, else 0


@dataclass(frozen=True)
class SurfaceContact:
    """The one contact on the surface of a finger that explains readings."""

    mechanics: SpatialMechanics

    def fitted(self, left: Unexplained) -> FittedCells:
        """The forces in all cells."""
        return fitted(left.residual, left.covariance, self.cells(left), self._possible.largest, refined=True)

    def stated(self, found: FittedCells, left: Unexplained) -> tuple[SpatialContact, Array]:
        """The contact, and its torques at the joints: none where noise explains the readings, or too few are read."""
        contact, torque = self.best(found, left)
        free = (found.r**2).sum(axis=-1) < _most_of_noise(left.read)
        unknown = (left.read < FEWEST) | (free & (left.moving > 0))
        return _stated(contact, free, unknown), np.where((free | unknown)[..., None], 0.0, torque)

    def posterior(self, found: FittedCells, left: Unexplained) -> SpatialPosterior:
        """Posterior of the contact."""
        length, several = self.mechanics.layout.finger.length, _corners(self.cells(left), self.surface.rough)
        nearest = self.mechanics.uncertainty.nearest_contact * length
        posterior = believed(found, left.read, self._possible)
        known = in_cells(found, posterior, left.read, length, self._possible, nearest, left.moving, several)
        sides = self.surface.angle[modes(found, self._possible.largest).cells]
        return SpatialPosterior(known, np.where(np.isfinite(known.mode_forces), sides, np.nan))

    def cells(self, left: Unexplained) -> Cells:
        """The readings' changes by forces in all cells."""
        surface, at, links = self.surface, left.at.chain, self.mechanics.links
        by_torque = (left.slopes * self.mechanics.compliance(left.q)[..., None, :])[..., self.mechanics.in_chain]
        by_joint = np.swapaxes(by_torque, -1, -2)[..., :, None, :] * at.screws[..., None]  # (..., D, 6, R)
        before = np.concatenate([np.zeros_like(by_joint[..., :1, :, :]), by_joint.cumsum(axis=-3)], axis=-3)
        moments, forces = np.split(before[..., links, :, :], 2, axis=-2)
        turn, origins = np.swapaxes(at.rotations[..., links, :, :], -1, -2), at.origins[..., links, :]
        about = vector_product(np.swapaxes(moments, -1, -2), origins[..., None, :])  # forces act at the links' origins
        forces = forces + np.swapaxes(about, -1, -2)
        by_link = np.concatenate([turn @ moments, turn @ forces], axis=-2)  # (..., L, 6, R)
        changes = surface.wrenches @ by_link[..., surface.link, :, :]
        at_joint = turn[..., surface.link, :, :] @ np.diff(moments, axis=-3)[..., surface.nearest, :, :]
        straddled = surface.straddled[:, None, :] @ at_joint
        spreads = np.concatenate([changes[..., 1:, :], straddled], axis=-2)
        return Cells(changes[..., 0, :], spreads, surface.place, surface.side, surface.prior)

    def best(self, found: FittedCells, left: Unexplained) -> tuple[SpatialContact, Array]:
        """The most probable contact, and its torques at the joints, (..., D)."""
        posterior, surface = believed(found, left.read, self._possible), self.surface
        weights, cells = _heaviest(posterior)
        force, of_cells = np.minimum(_chosen(posterior.mean, cells), self._possible.largest), found.cells
        force[..., 0] = np.clip(_chosen(posterior.force, cells[..., :1])[..., 0], 0, self._possible.largest)
        z, of_z = _within(found.r, force, _chosen(of_cells.response, cells), _chosen(of_cells.spreads, cells))
        R = _chosen(left.at.chain.rotations, self.mechanics.links[surface.link[cells]])
        vectors, of_vectors = _forces(R, surface.directions[cells], force, _chosen(posterior.std, cells), z, of_z)
        x = R[..., 0]
        across = (x * vectors).sum(axis=-1, keepdims=True)
        of_across = x[..., None, :] @ of_vectors @ x[..., None]
        extent = surface.extent[cells]
        place = surface.arc_length[cells] + extent * z[..., 2]
        place = np.clip(place, 0, self.mechanics.layout.finger.length)[..., None]
        of_place = (extent**2 * of_z[..., 2, 2])[..., None, None]
        of_vector = _about_best(weights, vectors, of_vectors)
        across_std = _std(_about_best(weights, across, of_across))[..., 0]
        place_std, best = _std(_about_best(weights, place, of_place))[..., 0], vectors[..., 0, :]
        contact = SpatialContact(
            ContactForce(-across[..., 0, 0], place[..., 0, 0], across_std, place_std),
            *(best, _std(of_vector), _direction_std(best, of_vector), surface.angle[cells[..., 0]]),
        )
        wrenches = surface.wrenches[cells[..., 0]]
        wrench = wrenches[..., 0, :] + (z[..., :1, :4] @ wrenches[..., 1:, :])[..., 0, :]
        return contact, self._torques(left.at.chain, surface.link[cells[..., :1]], force[..., :1] * wrench)

    def _torques(self, at: Posture, link: NDArray[np.int_], wrench: Array) -> Array:
        """At the joints, (..., D), of a wrench in the frame of a link, (..., 6) and (..., 1)."""
        frames = self.mechanics.links[link]
        R, origins = _chosen(at.rotations, frames)[..., 0, :, :], _chosen(at.origins, frames)[..., 0, :]
        moment, force = ((R @ part[..., None])[..., 0] for part in (wrench[..., :3], wrench[..., 3:]))
        in_base = np.concatenate([moment + vector_product(origins, force), force], axis=-1)
        moved = frames > np.arange(at.screws.shape[-2])
        return np.asarray((moved * (at.screws @ in_base[..., None])[..., 0])[..., self.mechanics.from_chain])

    @property
    def _possible(self) -> Forces:
        return Forces(self.mechanics.usual_force, self.mechanics.uncertainty.largest_force)

    @cached_property
    def surface(self) -> SurfaceCells:
        """The cells of the finger."""
        return SurfaceCells.of(self.mechanics.layout.finger, self.mechanics.uncertainty.friction)


@dataclass(frozen=True)
class SpatialContactShape:
    """The estimator `contact` of one finger whose sensors see it leave its plane."""

    layout: MeasurementModel
    uncertainty: Uncertainty = field(default_factory=Uncertainty)
    period: float = 0.01  # s, between the samples of a finger that moves

    def __call__(self, readings: Array, driving: Array, gravity: Array, lag: Lag = AT_REST) -> SpatialShape:
        """The joint positions, their covariance and the contact; as `SpatialGaussianShape`.

        The contact is NaN where fewer than three sensors are read, and where nothing is found of a finger that moves;
        `lag` is that of a free finger in motion, (..., D) each.
        """
        found: SpatialShape = self._in_parts(self._shape, readings, driving, gravity, *lag)
        return found

    def posterior(self, readings: Array, driving: Array, gravity: Array, lag: Lag = AT_REST) -> SpatialPosterior:
        """Posterior of one contact, with whatever trades off against it; see `__call__`."""
        found: SpatialPosterior = self._in_parts(self._posterior, readings, driving, gravity, *lag)
        return found

    @cached_property
    def motion(self) -> FreeMotion:
        """The motion of the finger while nothing touches it."""
        return FreeMotion(self._gaussian.mechanics, self.period)

    def _in_parts(self, function: Any, readings: Array, *others: Array) -> Any:
        leading = readings.shape[:-1]
        return in_parts(function, readings, *(np.broadcast_to(each, (*leading, each.shape[-1])) for each in others))

    def _shape(self, readings: Array, driving: Array, gravity: Array, *lag: Array) -> SpatialShape:
        shape = shared(SpatialGaussianShape.__call__, self._gaussian, readings, driving, gravity)
        left, free, found = shared(SpatialContactShape._explained, self, shape.q, readings, driving, gravity, *lag)
        contact, torque = self.contact.stated(found, left)
        q = self._loaded(left, free, torque, readings, driving)
        return SpatialShape(q, shape.covariance, contact)

    def _posterior(self, readings: Array, driving: Array, gravity: Array, *lag: Array) -> SpatialPosterior:
        shape = shared(SpatialGaussianShape.__call__, self._gaussian, readings, driving, gravity)
        left, _, found = shared(SpatialContactShape._explained, self, shape.q, readings, driving, gravity, *lag)
        return self.contact.posterior(found, left)

    def _explained(
        self,
        q: Array,
        readings: Array,
        driving: Array,
        gravity: Array,
        damping: Array = AT_REST.damping,
        inertia: Array = AT_REST.inertia,
    ) -> tuple[Unexplained, Array, FittedCells]:
        """The forces in all cells, linearized about the finger under the likeliest of those about `q`."""
        lag = Lag(damping, inertia)
        left, free = self._unexplained(q, readings, driving, gravity, lag)
        found = self.contact.fitted(left)
        for _ in range(_PASSES - 1):
            q = self._loaded(left, free, self.contact.best(found, left)[1], readings, driving)
            left, free = self._unexplained(q, readings, driving, gravity, lag)
            found = self.contact.fitted(left)
        return left, free, found

    def _loaded(self, left: Unexplained, free: Array, torque: Array, readings: Array, driving: Array) -> Array:
        """Joint positions under torques of a contact, (..., D); what they do not explain is shared as by `gaussian`."""
        mechanics, (_, variance) = self._gaussian.mechanics, self._gaussian.measured(readings)
        loaded = mechanics.compliance(left.q) * torque
        remaining = left.residual - (left.slopes @ loaded[..., None])[..., 0]
        gain, _ = gain_of(left.slopes, mechanics.prior(left.at, left.q, driving), variance)
        return np.asarray(free + loaded + (gain @ remaining[..., None])[..., 0])

    def _unexplained(
        self, q: Array, readings: Array, driving: Array, gravity: Array, lag: Lag = AT_REST
    ) -> tuple[Unexplained, Array]:
        """Linearized about joint positions `q`, and the joints without a load, q_0, (..., D).

        The stiffness may be as wrong as the bend per driving torque: then a share of what is read is.
        """
        mechanics, (measured, variance) = self._gaussian.mechanics, self._gaussian.measured(readings)
        at, (predicted, H) = mechanics.posture(q), self.layout.linearized(q)
        free = mechanics.unloaded(q, driving + mechanics.weight(at, gravity))
        residual = measured - predicted - (H @ (free - q)[..., None])[..., 0]
        stiffness = self.uncertainty.bend_per_pressure * measured
        of_model = H @ mechanics.of_model(q, driving) @ np.swapaxes(H, -1, -2)
        at_rest = of_model + outer(stiffness) + variance[..., None] * np.eye(H.shape[-2])
        read, of_motion = (variance < UNKNOWN / 2).sum(axis=-1, dtype=float), lag.seen_by(H)
        moving = may_exceed(of_motion, at_rest, _most_of_noise(read))
        return Unexplained(q, at, H, read, residual, at_rest + of_motion, moving), free

    @cached_property
    def contact(self) -> SurfaceContact:
        """Contacts that explain readings."""
        return SurfaceContact(self._gaussian.mechanics)

    @cached_property
    def _gaussian(self) -> SpatialGaussianShape:
        return SpatialGaussianShape(self.layout, self.uncertainty)


def _most_of_noise(read: Array) -> Array:
    """Misfit threshold for noise, (...), by the number of readings."""
    return np.asarray(chdtri(np.maximum(read, 1), _CHANCE))


def _heaviest(posterior: Believed) -> tuple[Array, NDArray[np.int_]]:
    """Weights that sum to 1 and numbers, (..., K), of the most probable cell, which is the first, and the heaviest."""
    rank = posterior.weight.copy()
    np.put_along_axis(rank, posterior.best[..., None], np.inf, axis=-1)
    cells = np.argsort(-rank, axis=-1)[..., :_HEAVIEST]
    weights = np.take_along_axis(posterior.weight, cells, axis=-1)
    return weights / weights.sum(axis=-1, keepdims=True), cells


def _chosen(values: Array, numbers: NDArray[np.int_]) -> Array:
    """Values chosen for each sample, (..., C, ...), by their numbers, (..., K)."""
    more = values.ndim - numbers.ndim
    return np.take_along_axis(values, numbers.reshape(*numbers.shape, *[1] * more), axis=numbers.ndim - 1)


def _within(r: Array, force: Array, response: Array, spreads: Array) -> tuple[Array, Array]:
    """Spreads of a cell's response, (..., K, 5), in standard deviations, and their covariance, given the readings."""
    U = force[..., None, None] * spreads
    covariance = np.linalg.inv(np.eye(U.shape[-2]) + U @ np.swapaxes(U, -1, -2))
    rest = r[..., None, :] - force[..., None] * response
    return (covariance @ (U @ rest[..., None]))[..., 0], covariance


def _forces(R: Array, directions: Array, force: Array, std: Array, z: Array, of_z: Array) -> tuple[Array, Array]:
    """Forces in B, (..., K, 3) N, and their covariances; see `_within` for z, `SurfaceCells` for the directions."""
    unit = directions[..., 0, :] + (z[..., None, :2] @ directions[..., 1:, :])[..., 0, :]
    rubbing = force[..., None, None] * directions[..., 1:, :]
    covariance = np.swapaxes(rubbing, -1, -2) @ of_z[..., :2, :2] @ rubbing + outer(std[..., None] * unit)
    return (R @ (force[..., None] * unit)[..., None])[..., 0], R @ covariance @ np.swapaxes(R, -1, -2)


def _about_best(weights: Array, values: Array, covariances: Array) -> Array:
    """Mean squares of the distance from the first of K values, (..., K, M), with their covariances: (..., M, M)."""
    return np.asarray((weights[..., None, None] * (covariances + outer(values - values[..., :1, :]))).sum(axis=-3))


def _std(covariance: Array) -> Array:
    """Standard deviations, (..., M, M) -> (..., M)."""
    return np.sqrt(np.diagonal(covariance, axis1=-2, axis2=-1))


def _direction_std(vector: Array, covariance: Array) -> Array:
    """Root mean square of the angle between a vector, (..., 3), and what it may be, rad, (...)."""
    square = np.maximum((vector**2).sum(axis=-1), _TINY)
    along = ((vector[..., None, :] @ covariance)[..., 0, :] * vector).sum(axis=-1) / square
    return np.sqrt(np.maximum(np.trace(covariance, axis1=-2, axis2=-1) - along, 0) / square)


def _stated(contact: SpatialContact, free: NDArray[np.bool_], unknown: NDArray[np.bool_]) -> SpatialContact:
    """No force where nothing touches, and NaN where too little is read."""
    nan = np.nan

    def of(value: Array, without: float | Array) -> Array:
        more = (..., *[None] * (value.ndim - free.ndim))
        return np.where(unknown[more], nan, np.where(free[more], without, value))

    force, place, force_std, place_std = contact.across
    return SpatialContact(
        ContactForce(of(force, 0.0), of(place, nan), of(force_std, force_std), of(place_std, nan)),
        of(contact.force, 0.0),
        of(contact.force_std, contact.force_std),
        of(contact.direction_std, nan),
        of(contact.side, nan),
    )


def _corners(cells: Cells, rough: NDArray[np.bool_]) -> Cells:
    """Cells of each of several forces: on the middles and the sides of faces, with friction at the cone."""
    chosen = np.flatnonzero(rough & (cells.side % 2 == 1) & (cells.place % 2 == 1))
    response = cells.response[..., chosen, None, :] + _CORNERS @ cells.spreads[..., chosen, :4, :]
    response = response.reshape(*response.shape[:-3], -1, response.shape[-1])
    place, side = np.repeat(cells.place[chosen], len(_CORNERS)), np.repeat(cells.side[chosen], len(_CORNERS))
    return Cells(response, cells.spreads, place, side, np.repeat(cells.prior[chosen], len(_CORNERS)))
