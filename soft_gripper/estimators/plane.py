"""The bending plane of a finger in the world, from the sampled pose of its base.

Ports carry the pose of B as the 12 numbers of the matrix [R | p], row after row, so that it can be sampled and logged
like any other signal.
"""

import numpy as np
from pydrake.math import RigidTransform

from soft_gripper.arrays import Array, Planar
from soft_gripper.fingers.kinematics import as_planar


def pose_entries(X_WB: RigidTransform) -> Array:
    """A pose as the 12 numbers that ports carry."""
    return X_WB.GetAsMatrix34().ravel()


def to_base(X_WB: Array, vector: Array) -> Array:
    """A vector of the world in B, (..., 3).

    Args:
        X_WB: base poses, their 12 entries, (..., 12), or (..., 3, 4).
        vector: in the world, (..., 3).
    """
    R = _pose(X_WB)[..., :3]
    return np.asarray((vector[..., None, :] @ R)[..., 0, :])


def planar_gravity(X_WB: Array, gravity: Array) -> Planar:
    """Gravity in the bending planes of base poses, z + i x, m/s^2; arguments as in `to_base`."""
    return as_planar(to_base(X_WB, gravity)[..., ::2])


def from_base(X_WB: Array, points: Array) -> Array:
    """Points of B, (..., M, 3) m, in the world; X_WB as for `to_base`."""
    pose = _pose(X_WB)
    return np.asarray(points @ np.swapaxes(pose[..., :3], -1, -2) + pose[..., None, :, 3])


def rotate_from_base(X_WB: Array, vector: Array) -> Array:
    """A vector of B in the world, (..., 3); X_WB as for `to_base`."""
    return np.asarray((_pose(X_WB)[..., :3] @ vector[..., None])[..., 0])


def _pose(X_WB: Array) -> Array:
    X_WB = np.asarray(X_WB)
    return X_WB if X_WB.shape[-2:] == (3, 4) else X_WB.reshape(*X_WB.shape[:-1], 3, 4)
