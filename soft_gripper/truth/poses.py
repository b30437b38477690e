"""PoseError: how far the estimated pose is from the true one.

The pressure and the true torque are sampled with the strain, and the true torque is delayed like the estimated one,
so that values of the same instant are compared.
"""

from collections.abc import Sequence
from typing import Any

import numpy as np

from soft_gripper.array_block import ArrayBlock
from soft_gripper.arrays import Array, Planar
from soft_gripper.fingers.finger import Finger
from soft_gripper.fingers.kinematics import Chain, as_planar, forward_kinematics


def pose_error(true_joints: Planar, joints: Planar) -> Array:
    """The paper's metric: mean distance over all joint positions, (..., N) m -> (...) m."""
    return np.abs(joints - true_joints).sum(axis=-1) / joints.shape[-1]


def fingertip_error(true_tip: Planar, tip: Planar) -> Array:
    """Distance between the fingertips, (...) m."""
    return np.abs(tip - true_tip)


class PoseError(ArrayBlock):
    """Compares the estimated pose of a finger with the true one at the same sample.

    ::

        sampled_joint_angles (N) rad -------> +-----------+
        joint_positions (N x 2) m in B -----> | PoseError | ---> pose_error       (1) m
        tip_pose (3) x, z, heading in B ----> |           | ---> fingertip_error  (1) m
        sampled_shear (N) m ----------------> +-----------+

    There is `sampled_shear` for a finger that shears: how far it slides before each joint.
    """

    def __init__(self, finger: Finger):
        super().__init__()
        joints = finger.segments
        self.take("sampled_joint_angles", joints)
        self.take("joint_positions", joints * 2)
        self.take("tip_pose", 3)
        truth = ["sampled_joint_angles"]
        if finger.shear_factor > 0:
            self.take("sampled_shear", joints)
            truth.append("sampled_shear")
        self.derive("chain", lambda q, *shear: forward_kinematics(q, finger.segment_length, *shear), *truth)
        self.put_out("pose_error", _pose_error, "chain", "joint_positions", unit="m")
        self.put_out("fingertip_error", _tip_error, "chain", "tip_pose", unit="m")


def _pose_error(chain: Chain, positions: Array) -> Array:
    return pose_error(chain.joints, as_planar(positions.reshape(*positions.shape[:-1], -1, 2)))


def _tip_error(chain: Chain, pose: Array) -> Array:
    return fingertip_error(chain.tip, as_planar(pose[..., :2]))


class Difference(ArrayBlock):
    """Says by how much an estimate is off.

    ::

        estimate (n) ---> +------------+
                          | Difference | ---> difference (n)
        truth (n) ------> +------------+
    """

    def __init__(self, size: int, unit: str, **axes: Sequence[Any]):
        """Of vectors with so many entries; unit and axes as for `describe`."""
        super().__init__()
        self.take("estimate", size)
        self.take("truth", size)
        self.put_out("difference", lambda estimate, truth: estimate - truth, "estimate", "truth", unit=unit, **axes)
