"""A finger in balance: what pressure alone bends, and the torque of its own weight.

Leading axes are free; N joints.
"""

from dataclasses import replace

import numpy as np

from soft_gripper.arrays import Array, Planar
from soft_gripper.fingers.finger import Finger

_REPETITIONS = 30


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


def resting_angles(finger: Finger, pressure: Array | float, gravity: Planar | complex) -> Array:
    """Joint angles in balance with pressure (...) Pa and the finger's own weight, rad, (..., N).

    `gravity` is as for `gravity_torque`, a number or (...) m/s^2. Found by repetition, which converges as long as the
    finger does not buckle under its weight.
    """
    driven, gravity = np.asarray(pressure)[..., None] * finger.pressure_gain, np.asarray(gravity)[..., None]
    q = finger.angle(driven)
    for _ in range(_REPETITIONS):
        q = finger.angle(driven + gravity_torque(finger, q, gravity))
    return q


def softened(finger: Finger, ratio: float) -> Finger:
    """The finger with all that is elastic in it divided by `ratio`; its neutral axis and pressure gain stay."""
    base, tip = (
        replace(end, youngs_modulus=end.youngs_modulus / ratio, layer_modulus=end.layer_modulus / ratio)
        for end in (finger.base, finger.tip)
    )
    law = finger.elastic_law
    if law is not None:
        moments = {name: tuple(m / ratio for m in getattr(law, name)) for name in ("base_moment", "tip_moment")}
        law = replace(law, **moments)
    return replace(finger, base=base, tip=tip, elastic_law=law)
