"""Where the links of an estimated finger are that leaves its plane: straight from joint to joint, without their twist.

Leading axes are free; N joints.
"""

import numpy as np

from soft_gripper.arrays import Array
from soft_gripper.fingers.finger import Finger


def link_frames(corners: Array) -> Array:
    """Rotations in B, (..., N + 1, 3, 3), of the links from base, joint to joint and tip, (..., N + 2, 3) m.

    Their z points along the link, and x lies in the plane of z and the x of B.
    """
    along = np.diff(corners, axis=-2)
    z = along / np.linalg.norm(along, axis=-1, keepdims=True)
    x = np.array([1.0, 0.0, 0.0]) - z[..., :1] * z
    x /= np.linalg.norm(x, axis=-1, keepdims=True)
    return np.stack([x, np.cross(z, x), z], axis=-1)


def pressed_point(finger: Finger, corners: Array, s: float, side: float) -> Array:
    """The point of the surface at an arc length, m, and an angle around the section, rad: (3) m in B.

    Args:
        finger: that is pressed.
        corners: base, joints and tip, (N + 2, 3) m in B.
        s: from the base.
        side: as `SpatialContact.side`.
    """
    link = int(np.searchsorted(finger.joint_arc_lengths, s))
    section, ends = finger.section(s), finger.link_ends
    half = np.array([section.inner_face - section.outer_face, section.width]) / 2
    toward = np.array([np.cos(side), np.sin(side)])
    across = toward * np.min(half / np.maximum(np.abs(toward), 1e-9))
    across[0] += (section.inner_face + section.outer_face) / 2
    share = (s - ends[link]) / (ends[link + 1] - ends[link])
    on_axis = corners[link] + share * (corners[link + 1] - corners[link])
    return np.asarray(on_axis + link_frames(corners)[link][:, :2] @ across)
