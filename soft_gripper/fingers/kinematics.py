"""Planar kinematics of the chain in finger frame B: joint angles -> points, how they move, and torques at the joints.

A vector of the bending plane is the complex number z + i x, m. A link of heading h (from z toward x) then
points along exp(i h), and the inner side lies to the side of i: turning is multiplying. One number a vector keeps the
last axis for places along the finger, and a sample cheap; only this file knows the directions of links and how forces
act on them. `as_points` gives the (x, z) pairs that ports and tables hold. All functions are pure;
joint angles q have shape (..., N), rad, and the leading axes are free: one sample, a batch, or a whole recording.
"""

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from soft_gripper.arrays import Array, Planar
from soft_gripper.fingers.finger import Finger


class Sites(NamedTuple):
    """Points fixed to links of a bent chain."""

    points: Planar  # (..., M) m in B
    directions: Planar  # (..., M) unit vectors along their links, toward the tip
    jacobian: Planar  # (..., M, N) m/rad, motion per joint angle

    @property
    def normals(self) -> Planar:
        """Unit vectors across their links, toward the inner side, (..., M)."""
        return 1j * self.directions

    def torques(self, forces: Planar) -> Array:
        """Torques of forces on the points, (..., M) N in B, at the joints, N m, (..., M, N); positive closes."""
        return (self.jacobian.conj() * forces[..., None]).real


class Chain(NamedTuple):
    """The configuration of a bent chain in frame B."""

    joints: Planar  # (..., N) m
    segment_ends: Planar  # (..., N + 1) m, from the base to the tip; each is the middle of a link
    headings: Array  # (..., N + 1) rad, of the links; the first is 0
    directions: Planar  # (..., N + 1) unit vectors along the links
    segment_length: Array | float  # m

    @property
    def tip(self) -> Planar:
        return self.segment_ends[..., -1]

    @property
    def tip_heading(self) -> Array:
        return self.headings[..., -1]

    @property
    def points(self) -> Planar:
        """Joints and tip, (..., N + 1) m."""
        return np.concatenate([self.joints, self.segment_ends[..., -1:]], axis=-1)

    @property
    def normals(self) -> Planar:
        """Unit vectors across the links, toward the inner side, (..., N + 1)."""
        return 1j * self.directions

    def link_at(self, s: Array) -> NDArray[np.int_]:
        """The links on which arc lengths (...) m from the base lie, 0 at the base; at a joint the one before it."""
        return np.searchsorted(self._joint_arc_lengths, s)

    def sites(self, s: Array, offset: Array | float = 0.0) -> Sites:
        """Points at arc lengths (..., M) m of a chain with equal segments.

        `offset` (..., M) m is their distance from the axis, positive on the inner side.
        """
        link = self.link_at(s)
        begins = np.concatenate([np.zeros_like(self.segment_ends[..., :1]), self.joints], axis=-1)
        link_begins = np.concatenate([[0.0], self._joint_arc_lengths])
        directions = _pick(self.directions, link)
        points = _pick(begins, link) + directions * (s - link_begins[link] + 1j * np.asarray(offset))
        moves = np.arange(self.joints.shape[-1]) < link[..., None]
        return Sites(points, directions, 1j * (points[..., None] - self.joints[..., None, :]) * moves)

    @property
    def _joint_arc_lengths(self) -> Array:
        return (np.arange(self.joints.shape[-1]) + 0.5) * self.segment_length


def _pick(values: NDArray[Any], number: NDArray[np.int_]) -> NDArray[Any]:
    """Entries of (..., N) by their numbers (..., M); leading axes are broadcast."""
    leading_shape = np.broadcast_shapes(values.shape[:-1], number.shape[:-1])
    values, number = (np.broadcast_to(array, (*leading_shape, array.shape[-1])) for array in (values, number))
    return np.take_along_axis(values, number, axis=-1)


def as_points(planar: Planar | complex) -> Array:
    """(x, z) pairs of planar vectors, (...) -> (..., 2)."""
    return np.asarray(planar)[..., None].view(float)[..., ::-1]


def in_space(planar: Planar) -> Array:
    """Planar vectors in B, (...) -> (..., 3) x, y, z."""
    return np.stack([planar.imag, np.zeros(planar.shape), planar.real], axis=-1)


def as_planar(points: Array) -> Planar:
    """Planar vectors of (x, z) pairs, (..., 2) -> (...)."""
    return points[..., 1] + 1j * points[..., 0]


def planar_vector(x: Array | float, z: Array | float) -> Planar:
    """Planar vectors of their components, (...)."""
    return z + 1j * np.asarray(x)


def unit_vectors(angle: Array | float) -> Planar:
    """exp(i angle), in half the time for a recording and as quickly for one sample, (...)."""
    angle = np.asarray(angle)
    vectors: Planar = np.empty(angle.shape, complex)
    np.cos(angle, out=vectors.real)
    np.sin(angle, out=vectors.imag)
    return vectors


def rotated(vectors: Planar, angle: Array | float) -> Planar:
    """Rotates planar vectors by angles, rad, from z toward x, (...)."""
    return vectors * unit_vectors(angle)


def forward_kinematics(q: Array, segment_length: Array | float, shear: Array | None = None) -> Chain:
    """Points of the chain, whose joints are in the middles of its segments, of one length or of (..., N) m.

    `shear` (..., N) m is the sliding distance before every joint along x of the link before it; None: 0.
    """
    headings: Array = _sums_from_zero(q)
    directions, half = unit_vectors(headings), np.asarray(segment_length) / 2
    to_joints = directions[..., :-1] * (half if shear is None else half + 1j * shear)
    segment_ends: Planar = _sums_from_zero(to_joints + directions[..., 1:] * half)
    return Chain(segment_ends[..., :-1] + to_joints, segment_ends, headings, directions, segment_length)


def link_directions(q: Array) -> Planar:
    """Unit vectors along the links beyond the joints, (..., N) -> (..., N).

    Points of links move as  p = p_0 + directions @ levers , with levers (N, M) of every point along the direction of a
    link; an imaginary part is along the link's normal.
    """
    return unit_vectors(q.cumsum(axis=-1))


def gravity_torque(finger: Finger, q: Array, gravity: Planar | complex) -> Array:
    """Torque of the finger's own weight at every joint, N m, (..., N).

    The links beyond a joint act on it with the moments of their directions.
    `gravity` is the acceleration in the bending plane, z + i x in B, m/s^2, a number or (..., 1).
    """
    return (np.conj(link_directions(q) @ finger.mass_moments) * gravity).imag


def _sums_from_zero(steps: NDArray[Any]) -> Any:
    """0 and the running sums, (..., M) -> (..., M + 1)."""
    sums = np.zeros((*steps.shape[:-1], steps.shape[-1] + 1), dtype=steps.dtype)
    steps.cumsum(axis=-1, out=sums[..., 1:])
    return sums


def sensor_path(chain: Chain, offset: float) -> Planar:
    """Points of a sensor path at `offset` m from the axis (positive: inner side), (..., 2 N + 1).

    At a joint the point lies on the bisector of the two links; between joints, in the middle of a link, on
    the link's own normal.
    """
    bisectors = (chain.headings[..., :-1] + chain.headings[..., 1:]) / 2
    path = np.empty((*chain.headings.shape[:-1], 2 * bisectors.shape[-1] + 1), dtype=complex)
    path[..., 0::2] = chain.segment_ends + offset * chain.normals
    path[..., 1::2] = chain.joints + rotated(planar_vector(offset, 0.0), bisectors)
    return path


def segment_path_lengths(q: Array, segment_length: float, offset: Array | float) -> Array:
    """Length of the sensor path at `offset` over every segment, m: the distances along `sensor_path`.

    From the middle of a link to the bisector the path runs a - o sin(u) along the link and o (1 - cos(u))
    across it, with a half a segment, o the offset and u half the joint angle. Both halves of a segment are
    alike, so a segment's length depends on its own joint alone.
    """
    half_angle = q / 2
    axial = segment_length / 2 - offset * np.sin(half_angle)
    sagitta = offset * (1 - np.cos(half_angle))
    return 2 * np.hypot(axial, sagitta)
