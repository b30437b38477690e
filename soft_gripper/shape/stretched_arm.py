"""Where the bodies of an arm are whose sections bend and lengthen, with rigid parts between them.

The joints of a section share its length; behind every section lies a rigid part, and to its end a body is fixed. In
planar vectors z + i x (see `kinematics`), with h_s the heading at the end of section s,

    e_s = p_base + exp(i tilt) chain_s + sum over sections r before s of  d_r exp(i h_r) ,
    p_s = e_s + m_s exp(i h_s) ,

where chain_s is the end of section s along the stretched chain.

Leading axes are free; S sections, N joints.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from soft_gripper.arrays import Array, Planar
from soft_gripper.fingers.kinematics import forward_kinematics


@dataclass(frozen=True)
class RigidParts:
    """The rigid parts of a certain arm."""

    base: complex  # m, of the first section in B
    tilt: float  # rad, of the first section in B
    couplings: Planar  # (S,) m, d: from the end of a section to the beginning of the next
    bodies: Planar  # (S,) m, m: from the end of a section to the body that is fixed there
    turns: Array  # (S,) rad, of the axes of the bodies from the headings of their sections


def stretched_arm(
    parts: RigidParts, q: Array, lengths: Array, section_ends: NDArray[np.int_]
) -> tuple[Planar, Planar, Array]:
    """Joints (..., N) m, bodies (..., S) m, both in B, and headings of the bodies (..., S) rad.

    Args:
        parts: what is rigid.
        q: joint angles, (..., N) rad.
        lengths: of the sections, (..., S) m.
        section_ends: joints up to the end of every section, from 0 to N, (S + 1,).
    """
    joints = np.diff(section_ends)
    chain = forward_kinematics(q, np.repeat(lengths / joints, joints, axis=-1))
    headings = parts.tilt + chain.headings[..., section_ends[1:]]
    shifts = parts.couplings * np.exp(1j * headings)
    before = shifts.cumsum(axis=-1) - shifts
    turned = np.exp(1j * parts.tilt)
    ends = parts.base + turned * chain.segment_ends[..., section_ends[1:]] + before
    along = parts.base + turned * chain.joints + np.repeat(before, joints, axis=-1)
    return along, ends + parts.bodies * np.exp(1j * headings), headings + parts.turns
