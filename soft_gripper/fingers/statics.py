"""A finger in balance: under pressure alone, and under pressure and weight after it has crept.

Leading axes are free; N joints.
"""

from dataclasses import replace

import numpy as np

from soft_gripper.arrays import Array, Planar
from soft_gripper.fingers.creep import shares
from soft_gripper.fingers.finger import Finger
from soft_gripper.fingers.kinematics import gravity_torque
from soft_gripper.piecewise_linear import PiecewiseLinear, PiecewiseLinearBlock

_BALANCE_ITERATIONS = 30
_MODULUS_FIELDS = ("youngs_modulus", "layer_modulus", "layer_shear_modulus")


def free_bending_angles(finger: Finger, pressure: Array) -> Array:
    """Equation (7): joint angles under pressure (...) Pa alone, before anything creeps, rad, (..., N)."""
    return finger.angle(finger.pressure_torque(pressure), pressure)


def relaxed_law(finger: Finger) -> PiecewiseLinear:
    """Torque against angle of every joint after a long hold: the elastic torque that remains after creep."""
    law, crept = finger.joint_law, float(shares(finger).sum()) * finger.stiffness
    return PiecewiseLinear(law.x, law.y - crept[:, None] * law.x)


def resting_angles(finger: Finger, pressure: Array | float, gravity: Planar | complex) -> Array:
    """Joint angles of a finger that has crept, in balance with pressure (...) Pa and its own weight, rad, (..., N).

    `gravity` is as for `gravity_torque`, a number or (...) m/s^2. Found by fixed-point iteration, which converges
    unless the finger buckles under its weight.
    """
    driven, gravity = finger.pressure_torque(pressure), np.asarray(gravity)[..., None]
    bends, remains = relaxed_law(finger).inverse(), 1 - shares(finger).sum()
    yields_more = (remains / (remains - finger.share_taken(pressure)))[..., None]  # of a linear finger: a factor
    q = yields_more * bends(driven)
    for _ in range(_BALANCE_ITERATIONS):
        q = yields_more * bends(driven + gravity_torque(finger, q, gravity))
    return q


def softened(finger: Finger, ratio: float) -> Finger:
    """The finger with all that is elastic in it divided by `ratio`; its neutral axis, creep and pressure gain stay."""
    law = finger.elastic_law
    if law is not None:
        moments = {name: tuple(m / ratio for m in getattr(law, name)) for name in ("base_moment", "tip_moment")}
        law = replace(law, **moments)
    return finger.with_sections(
        lambda section: replace(section, **{name: getattr(section, name) / ratio for name in _MODULUS_FIELDS}),
        elastic_law=law,
    )


def elastic_law_block(finger: Finger) -> PiecewiseLinearBlock:
    """Joint angles (N) rad -> torque (N) N m that turns the springs into the law: stiffness * q - law(q)."""
    law = finger.joint_law
    return PiecewiseLinearBlock(PiecewiseLinear(law.x, finger.stiffness[:, None] * law.x - law.y))
