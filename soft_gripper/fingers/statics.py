"""A finger in balance: under pressure alone, and under pressure and weight after it has crept.

Leading axes are free; N joints.
"""

from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np

from soft_gripper.arrays import Array, Planar
from soft_gripper.fingers.creep import shares
from soft_gripper.fingers.finger import Finger
from soft_gripper.fingers.finger_parts import PressureLaw
from soft_gripper.fingers.kinematics import forward_kinematics, gravity_torque
from soft_gripper.piecewise_linear import PiecewiseLinear, PiecewiseLinearBlock

_MAX_ITERATIONS, _ANGLE_TOLERANCE = 30, 1e-12  # and rad
_LAW_PRESSURE = 1e5  # Pa, a point of a straight pressure law
_MODULUS_FIELDS = ("youngs_modulus", "layer_modulus", "layer_shear_modulus")


def free_bending_angles(finger: Finger, pressure: Array) -> Array:
    """Equation (7): joint angles under pressure (...) Pa alone, before anything creeps, rad, (..., N)."""
    return finger.angle(finger.pressure_torque(pressure), pressure)


def relaxed_law(finger: Finger) -> PiecewiseLinear:
    """Torque against angle of every joint after a long hold: the elastic torque that remains after creep."""
    law, creep_stiffness = finger.joint_law, float(shares(finger).sum()) * finger.stiffness
    return PiecewiseLinear(law.x, law.y - creep_stiffness[:, None] * law.x)


class FacePress(NamedTuple):
    """A force on a face of a finger, measured by an instrument at `place` along `axis`, with friction on the face.

    A positive force presses on the inner face.
    """

    force: Array  # (...) N, the part along the axis
    place: Array  # (...) m along the finger, from its base
    axis: complex | None = None  # z + i x in B, of length 1; None: across the finger
    friction: float = 0.0  # force along the face, toward the tip, over the force across it

    def face(self, finger: Finger) -> Array:
        """Distance of the pressed face from the axis, (...) m, positive on the inner side."""
        section = finger.section(self.place)
        return np.where(self.force < 0, section.outer_face, section.inner_face)

    def torque(self, finger: Finger, q: Array) -> Array:
        """Torque at the joints in a posture, (..., N) N m."""
        site = forward_kinematics(q, finger.segment_length).sites(self.place[..., None], self.face(finger)[..., None])
        force = -site.normals + self.friction * site.directions
        axis_component = 1.0 if self.axis is None else (force * np.conj(self.axis)).real
        return site.torques(self.force[..., None] * force / axis_component)[..., 0, :]


def resting_angles(
    finger: Finger, pressure: Array | float, gravity: Planar | complex, press: FacePress | None = None
) -> Array:
    """Joint angles of a finger that has crept, in balance with pressure (...) Pa and its own weight, rad, (..., N).

    `gravity` is as for `gravity_torque`, a number or (...) m/s^2, and `press` a force in addition. Found by fixed-point
    iteration, which converges unless the finger buckles under its weight.
    """
    driving, gravity = finger.pressure_torque(pressure), np.asarray(gravity)[..., None]
    bends = relaxed_law(finger).inverse()
    relaxed = 1 - shares(finger).sum()  # fraction of the stiffness
    bend_factor = (relaxed / (relaxed - finger.share_taken(pressure)))[..., None]  # of a linear finger
    q = bend_factor * bends(driving)
    for _ in range(_MAX_ITERATIONS):
        press_torque = 0.0 if press is None else press.torque(finger, q)
        last_q, q = q, bend_factor * bends(driving + gravity_torque(finger, q, gravity) + press_torque)
        if np.abs(q - last_q).max(initial=0.0) < _ANGLE_TOLERANCE:
            break
    return q


def softened(finger: Finger, ratio: float, variation: float = 0.0) -> Finger:
    """The finger with all that is elastic in it divided by `ratio`; its neutral axis, creep and pressure gain stay.

    The ratio changes linearly along the finger by the fraction `variation` from its middle to its tip, and by as much
    to its base.
    """
    law, ratios = finger.elastic_law, ratio * (1 + variation * (2 * np.array(finger.places) - 1))
    if law is not None:
        ends = {"base_moment": ratios[0], "tip_moment": ratios[-1]}
        law = replace(law, **{name: tuple(m / end for m in getattr(law, name)) for name, end in ends.items()})
    cross_sections: list[Any] = [*finger.cross_sections]
    base, *inner_sections, tip = (
        replace(section, **{name: getattr(section, name) / divisor for name in _MODULUS_FIELDS})
        for section, divisor in zip(cross_sections, ratios.tolist(), strict=True)
    )
    return replace(finger, base=base, sections=tuple(inner_sections), tip=tip, elastic_law=law)


def strengthened(finger: Finger, factor: float) -> Finger:
    """The finger with stiffness and torque of its one pressure times a factor: its free bending is unchanged."""
    if factor == 1:
        return finger
    law = finger.laws[0] or PressureLaw((0.0, _LAW_PRESSURE), (0.0, _LAW_PRESSURE))
    law = replace(law, effective=tuple(factor * effective for effective in law.effective))
    chambers = tuple(replace(chamber, law_pressure=None, law_effective=None) for chamber in finger.chambers)
    return replace(softened(finger, 1 / factor), pressure_law=law, chambers=chambers)


def elastic_law_block(finger: Finger) -> PiecewiseLinearBlock:
    """Joint angles (N) rad -> torque (N) N m that turns the springs into the law: stiffness * q - law(q)."""
    law = finger.joint_law
    return PiecewiseLinearBlock(PiecewiseLinear(law.x, finger.stiffness[:, None] * law.x - law.y))
