"""The bending plane of a finger in the world, from the sampled pose of its base.

Ports carry the pose of B as the 12 numbers of the matrix [R | p], row after row, so that it can be sampled and logged
like any other signal.
"""

from typing import NamedTuple

import numpy as np
from pydrake.math import RigidTransform

from soft_gripper.arrays import Array, Planar
from soft_gripper.fingers.kinematics import as_planar, as_points


class BendingPlane(NamedTuple):
    """Axes and origin of the bending plane; leading axes are free."""

    axes: Array  # (..., 2, 3) unit vectors, x and z of B
    origin: Array  # (..., 3) m

    def planar(self, vector: Array) -> Planar:
        """A vector of the world, (..., 3), in the bending plane: z + i x, (...)."""
        return as_planar((self.axes @ vector[..., None])[..., 0])


def pose_entries(X_WB: RigidTransform) -> Array:
    """The 12 numbers by which ports carry a pose."""
    entries: Array = X_WB.GetAsMatrix34().ravel()
    return entries


def bending_plane(X_WB: Array) -> BendingPlane:
    """The bending plane of a finger, from the 12 entries of its base pose, (..., 12)."""
    matrix = np.asarray(X_WB).reshape(*np.shape(X_WB)[:-1], 3, 4)
    return BendingPlane(np.ascontiguousarray(matrix[..., :3:2].swapaxes(-1, -2)), matrix[..., 3])


def planar_gravity(X_WB: Array, gravity: Array) -> Planar:
    """Gravity in the bending planes of base poses, z + i x, m/s^2.

    Args:
        X_WB: base poses, (..., 3, 4).
        gravity: in the world, (..., 3) m/s^2.
    """
    x, z = ((X_WB[..., :, axis] * gravity).sum(axis=-1) for axis in (0, 2))
    return np.asarray(z + 1j * x, dtype=complex)


def to_world(planar: Planar, plane: BendingPlane) -> Array:
    """Points of the bending plane, (..., M) m in B -> (..., M, 3) m in the world."""
    return as_points(planar) @ plane.axes + plane.origin[..., None, :]
