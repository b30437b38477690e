"""FingerShape: estimated joint angles -> all that follows from them.

This is the contract between the estimators of the shape and what uses it. An estimator is a system with the output
port `estimated_joint_angles` (N) rad; it takes what it needs of `strain`, `pressure`, `driving_torque` and `X_WB`, by
these names. What
else is asked of the shape follows from the joint angles, by this block; an estimator that knows it better puts it out
by itself, under the same names. Where it is known, it adds `joint_angle_covariance` (N x N) rad^2.
"""

from typing import NamedTuple

import numpy as np
from pydrake.common.value import AbstractValue
from pydrake.systems.framework import BasicVector, Context, LeafSystem, ValueProducer

from soft_gripper.arrays import Array, Planar
from soft_gripper.fingers.finger import Finger
from soft_gripper.fingers.kinematics import as_points, forward_kinematics
from soft_gripper.shape.arcs import Arcs, join_arcs
from soft_gripper.shape.bending_plane import bending_plane, to_world
from soft_gripper.signals import POSE, XYZ, XZ, describe

ANGLES = "estimated_joint_angles"
ARC = ("x", "z", "heading", "kappa", "length", "center_x", "center_z")
ARC_UNITS = ("m", "m", "rad", "1/m", "m", "m", "m")
POSE_UNITS = ("m", "m", "rad")


class Shape(NamedTuple):
    """A finger as it is estimated to be bent, in B."""

    joints: Planar  # (N) m
    tip: Array  # (3) x, z, heading
    arcs: Arcs


def chain_shape(finger: Finger, q: Array) -> Shape:
    """The shape of the chain at joint angles (N) rad; as a curve, an arc for every segment."""
    chain = forward_kinematics(q, finger.segment_length)
    tip = np.array([chain.tip.imag, chain.tip.real, chain.headings[-1]])
    return Shape(chain.joints, tip, join_arcs(q, np.full(finger.segments, finger.segment_length)))


def arc_table(arcs: Arcs) -> Array:
    """What the port `arcs` carries, (S, 7): where and in which direction each begins, with its centre for drawing."""
    start, center = arcs.start, arcs.centers
    columns = (start.imag, start.real, arcs.heading, arcs.kappa, arcs.length, center.imag, center.real)
    return np.array(columns).T


class FingerShape(LeafSystem):
    """The pose of one finger from its estimated joint angles.

    ::

        estimated_joint_angles (N) rad ---> +-------------+ ---> arcs                   (N x 7) an arc a segment
                                            | FingerShape | ---> joint_positions        (N x 2) x, z; m in B
        X_WB (12) [R | p] ----------------> |             | ---> joint_positions_world  (N x 3) m
                                            +-------------+ ---> tip_pose               (3) x, z, heading in B

    Matrices leave their ports row after row. Stateless.
    """

    def __init__(self, finger: Finger):
        super().__init__()
        self._finger = finger
        angles = self.DeclareVectorInputPort(ANGLES, finger.segments)
        self._angles, self._X_WB = angles, self.DeclareVectorInputPort("X_WB", 12)
        producer = ValueProducer(allocate=lambda: AbstractValue.Make(object()), calc=self._calc_shape)
        self._shape = self.DeclareCacheEntry("shape", producer, {angles.ticket()})
        shape, joints = self.cache_entry_ticket(self._shape.cache_index()), range(finger.segments)

        def calc_arcs(context: Context, output: BasicVector) -> None:
            output.SetFromVector(arc_table(self._shape.Eval(context).arcs).ravel())

        def calc_joints(context: Context, output: BasicVector) -> None:
            output.SetFromVector(as_points(self._shape.Eval(context).joints).ravel())

        def calc_tip(context: Context, output: BasicVector) -> None:
            output.SetFromVector(self._shape.Eval(context).tip)

        table = self.DeclareVectorOutputPort("arcs", 7 * len(joints), calc_arcs, {shape})
        describe(table, ARC_UNITS, segment=joints, arc=ARC)
        positions = self.DeclareVectorOutputPort("joint_positions", 2 * len(joints), calc_joints, {shape})
        describe(positions, "m", joint=joints, xz=XZ)
        describe(self.DeclareVectorOutputPort("tip_pose", 3, calc_tip, {shape}), POSE_UNITS, pose=POSE)
        world = {shape, self._X_WB.ticket()}
        in_world = self.DeclareVectorOutputPort("joint_positions_world", 3 * len(joints), self._calc_world, world)
        describe(in_world, "m", joint=joints, xyz=XYZ)

    def _calc_shape(self, context: Context, value: AbstractValue) -> None:
        value.set_value(chain_shape(self._finger, self._angles.Eval(context)))

    def _calc_world(self, context: Context, output: BasicVector) -> None:
        plane = bending_plane(self._X_WB.Eval(context))
        output.SetFromVector(to_world(self._shape.Eval(context).joints, plane).ravel())
