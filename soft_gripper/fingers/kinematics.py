"""Planar kinematics of the chain in finger frame B: joint angles -> points and sensor paths.

A vector of the bending plane is the complex number z + i x, m. A link of heading h (from z toward x) then
points along exp(i h), and the inner side lies to the side of i: turning is multiplying. `as_points` gives
the (x, z) pairs that ports and tables hold. All functions are pure; joint angles q have shape (..., N), rad,
and the leading axes are free: one sample, a batch, or a whole recording.
"""

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from soft_gripper.arrays import Array, Planar


class Chain(NamedTuple):
    """Where a bent chain lies in frame B."""

    joints: Planar  # (..., N) m
    segment_ends: Planar  # (..., N + 1) m, from the base to the tip; each is the middle of a link
    headings: Array  # (..., N + 1) rad, of the links; the first is 0

    @property
    def tip(self) -> Planar:
        return self.segment_ends[..., -1]

    @property
    def tip_heading(self) -> Array:
        return self.headings[..., -1]


def as_points(planar: Planar) -> Array:
    """(x, z) pairs of planar vectors, (...) -> (..., 2)."""
    return np.ascontiguousarray(planar).view(float).reshape(*planar.shape, 2)[..., ::-1]


def as_planar(points: Array) -> Planar:
    """Planar vectors of (x, z) pairs, (..., 2) -> (...)."""
    planar: Planar = points[..., 1] + 1j * points[..., 0]
    return planar


def forward_kinematics(q: Array, segment_length: Array | float, shear: Array | None = None) -> Chain:
    """Points of the chain whose joints sit in the middles of its segments, which are alike or (..., N) m long.

    `shear` (..., N) m is how far the chain slides before every joint, along x of the link before it; None: nowhere.
    """
    headings: Array = _sums_from_zero(q)
    directions, half = np.exp(1j * headings), np.asarray(segment_length) / 2
    to_joints = directions[..., :-1] * (half if shear is None else half + 1j * shear)
    segment_ends: Planar = _sums_from_zero(to_joints + directions[..., 1:] * half)
    return Chain(segment_ends[..., :-1] + to_joints, segment_ends, headings)


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
    path[..., 0::2] = chain.segment_ends + 1j * offset * np.exp(1j * chain.headings)
    path[..., 1::2] = chain.joints + 1j * offset * np.exp(1j * bisectors)
    return path


def segment_path_lengths(q: Array, segment_length: float, offset: Array | float) -> Array:
    """Length of the sensor path at `offset` over every segment, m: the distances along `sensor_path`.

    From the middle of a link to the bisector the path runs a - o sin(u) along the link and o (1 - cos(u))
    across it, with a half a segment, o the offset and u half the joint angle. Both halves of a segment are
    alike, so a segment's length depends on its own joint alone.
    """
    half_angle = q / 2
    along = segment_length / 2 - offset * np.sin(half_angle)
    across = offset * (1 - np.cos(half_angle))
    return 2 * np.hypot(along, across)
