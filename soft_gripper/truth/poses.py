"""True poses of fingers in the plant, and the errors of estimated poses. All positions are in B, (..., 3) x, y, z.

The pressure and the true torque are sampled with the strain, and the true torque is delayed like the estimated one,
so that values of the same instant are compared.
"""

from collections.abc import Sequence
from typing import Any

import numpy as np

from soft_gripper.array_block import ArrayBlock
from soft_gripper.arrays import Array
from soft_gripper.fingers.finger import Finger
from soft_gripper.fingers.kinematics import as_planar, in_space
from soft_gripper.fingers.plant_finger import PlantFinger
from soft_gripper.signals import XYZ

TRUE_JOINTS, TRUE_TIP = "true_joint_positions", "true_tip_position"


class PlantPoints:
    """Joints and tips of fingers, from the positions of their plant.

    It has a plant of its own, since a block that kept the plant of its diagram would keep the diagram alive.
    """

    def __init__(self, fingers: Sequence[PlantFinger]):
        """`fingers` are in one finalized plant."""
        self._plant = fingers[0].plant.Clone()
        self._context = self._plant.CreateDefaultContext()
        # Positions in B do not depend on free bodies, whose quaternions are zero before the first sample.
        bodies = map(self._plant.get_body, self._plant.GetFloatingBaseBodies())
        starts = (body.floating_positions_start() for body in bodies)
        self._free = [entry for start in starts for entry in range(start, start + 7)]
        self._where_free = self._plant.GetPositions(self._context)[self._free]
        pairs = [(frame, finger.base.body_frame()) for finger in fingers for frame in finger.frames]
        self._pairs = [tuple(self._plant.get_frame(frame.index()) for frame in pair) for pair in pairs]

    def __call__(self, state: Array) -> Array:
        """Positions of the joints and tip of each finger, finger by finger, (..., nq + nv) -> (..., P, 3) m in B."""
        rows = np.reshape(state, (-1, np.shape(state)[-1]))[:, : self._plant.num_positions()].copy()
        rows[:, self._free] = self._where_free
        places = np.array([self._places(row) for row in rows])
        return places.reshape(*np.shape(state)[:-1], -1, 3)

    def _places(self, positions: Array) -> list[Array]:
        self._plant.SetPositions(self._context, positions)
        return [frame.CalcPose(self._context, base).translation() for frame, base in self._pairs]


class TruePoses(ArrayBlock):
    """Outputs the joint and tip positions of fingers from the plant.

    ::

        sampled_state (nq + nv) ---> +-----------+ ---> {finger}.true_joint_positions (N x 3) x, y, z; m in B
                                     | TruePoses | ---> {finger}.true_tip_position    (3) m in B
                                     +-----------+

    They follow from the poses of bodies, in three dimensions, and so from every joint that the plant has.
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

    def _put_out_finger(self, finger: PlantFinger, joints: slice, tip: int) -> None:
        numbers = range(finger.finger.segments)
        self.put_out(
            f"{finger.name}.{TRUE_JOINTS}",
            lambda points: points[..., joints, :],
            "points",
            unit="m",
            joint=numbers,
            xyz=XYZ,
        )
        self.put_out(f"{finger.name}.{TRUE_TIP}", lambda points: points[..., tip, :], "points", unit="m", xyz=XYZ)


def pose_error(true_joints: Array, joints: Array) -> Array:
    """The paper's metric: mean distance over all joint positions, (..., N, 3) m -> (...) m."""
    error: Array = np.linalg.norm(joints - true_joints, axis=-1).mean(axis=-1)
    return error


def fingertip_error(true_tip: Array, tip: Array) -> Array:
    """Distance between the fingertips, (..., 3) m -> (...) m."""
    error: Array = np.linalg.norm(tip - true_tip, axis=-1)
    return error


def corners(joints: Array, tip: Array) -> Array:
    """Ends of the links, from the base through the joints to the tip, (..., N + 2, 3) m."""
    base = np.zeros((*tip.shape[:-1], 1, 3))
    return np.concatenate([base, joints, tip[..., None, :]], axis=-2)


def points_along(finger: Finger, corners: Array, s: Array) -> Array:
    """Points at arc lengths (M) m from the base, (..., M, 3) m, of links from corner to corner, (..., N + 2, 3) m."""
    link = np.searchsorted(finger.joint_arc_lengths, s)
    share = (s - finger.link_ends[link]) / np.diff(finger.link_ends)[link]
    begins = corners[..., link, :]
    points: Array = begins + share[:, None] * (corners[..., link + 1, :] - begins)
    return points


class PoseError(ArrayBlock):
    """Compares the estimated pose of a finger, which lies in its bending plane, with the true one of the same sample.

    ::

        true_joint_positions (N x 3) m in B -> +-----------+
        true_tip_position (3) m in B --------> | PoseError | ---> pose_error       (1) m
        joint_positions (N x 2) m in B ------> |           | ---> fingertip_error  (1) m
        tip_pose (3) x, z, heading in B -----> +-----------+
    """

    def __init__(self, segments: int):
        """`joints` is the number of joints, N."""
        super().__init__()
        self.take(TRUE_JOINTS, segments * 3)
        self.take(TRUE_TIP, 3)
        self.take("joint_positions", segments * 2)
        self.take("tip_pose", 3)
        self.put_out("pose_error", _pose_error, TRUE_JOINTS, "joint_positions", unit="m")
        self.put_out("fingertip_error", _tip_error, TRUE_TIP, "tip_pose", unit="m")


def _pose_error(true: Array, joints: Array) -> Array:
    estimated = as_planar(joints.reshape(*joints.shape[:-1], -1, 2))
    return pose_error(true.reshape(*true.shape[:-1], -1, 3), in_space(estimated))


def _tip_error(true: Array, pose: Array) -> Array:
    return fingertip_error(true, in_space(as_planar(pose[..., :2])))


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
