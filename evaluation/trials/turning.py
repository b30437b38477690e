"""How an object is turned from the way it should stand: pure functions of R_GO, its orientation in the goal's frame."""

import numpy as np
from pydrake.math import RotationMatrix


def angle(R_GO: RotationMatrix) -> float:
    """Of the one rotation that leads from the goal's orientation to the object's, rad, 0 to pi."""
    return abs(float(R_GO.ToAngleAxis().angle()))


def tilt(R_GO: RotationMatrix) -> float:
    """Between the z axes, rad, 0 to pi; a turn of the object about its own z axis does not change it."""
    x, y, z = R_GO.col(2)
    return float(np.arctan2(np.hypot(x, y), z))


def yaw(R_GO: RotationMatrix) -> float:
    """Of the turn about the z axis that is left when the z axes are brought together, rad, -pi to pi."""
    quaternion = R_GO.ToQuaternion()
    turned = 2 * np.arctan2(quaternion.z(), quaternion.w())
    return float(np.arctan2(np.sin(turned), np.cos(turned)))
