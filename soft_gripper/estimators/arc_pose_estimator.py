"""ArcPoseEstimator: strain readings -> the pose of the finger as circular arcs."""

from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

import numpy as np
from pydrake.common.value import AbstractValue
from pydrake.systems.framework import BasicVector, CacheEntry, Context, LeafSystem, ValueProducer

from soft_gripper.arrays import Array, Planar
from soft_gripper.estimators.bend_sharing import BendSharing
from soft_gripper.estimators.section_arcs import arcs_from_readings, joints_on_arcs
from soft_gripper.fingers.kinematics import as_points
from soft_gripper.sensors.sensor_layout import SensorLayout
from soft_gripper.shape.arcs import Arcs
from soft_gripper.shape.bending_plane import bending_plane, to_world
from soft_gripper.shape.driving_torque import DRIVING_TORQUE
from soft_gripper.shape.finger_shape import ANGLES, ARC, ARC_UNITS, POSE_UNITS, arc_table
from soft_gripper.signals import POSE, XYZ, XZ, describe


class Pose(NamedTuple):
    """What one sample of readings says about a finger."""

    arcs: Arcs
    joints: Planar  # (N) m in B


class ArcPoseEstimator(LeafSystem):
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
        self._layout, self._sharing, self._gravity = layout, BendSharing(layout), gravity
        self._strain = self.DeclareVectorInputPort("strain", layout.readings)
        self._driving = self.DeclareVectorInputPort(DRIVING_TORQUE, layout.finger.segments)
        self._X_WB = self.DeclareVectorInputPort("X_WB", 12)
        self._pose = self._cache("pose", self._estimate, {self._strain.ticket()})
        self._plane = self._cache("bending plane", self._calc_plane, {self._X_WB.ticket()})
        sections, joints = range(layout.sections), range(layout.finger.segments)
        pose = {self.cache_entry_ticket(self._pose.cache_index())}
        plane = {self.cache_entry_ticket(self._plane.cache_index())}
        self._in_plane = self._cache("gravity in the bending plane", self._calc_gravity, plane)
        in_plane = {self.cache_entry_ticket(self._in_plane.cache_index())}
        angles = self.DeclareVectorOutputPort(
            ANGLES, len(joints), self._calc_angles, pose | in_plane | {self._driving.ticket()}
        )
        describe(angles, "rad", joint=joints)
        self._declare("theta", lambda pose: pose.arcs.theta, "rad", section=sections)
        self._declare("kappa", lambda pose: pose.arcs.kappa, "1/m", section=sections)
        self._declare("arcs", lambda pose: arc_table(pose.arcs), ARC_UNITS, section=sections, arc=ARC)
        self._declare("joint_positions", lambda pose: as_points(pose.joints), "m", joint=joints, xz=XZ)
        self._declare("tip_pose", lambda pose: _tip_pose(pose.arcs), POSE_UNITS, pose=POSE)
        world = self.DeclareVectorOutputPort("joint_positions_world", 3 * len(joints), self._calc_world, pose | plane)
        describe(world, "m", joint=joints, xyz=XYZ)

    def _cache(self, name: str, calc: Callable[[Context, AbstractValue], None], tickets: set[Any]) -> CacheEntry:
        producer = ValueProducer(allocate=lambda: AbstractValue.Make(object()), calc=calc)
        return self.DeclareCacheEntry(name, producer, tickets)

    def _declare(
        self, name: str, part: Callable[[Pose], Array], unit: str | Sequence[str], **axes: Sequence[Any]
    ) -> None:
        def calc(context: Context, output: BasicVector) -> None:
            output.SetFromVector(part(self._pose.Eval(context)).ravel())

        size, pose = int(np.prod([len(labels) for labels in axes.values()])), self._pose.cache_index()
        port = self.DeclareVectorOutputPort(name, size, calc, {self.cache_entry_ticket(pose)})
        describe(port, unit, **axes)

    def _calc_plane(self, context: Context, value: AbstractValue) -> None:
        value.set_value(bending_plane(self._X_WB.Eval(context)))

    def _calc_gravity(self, context: Context, value: AbstractValue) -> None:
        value.set_value(self._plane.Eval(context).planar(self._gravity))

    def _estimate(self, context: Context, value: AbstractValue) -> None:
        arcs = arcs_from_readings(self._layout, self._strain.Eval(context))
        value.set_value(Pose(arcs, joints_on_arcs(self._layout, arcs)))

    def _calc_angles(self, context: Context, output: BasicVector) -> None:
        theta, gravity = self._pose.Eval(context).arcs.theta, self._in_plane.Eval(context)
        output.SetFromVector(self._sharing.joint_angles(theta, self._driving.Eval(context), gravity))

    def _calc_world(self, context: Context, output: BasicVector) -> None:
        output.SetFromVector(to_world(self._pose.Eval(context).joints, self._plane.Eval(context)).ravel())


def _tip_pose(arcs: Arcs) -> Array:
    tip = arcs.end[-1]
    return np.array((tip.imag, tip.real, arcs.tip_heading))
