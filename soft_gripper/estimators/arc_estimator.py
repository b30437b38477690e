"""ArcPoseEstimator: strain readings -> the pose of the finger as circular arcs."""

from dataclasses import dataclass
from functools import partial

import numpy as np

from soft_gripper.array_block import ArrayBlock
from soft_gripper.arrays import Array, Planar
from soft_gripper.estimators.arcs import Arcs, arcs_from_readings, bends_from_readings, join_arcs, joints_on_arcs
from soft_gripper.estimators.bend_sharing import BendSharing
from soft_gripper.estimators.driving_torque import DRIVING_TORQUE
from soft_gripper.estimators.estimate import ShapeEstimate
from soft_gripper.estimators.finger_shape import ANGLES, ARC, ARC_UNITS, POSE_UNITS, arc_table, planar_pose
from soft_gripper.estimators.plane import bending_plane, to_world
from soft_gripper.fingers.kinematics import as_points
from soft_gripper.sensors.sensor_layout import SensorLayout
from soft_gripper.signals import POSE, XYZ, XZ


class ArcPoseEstimator(ArrayBlock):
    """Estimates the pose of one finger as circular arcs, one a sensor section (equations (2)-(6), see `arcs`).

    ::

        strain (paths * S) -------> +------------------+ ---> estimated_joint_angles (N) rad
                                    |                  | ---> theta                  (S) rad, bend of each section
        driving_torque (N) N m ---> |                  | ---> kappa                  (S) 1/m, curvature of each section
                                    | ArcPoseEstimator | ---> arcs                   (S x 7) x, z, heading, kappa,
        X_WB (12) [R | p] --------> |                  |                                    length, center
                                    |                  | ---> joint_positions        (N x 2) x, z; m in B
                                    |                  | ---> joint_positions_world  (N x 3) m
                                    +------------------+ ---> tip_pose               (3) x, z, heading; m, m, rad in B

    `strain` are the readings of sensors as they are believed to be, `X_WB` the known pose of the finger's base.
    Positions lie on the arcs. Joint angles share the bend of a section as stiffness, driving torque and load have it,
    see `bend_sharing`, so that force and contact can be estimated from them. Matrices leave their ports row after row.
    Arcs are given by where and in which direction they begin, in B, for drawing with their centres (NaN for a
    straight arc, which has none). Stateless: a reading that is NaN or infinite makes the pose NaN from its section
    on, and all joint angles NaN, for as long as it lasts and no longer.
    """

    def __init__(self, layout: SensorLayout, gravity: Array):
        """Sensors and finger as they are believed to be; `gravity` in the world, (3,) m/s^2, zero for none."""
        super().__init__()
        sharing, sections, joints = BendSharing(layout), range(layout.sections), range(layout.finger.segments)
        self.take("strain", layout.readings)
        self.take(DRIVING_TORQUE, layout.finger.segments)
        self.take("X_WB", 12)
        self.derive("plane", bending_plane, "X_WB")
        self.derive("gravity", lambda plane: plane.planar(gravity)[..., None], "plane")
        self.derive("bends", partial(bends_from_readings, layout), "strain")
        self.derive("pose", lambda bends: join_arcs(*bends), "bends")
        self.derive("joints", partial(joints_on_arcs, layout), "pose")
        self.put_out(
            *(ANGLES, lambda bends, driving, gravity: sharing.joint_angles(bends.theta, driving, gravity)),
            *("bends", DRIVING_TORQUE, "gravity"),
            unit="rad",
            joint=joints,
        )
        self.put_out("theta", lambda bends: bends.theta, "bends", unit="rad", section=sections)
        self.put_out("kappa", lambda bends: bends.theta / bends.length, "bends", unit="1/m", section=sections)
        self.put_out("arcs", arc_table, "pose", unit=ARC_UNITS, section=sections, arc=ARC)
        self.put_out("joint_positions", as_points, "joints", unit="m", joint=joints, xz=XZ)
        self.put_out("tip_pose", _tip_pose, "pose", unit=POSE_UNITS, pose=POSE)
        self.put_out("joint_positions_world", to_world, "joints", "plane", unit="m", joint=joints, xyz=XYZ)


def _tip_pose(arcs: Arcs) -> Array:
    return planar_pose(arcs.end[..., -1], arcs.tip_heading)


@dataclass(frozen=True)
class ArcShape:
    """The estimator `arcs` of one finger; a ShapeFunction. Joints and tip lie on the arcs."""

    layout: SensorLayout

    def __call__(self, readings: Array, driving: Array, gravity: Planar | complex) -> ShapeEstimate:
        """Joint angles, joints and tip; see ShapeFunction."""
        arcs = arcs_from_readings(self.layout, readings)
        q = BendSharing(self.layout).joint_angles(arcs.theta, driving, np.asarray(gravity)[..., None])
        curve = np.concatenate([joints_on_arcs(self.layout, arcs), arcs.end[..., -1:]], axis=-1)
        return ShapeEstimate(q, curve=curve)
