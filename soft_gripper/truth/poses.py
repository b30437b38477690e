"""True poses of fingers in the plant, and the errors of estimated poses. All positions are in B, (..., 3) x, y, z.

The pressure and the true torque are sampled with the strain, and the true torque is delayed like the estimated one,
so that values of the same instant are compared.
"""

from collections.abc import Sequence
from functools import partial
from typing import Any

import numpy as np

from soft_gripper.array_block import ArrayBlock
from soft_gripper.arrays import Array
from soft_gripper.fingers.finger import Finger
from soft_gripper.fingers.finger_parts import SLIDES
from soft_gripper.fingers.kinematics import as_planar, in_space
from soft_gripper.fingers.plant_finger import PlantFinger
from soft_gripper.sensors.measurement import spatial_deformations
from soft_gripper.sensors.sensor_block import joints_port
from soft_gripper.signals import XYZ

TRUE_JOINTS, TRUE_TIP = "true_joint_positions", "true_tip_position"


class PlantPoints:
    """Joints and tips of fingers, from the positions of their plant; joints before a tip turn or slide."""

    def __init__(self, fingers: Sequence[PlantFinger]):
        self._chains = [finger.screws for finger in fingers]

    def __call__(self, state: Array) -> Array:
        """Positions of the joints and tip of each finger, finger by finger, (..., nq + nv) -> (..., P, 3) m in B."""
        return np.concatenate([chain.poses(state)[..., 1:, :, 3] for chain in self._chains], axis=-2)


def rotations_out_of_plane(finger: Finger) -> list[str]:
    return [name for name in ("sideways", "twist") if name in finger.yields]


class TruePoses(ArrayBlock):
    """Outputs the joint and tip positions of fingers from the plant.

    ::

        sampled_state (nq + nv) ---> +-----------+ ---> {finger}.true_joint_positions (N x 3) x, y, z; m in B
                                     | TruePoses | ---> {finger}.true_tip_position    (3) m in B
                                     |           | ---> {finger}.true_sideways_angles (N) rad
                                     |           | ---> {finger}.true_twist_angles    (N) rad
                                     +-----------+ ---> {finger}.true_stretch_lengths (N) m

    Positions follow from the poses of bodies, in three dimensions, and so from every joint that the plant has. Angles
    and lengths are those of fingers that yield that way.
    """

    def __init__(self, fingers: Sequence[PlantFinger]):
        """`fingers` are in one finalized plant."""
        super().__init__()
        self.take("sampled_state", fingers[0].plant.num_multibody_states())
        self.derive("points", PlantPoints(fingers), "sampled_state")
        begin = 0
        for finger in fingers:
            tip = begin + finger.finger.segments
            self._put_out_finger(finger, slice(begin, tip), tip)
            begin = tip + 1

    def _put_out_finger(self, finger: PlantFinger, joints: slice, tip_index: int) -> None:
        numbers = range(finger.finger.segments)
        name = f"{finger.name}.{TRUE_JOINTS}"
        self.put_out(name, lambda points: points[..., joints, :], "points", unit="m", joint=numbers, xyz=XYZ)
        for deformation in spatial_deformations(finger.finger)[1:]:
            starts = [joint.position_start() for joint in finger.joints_of(deformation)]
            self.put_out(
                f"{finger.name}.true_{joints_port(deformation)}",
                lambda state, starts=starts: state[..., starts],
                "sampled_state",
                unit="m" if deformation in SLIDES else "rad",
                joint=numbers,
            )
        self.put_out(f"{finger.name}.{TRUE_TIP}", lambda points: points[..., tip_index, :], "points", unit="m", xyz=XYZ)


def pose_error(true_joints: Array, joints: Array) -> Array:
    """The paper's metric: mean distance over all joint positions, (..., N, 3) m -> (...) m."""
    return np.linalg.norm(joints - true_joints, axis=-1).mean(axis=-1)


def fingertip_error(true_tip: Array, tip: Array) -> Array:
    """Distance between the fingertips, (..., 3) m -> (...) m."""
    return np.linalg.norm(tip - true_tip, axis=-1)


def corners(joints: Array, tip: Array) -> Array:
    """Ends of the links, from the base through the joints to the tip, (..., N + 2, 3) m."""
    base = np.zeros((*tip.shape[:-1], 1, 3))
    return np.concatenate([base, joints, tip[..., None, :]], axis=-2)


class PoseError(ArrayBlock):
    """Compares the estimated pose of a finger, which lies in its bending plane, with the true one of the same sample.

    ::

        true_joint_positions (N x 3) m in B -> +-----------+
        true_tip_position (3) m in B --------> | PoseError | ---> pose_error       (1) m
        joint_positions (N x 2) m in B ------> |           | ---> fingertip_error  (1) m
        tip_pose (3) x, z, heading in B -----> +-----------+

    Of an estimate in space it takes `estimated_joint_positions` (N x 3) and `estimated_tip_position` (3) instead.
    """

    def __init__(self, segments: int, in_space: bool = False):
        """`segments` is the number of joints, N; `in_space`: whether the shape is estimated there."""
        super().__init__()
        self.take(TRUE_JOINTS, segments * 3)
        self.take(TRUE_TIP, 3)
        joints, tip, size = "joint_positions", "tip_pose", 2
        if in_space:
            joints, tip, size = "estimated_joint_positions", "estimated_tip_position", 3
        self.take(joints, segments * size)
        self.take(tip, 3)
        self.put_out("pose_error", partial(_pose_error, size), TRUE_JOINTS, joints, unit="m")
        self.put_out("fingertip_error", partial(_tip_error, size), TRUE_TIP, tip, unit="m")


def _pose_error(size: int, true: Array, joints: Array) -> Array:
    points = joints.reshape(*joints.shape[:-1], -1, size)
    return pose_error(true.reshape(*true.shape[:-1], -1, 3), points if size == 3 else in_space(as_planar(points)))


def _tip_error(size: int, true: Array, tip: Array) -> Array:
    return fingertip_error(true, tip if size == 3 else in_space(as_planar(tip)))


class Difference(ArrayBlock):
    """Outputs the error of an estimate.

    ::

        estimate (n) ---> +------------+
                          | Difference | ---> difference (n)
        truth (n) ------> +------------+
    """

    def __init__(self, size: int, unit: str, **axes: Sequence[Any]):
        """`size` is the number of entries; unit and axes as for `describe`."""
        super().__init__()
        self.take("estimate", size)
        self.take("truth", size)
        self.put_out("difference", lambda estimate, truth: estimate - truth, "estimate", "truth", unit=unit, **axes)
