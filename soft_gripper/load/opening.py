"""GripperOpening: the poses of the fingertips of a gripper -> the gripper opening.

ObjectWidth: how wide the object is that the fingers of a gripper hold, from their estimated shapes.

Width and gripper opening are one measure, twice the mean distance of points from their centroid. For two points that
is their distance, so two fingers are not a special case.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from pydrake.math import RigidTransform

from soft_gripper.array_block import ArrayBlock
from soft_gripper.arrays import Array, Planar
from soft_gripper.estimators.finger_shape import ANGLES
from soft_gripper.fingers.finger import Finger
from soft_gripper.fingers.kinematics import in_space, link_directions, planar_vector

_PLANE_TO_SPACE = np.array([[1.0, 0, 0], [0, 0, 1.0], [0, 0, 0]])  # (x, z, heading) @ this is (x, y, z)


def mean_diameter(points: Array) -> Array:
    """Twice the mean distance of points from their centroid, (..., F, 3) m -> (...) m.

    For two points that is their distance, for the corners of a regular polygon the diameter of its circle.
    """
    return 2 * np.linalg.norm(points - points.mean(axis=-2, keepdims=True), axis=-1).mean(axis=-1)


@dataclass(frozen=True)
class Gripper:
    """Base poses of two or more fingers on one palm; frame G is the base frame of the first finger.

    Raises:
        ValueError: if there are fewer than two fingers.
    """

    X_GB: tuple[RigidTransform, ...]

    def __post_init__(self) -> None:
        if len(self.X_GB) < 2:
            raise ValueError("a gripper has two fingers or more")

    @staticmethod
    def of_bases(X_WB: Sequence[RigidTransform]) -> "Gripper":
        """A gripper from the base poses of its fingers at one time."""
        return Gripper(tuple(X_WB[0].inverse() @ X for X in X_WB))

    @cached_property
    def _origins(self) -> Array:
        return np.array([X.translation() for X in self.X_GB])

    @cached_property
    def _axes(self) -> Array:
        """x, y and z of every base, (F, 3, 3)."""
        return np.array([X.rotation().matrix().T for X in self.X_GB])

    @cached_property
    def _outward(self) -> Array:
        """Vectors from the bases' centroid, (F, 3) m."""
        return self._origins - self._origins.mean(axis=0)

    def points(self, p_B: Array) -> Array:
        """Points, one in each B, as points in G, (..., F, 3) m."""
        return self._origins + (p_B[..., None, :] @ self._axes)[..., 0, :]

    def curve(self, finger: int, planar: Planar) -> Array:
        """Points of one finger's bending plane, (..., M) m in its B, as points in G, (..., M, 3) m."""
        return self._origins[finger] + in_space(planar) @ self._axes[finger]

    def opening(self, tips: Array) -> Array:
        """Opening of fingertips, (..., F, 3) m, each in its own B; m, (...).

        Twice the mean distance of the tips from their centroid. Tips that have passed the middle, seen from their
        bases, count as negative.
        """
        points = self.points(tips)
        from_middle = points - np.add.reduce(points, axis=-2, keepdims=True) / len(self.X_GB)
        distances = np.sqrt(np.add.reduce(from_middle**2, axis=-1))
        signed_distances = np.copysign(distances, np.add.reduce(from_middle * self._outward, axis=-1))
        return 2 * (np.add.reduce(signed_distances, axis=-1) / len(self.X_GB))


class GripperOpening(ArrayBlock):
    """Measures the opening between the tips of two or more fingers on one palm.

    ::

        {finger}.tip_pose (3) x, z, heading ---> GripperOpening ---> opening  (1) m

    The opening is twice the mean distance of the tips from their centroid; for two fingers, their distance. Tips are
    points on the axes of the fingers. Each pose is planar in the base frame of its finger; where the bases stand to
    each other is part of the gripper and does not change.
    """

    def __init__(self, gripper: Gripper, fingers: Sequence[str]):
        """`fingers` are the names of the gripper's fingers, in its order."""
        super().__init__()
        ports = [f"{finger}.tip_pose" for finger in fingers]
        for port in ports:
            self.take(port, 3)
        self.put_out(
            "opening", lambda *tips: gripper.opening(np.stack(tips, axis=-2) @ _PLANE_TO_SPACE), *ports, unit="m"
        )


_POINTS_PER_SEGMENT = 4  # on the inner surface, for every segment
_SAMPLES_PER_BATCH = 256  # samples of which all pairs of points are compared at once, 20 kB each
_SEARCH_ROUNDS = 4  # over all fingers, in search of the narrowest point


@dataclass(frozen=True)
class InnerSurface:
    """Points along the inner side of a finger, a few for every segment, from the base to the edge at the tip."""

    finger: Finger

    @cached_property
    def levers(self) -> Planar:
        """Levers of each point along the direction and the inner normal of each link, m, (N + 1, M)."""
        finger, ends = self.finger, self.finger.link_ends
        s = np.linspace(0.0, finger.length, _POINTS_PER_SEGMENT * finger.segments + 1)
        link_parts = np.clip(s - ends[:-1, None], 0.0, np.diff(ends)[:, None])
        own_link = np.searchsorted(ends[1:-1], s) == np.arange(finger.segments + 1)[:, None]
        return planar_vector(own_link * finger.section(s).inner_face, link_parts)

    def points(self, q: Array) -> Planar:
        """The points at joint angles (..., N) rad, m in B, (..., M)."""
        return self.levers[0] + link_directions(q) @ self.levers[1:]


def narrowest(curves: Sequence[Array]) -> Array:
    """The smallest mean diameter of points, one of each curve, (..., M, 3) m each; (...) m.

    Compares all pairs of two curves. Of more it looks at points that lie equally far along them, and from the best of
    these moves one point at a time.
    """
    shape = curves[0].shape[:-2]
    batches = [curve.reshape(-1, *curve.shape[-2:]) for curve in curves]
    if len(curves) == 2:
        batch_starts = range(0, len(batches[0]), _SAMPLES_PER_BATCH)
        gaps = [_gap(*(curve[start : start + _SAMPLES_PER_BATCH] for curve in batches)) for start in batch_starts]
        return np.concatenate([np.empty(0), *gaps]).reshape(shape)
    return np.array([_narrowest_of_many(sample_curves) for sample_curves in zip(*batches, strict=True)]).reshape(shape)


def _gap(points: Array, other_points: Array) -> Array:
    """The least distance of the points of two curves, (..., M, 3) m; (...) m."""
    middle = points.mean(axis=-2, keepdims=True)  # near both, so that few digits are lost
    points, other_points = points - middle, other_points - middle
    squares, other_squares = np.add.reduce(points**2, axis=-1), np.add.reduce(other_points**2, axis=-1)
    squares_between = (
        squares[..., :, None] + other_squares[..., None, :] - 2 * points @ np.swapaxes(other_points, -1, -2)
    )
    return np.sqrt(np.maximum(squares_between.min(axis=(-2, -1)), 0.0))


def _narrowest_of_many(curves: Sequence[Array]) -> float:
    """Smallest mean diameter of points of three or more curves at one sample, m, see `narrowest`."""
    fractions = np.linspace(0.0, 1.0, max(map(len, curves)))
    points = np.stack([curve[np.round(fractions * (len(curve) - 1)).astype(int)] for curve in curves], axis=1)
    narrowest_points = points[np.argmin(mean_diameter(points))]
    for _ in range(_SEARCH_ROUNDS):
        for i, curve in enumerate(curves):
            choices = np.repeat(narrowest_points[None], len(curve), axis=0)
            choices[:, i] = curve
            narrowest_points = choices[np.argmin(mean_diameter(choices))]
    return float(mean_diameter(narrowest_points))


class ObjectWidth(ArrayBlock):
    """Measures the width of the object held between the fingers of one palm.

    ::

        {finger}.estimated_joint_angles (N) rad ---> +-------------+
        {finger}.contact (1) 0 or 1 ---------------> | ObjectWidth | ---> object_width  (1) m, NaN unless all touch
                                                     +-------------+

    The width is the smallest spread of points on the inner surfaces, one of each finger: for
    two fingers the smallest gap, for more the diameter of what they close on. It is that of an object that they hold
    by its widest place, as tips hold a box. Where the bases stand to each other is part of the gripper and does not
    change. Skin that gives way is not allowed for, since how much depends on where and how the object is touched.
    """

    def __init__(self, gripper: Gripper, fingers: Mapping[str, Finger]):
        """`fingers` are those of the gripper, in its order, by the names of their ports."""
        super().__init__()
        self._gripper, self._surfaces = gripper, [InnerSurface(finger) for finger in fingers.values()]
        angles, contacts = ([f"{name}.{kind}" for name in fingers] for kind in (ANGLES, "contact"))
        for name, finger in zip(angles, fingers.values(), strict=True):
            self.take(name, finger.segments)
        for name in contacts:
            self.take(name, 1)
        self.put_out("object_width", self._width, *angles, *contacts, unit="m")

    def _width(self, *inputs: Array) -> Array:
        """Width, (...) m, from the joint angles of all fingers, (..., N) rad, and then their contacts, (..., 1)."""
        finger_count = len(self._surfaces)
        angles, contacts = inputs[:finger_count], np.concatenate(inputs[finger_count:], axis=-1)
        is_held = contacts.all(axis=-1) & np.logical_and.reduce([np.isfinite(q).all(axis=-1) for q in angles])
        held_points = (surface.points(q[is_held]) for surface, q in zip(self._surfaces, angles, strict=True))
        curves = [self._gripper.curve(i, points) for i, points in enumerate(held_points)]
        width = np.full(is_held.shape, np.nan)
        width[is_held] = narrowest(curves)
        return width
