"""A finger in balance: what pressure alone bends, and the torque of its own weight.

Leading axes are free; N joints.
"""

import numpy as np

from soft_gripper.arrays import Array, Planar
from soft_gripper.fingers.finger import Finger


def free_bending_angles(finger: Finger, pressure: Array) -> Array:
    """Equation (7): joint angles under pressure (...) Pa alone, rad, (..., N)."""
    return finger.angle(pressure[..., None] * finger.pressure_gain)


def gravity_torque(finger: Finger, q: Array, gravity: Planar | complex) -> Array:
    """Torque of the finger's own weight at every joint, N m, (..., N).

    What hangs beyond a joint pulls at it with the moments of the links' directions, which are all that bends.
    `gravity` is the acceleration in the bending plane, z + i x in B, m/s^2, a number or (..., 1).
    """
    directions = np.exp(1j * q.cumsum(axis=-1))
    torque: Array = (np.conj(directions @ finger.mass_moments) * gravity).imag
    return torque
