"""Where a round peg would just touch a finger at rest."""

import numpy as np

from soft_gripper.arrays import Array
from soft_gripper.fingers.finger import Finger
from soft_gripper.fingers.kinematics import forward_kinematics

SIDES = {"inner": 1, "outer": -1}  # toward +x of B or away from it


def peg_center(finger: Finger, q: Array, s: float, side: str, radius: float) -> complex:
    """Centre, z + i x m in B, of a peg along y that touches the inner or the outer face at arc length `s` m."""
    chain, link = forward_kinematics(q, finger.segment_length), int(np.searchsorted(finger.joint_arc_lengths, s))
    direction = np.exp(1j * chain.headings[link])
    middle = chain.segment_ends[link]  # of the link, but for the first and the last, where the finger ends
    on_axis = middle + (s - link * finger.segment_length) * direction
    section = finger.section((finger.link_ends[link] + finger.link_ends[link + 1]) / 2)
    face = section.inner_face if side == "inner" else section.outer_face
    return complex(on_axis + 1j * (float(face) + SIDES[side] * radius) * direction)
