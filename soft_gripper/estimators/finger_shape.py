"""FingerShape: estimated joint angles -> joint positions, tip pose and arcs.

This is the contract between the estimators of the shape and what uses it. An estimator is a system with the output
port `estimated_joint_angles` (N) rad; it takes what it needs of the readings (`strain`, or what else its sensors
measure), `pressure`, `driving_torque` and `X_WB`, by these names. What else is asked of the shape follows from the
joint angles, by this block; an estimator that knows it better puts it out by itself, under the same names. Where it is
known, it adds `joint_angle_covariance` (N x N) rad^2.
"""

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from soft_gripper.array_block import ArrayBlock
from soft_gripper.arrays import Array, Planar
from soft_gripper.estimators.arcs import ArcCurve, Arcs, join_arcs
from soft_gripper.estimators.plane import bending_plane, to_world
from soft_gripper.fingers.finger import Finger
from soft_gripper.fingers.kinematics import Chain, as_points, forward_kinematics
from soft_gripper.signals import POSE, XYZ, XZ

ANGLES = "estimated_joint_angles"
ARC = ("x", "z", "heading", "kappa", "length", "center_x", "center_z")
ARC_UNITS = ("m", "m", "rad", "1/m", "m", "m", "m")
POSE_UNITS = ("m", "m", "rad")


def segment_arcs(finger: Finger, q: Array) -> Arcs:
    """The chain at joint angles (..., N) rad as a curve, an arc for every segment."""
    return join_arcs(q, np.full(finger.segments, finger.segment_length))


def planar_pose(place: Planar, heading: Array) -> Array:
    """Values of ports such as `tip_pose`, (..., 3): x, z, heading."""
    return np.concatenate([as_points(place), heading[..., None]], axis=-1)


def arc_table(arcs: Arcs) -> Array:
    """Values of the port `arcs`, (..., S, 7): start, heading and shape of each arc, and its centre for drawing."""
    bends = np.stack([arcs.heading, arcs.kappa, np.broadcast_to(arcs.length, arcs.theta.shape)], axis=-1)
    return np.concatenate([as_points(arcs.start), bends, as_points(arcs.centers)], axis=-1)


class FingerShape(ArrayBlock):
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
        joints = range(finger.segments)
        self.take(ANGLES, finger.segments)
        self.take("X_WB", 12)
        self.derive("chain", lambda q: forward_kinematics(q, finger.segment_length), ANGLES)
        put_out_arcs(self, lambda q: segment_arcs(finger, q), ANGLES, segment=joints)
        put_out_pose(self, "chain", joints)


def put_out_arcs(block: ArrayBlock, arcs: Callable[..., Arcs], source: str, **axis: Sequence[int]) -> None:
    """Declares the output `arcs` of a block, computed by a function from a step, along the named axis."""
    axes: dict[str, Any] = {**axis, "arc": ARC}
    block.put_out("arcs", lambda step: arc_table(arcs(step)), source, unit=ARC_UNITS, **axes)


def put_out_pose(block: ArrayBlock, curve: str, joints: Sequence[int]) -> None:
    """Declares the pose outputs of a block with the input X_WB; `curve` is the step that they come from."""

    def world(curve: Chain | ArcCurve, X_WB: Array) -> Array:
        return to_world(curve.joints, bending_plane(X_WB))

    block.put_out("joint_positions", lambda curve: as_points(curve.joints), curve, unit="m", joint=joints, xz=XZ)
    tip_pose = "tip_pose", lambda curve: planar_pose(curve.tip, curve.tip_heading), curve
    block.put_out(*tip_pose, unit=POSE_UNITS, pose=POSE)
    block.put_out("joint_positions_world", world, curve, "X_WB", unit="m", joint=joints, xyz=XYZ)
