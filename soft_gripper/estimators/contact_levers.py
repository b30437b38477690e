"""What a force on a finger does to its joints.

A force of 1 N at arc length s presses across the finger, from the inner to the outer side: it points along -i d ,
with d the direction of the link that it presses on. At a joint i before it, at r_i, it has the torque

    Im conj(r(s) - r_i) (-i d)  =  - Re conj(r(s) - r_i) d ,

which opens the finger. One along the finger, toward the tip, in the line of the neutral axis has  Im conj(r(s) - r_i)
d . A force that rubs on a face at the offset o from the axis has the torque -o more; the inner face is close to the
axis.

Leading axes are free; M places, N joints.
"""

import numpy as np

from soft_gripper.arrays import Array, Planar
from soft_gripper.fingers.finger import Finger
from soft_gripper.fingers.kinematics import Chain


def unit_torques(finger: Finger, chain: Chain, s: Array) -> Planar:
    """Torques of forces of 1 N at the joints, N m, (..., M, N): across the finger (real) and along it (imaginary).

    Args:
        finger: whose skin the forces press on.
        chain: where the bent finger lies, of leading axes (...).
        s: arc lengths where they press, m, (..., M).
    """
    link = np.searchsorted(finger.joint_arc_lengths, s)
    begins = np.concatenate([np.zeros_like(chain.tip)[..., None], chain.joints], axis=-1)
    direction = np.exp(1j * np.take_along_axis(chain.headings, link, axis=-1))
    place = np.take_along_axis(begins, link, axis=-1) + direction * (s - finger.link_ends[link])
    before = np.arange(finger.segments) < link[..., None]
    lever = np.conj(place[..., None] - chain.joints[..., None, :]) * direction[..., None] * before
    torques: Planar = -lever.conj()
    return torques


def face_offset(finger: Finger, s: Array, side: Array) -> Array:
    """How far the face lies from the neutral axis, m: the inner one where `side` is positive, else the outer, (...)."""
    section = finger.section(s)
    offset: Array = np.where(side > 0, section.inner_face, section.outer_face)
    return offset
