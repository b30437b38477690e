"""How uncertain the places of a finger's joints and its tip are, from the covariance of its joint angles.

A joint j that turns by dq moves what lies beyond it by  i (r - r_j) dq , r being its place as a planar vector. To
first order the place across the finger, along the normal n, has the variance  J P J^T  with  J_j = Re(conj(n) i (r -
r_j)) .

Leading axes are free; N joints.
"""

import numpy as np

from soft_gripper.arrays import Array, Planar
from soft_gripper.fingers.finger import Finger
from soft_gripper.fingers.kinematics import Chain, forward_kinematics


def position_std(finger: Finger, q: Array, covariance: Array) -> Array:
    """Standard deviations across the finger of its joints and of its tip, m, (..., N + 1).

    Args:
        finger: as it is believed to be.
        q: estimated joint angles, rad, (..., N).
        covariance: of these, rad^2, (..., N, N).
    """
    chain = forward_kinematics(q, finger.segment_length)
    moved = position_jacobian(chain)
    across = (np.conj(1j * np.exp(1j * chain.headings))[..., None] * moved).real
    return np.sqrt(np.maximum(((across @ covariance) * across).sum(axis=-1), 0))


def position_jacobian(chain: Chain) -> Planar:
    """By how much joints and tip move with every joint angle, z + i x, m/rad, (..., N + 1, N)."""
    points = np.concatenate([chain.joints, chain.tip[..., None]], axis=-1)
    beyond = np.tri(*(points.shape[-1], chain.joints.shape[-1]), -1)
    jacobian: Planar = 1j * (points[..., :, None] - chain.joints[..., None, :]) * beyond
    return jacobian
