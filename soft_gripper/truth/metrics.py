"""PoseError: how far the estimated pose is from the true one."""

import numpy as np
from pydrake.common.value import AbstractValue
from pydrake.systems.framework import BasicVector, Context, LeafSystem, ValueProducer

from soft_gripper.arrays import Array, Planar
from soft_gripper.fingers.finger import Finger
from soft_gripper.fingers.kinematics import as_planar, forward_kinematics
from soft_gripper.signals import describe


def pose_error(true_joints: Planar, joints: Planar) -> Array:
    """The paper's metric: mean distance over all joint positions, (..., N) m -> (...) m."""
    return np.abs(joints - true_joints).sum(axis=-1) / joints.shape[-1]


def fingertip_error(true_tip: Planar, tip: Planar) -> Array:
    """Distance between the fingertips, (...) m."""
    return np.abs(tip - true_tip)


class PoseError(LeafSystem):
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
        self._finger = finger
        self._truth = self.DeclareVectorInputPort("sampled_joint_angles", finger.segments)
        self._shear = self.DeclareVectorInputPort("sampled_shear", finger.segments) if finger.shear_factor > 0 else None
        self._joints = self.DeclareVectorInputPort("joint_positions", finger.segments * 2)
        self._tip = self.DeclareVectorInputPort("tip_pose", 3)
        self._chain = self.DeclareCacheEntry(
            "true chain",
            ValueProducer(allocate=lambda: AbstractValue.Make(object()), calc=self._calc_chain),
            {port.ticket() for port in (self._truth, self._shear) if port is not None},
        )
        chain = self.cache_entry_ticket(self._chain.cache_index())
        for name, calc, estimate in (
            ("pose_error", self._calc_pose_error, self._joints),
            ("fingertip_error", self._calc_tip_error, self._tip),
        ):
            describe(self.DeclareVectorOutputPort(name, 1, calc, {chain, estimate.ticket()}), "m")

    def _calc_chain(self, context: Context, value: AbstractValue) -> None:
        shear = None if self._shear is None else self._shear.Eval(context)
        value.set_value(forward_kinematics(self._truth.Eval(context), self._finger.segment_length, shear))

    def _calc_pose_error(self, context: Context, output: BasicVector) -> None:
        joints = as_planar(self._joints.Eval(context).reshape(-1, 2))
        output.SetAtIndex(0, pose_error(self._chain.Eval(context).joints, joints))

    def _calc_tip_error(self, context: Context, output: BasicVector) -> None:
        tip = as_planar(self._tip.Eval(context)[:2])
        output.SetAtIndex(0, fingertip_error(self._chain.Eval(context).tip, tip))
