"""GripperOpening: the poses of the fingertips of a gripper -> how far they are apart."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from pydrake.math import RigidTransform
from pydrake.systems.framework import BasicVector, Context, LeafSystem

from soft_gripper.arrays import Array, Planar
from soft_gripper.fingers.kinematics import in_space
from soft_gripper.signals import describe

_IN_SPACE = np.array([[1.0, 0, 0], [0, 0, 1.0], [0, 0, 0]])  # (x, z, heading) @ this is (x, y, z)


def spread(points: Array) -> Array:
    """Twice the mean distance of points from their centroid, (..., F, 3) m -> (...) m.

    For two points that is their distance, for the corners of a regular polygon the diameter of its circle.
    """
    return 2 * np.linalg.norm(points - points.mean(axis=-2, keepdims=True), axis=-1).mean(axis=-1)


@dataclass(frozen=True)
class Gripper:
    """Where the bases of two or more fingers stand on one palm; frame G is that of the first finger's base.

    Raises:
        ValueError: if there are fewer than two fingers.
    """

    X_GB: tuple[RigidTransform, ...]

    def __post_init__(self) -> None:
        if len(self.X_GB) < 2:
            raise ValueError("a gripper has two fingers or more")

    @staticmethod
    def of_bases(X_WB: Sequence[RigidTransform]) -> "Gripper":
        """A gripper from where the bases of its fingers stand at one time."""
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
        """From the middle of the bases to each, (F, 3) m."""
        return self._origins - self._origins.mean(axis=0)

    def points(self, p_B: Array) -> Array:
        """Points, one in each B, as points in G, (..., F, 3) m."""
        points: Array = self._origins + (p_B[..., None, :] @ self._axes)[..., 0, :]
        return points

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
        signed = np.copysign(distances, np.add.reduce(from_middle * self._outward, axis=-1))
        opening: Array = 2 * (np.add.reduce(signed, axis=-1) / len(self.X_GB))
        return opening


class GripperOpening(LeafSystem):
    """Measures how far the tips of two or more fingers on one palm are apart.

    ::

        {finger}.tip_pose (3) x, z, heading ---> GripperOpening ---> opening  (1) m

    The opening is twice the mean distance of the tips from their centroid; for two fingers, their distance. Tips are
    points on the axes of the fingers. Each pose is planar in the base frame of its finger; where the bases stand to
    each other is part of the gripper and does not change.
    """

    def __init__(self, gripper: Gripper, fingers: Sequence[str]):
        """`fingers` are the names of the gripper's fingers, in its order."""
        super().__init__()
        self._gripper = gripper
        self._tips = [self.DeclareVectorInputPort(f"{finger}.tip_pose", 3) for finger in fingers]
        port = self.DeclareVectorOutputPort("opening", 1, self._calc_opening, {self.all_input_ports_ticket()})
        describe(port, "m")

    def _calc_opening(self, context: Context, output: BasicVector) -> None:
        tips = np.array([port.Eval(context) for port in self._tips]) @ _IN_SPACE
        output.SetAtIndex(0, float(self._gripper.opening(tips)))
