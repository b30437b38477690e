"""ArcPoseEstimator: strain readings -> the pose of the finger."""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from pydrake.common.value import AbstractValue
from pydrake.math import RigidTransform
from pydrake.systems.framework import BasicVector, CacheEntry, Context, InputPort, LeafSystem, ValueProducer

from soft_gripper.arcs import Arcs
from soft_gripper.arrays import Array, Planar
from soft_gripper.kinematics import as_points
from soft_gripper.sensor_layout import SensorLayout, arcs_from_readings, joints_on_arcs


class Pose(NamedTuple):
    """What one sample of readings says about a finger."""

    arcs: Arcs
    joints: Planar  # (N) m in B


class BendingPlane(NamedTuple):
    """The bending plane of a finger in the world."""

    axes: Array  # (2, 3) unit vectors, x and z of B
    origin: Array  # (3,) m


def bending_plane(X_WB: RigidTransform) -> BendingPlane:
    """The bending plane of a finger whose base stands at `X_WB`."""
    return BendingPlane(X_WB.rotation().matrix().T[::2].copy(), X_WB.translation())


def to_world(planar: Planar, plane: BendingPlane) -> Array:
    """Points of the bending plane, (...) m in B -> (..., 3) m in the world."""
    return as_points(planar) @ plane.axes + plane.origin


class ArcPoseEstimator(LeafSystem):
    """Estimates the pose of one finger as circular arcs, one a sensor section (equations (2)-(6)).

                +------------------+ ---> theta                  (S) rad, bend of each section
                |                  | ---> kappa                  (S) 1/m, curvature of each section
    strain ---> |                  | ---> arcs                   (S x 7) x, z, heading, kappa, length, center
                | ArcPoseEstimator | ---> joint_positions        (N x 2) x, z; m in B
    X_WB   ---> |                  | ---> joint_positions_world  (N x 3) m
                +------------------+ ---> tip_pose               (3) x, z, heading; m, m, rad in B

    `strain` (paths * S) are the readings of a StrainSensor of the same layout; `X_WB` is the known pose of
    the finger's base, a RigidTransform. Matrices leave their ports row after row. Arcs are given by where and
    in which direction they begin, in B, for drawing with their centres (NaN for a straight arc, which has
    none). Stateless: a reading that is NaN or infinite makes the pose NaN from its section on, for as long as
    it lasts and no longer.
    """

    def __init__(self, layout: SensorLayout):
        super().__init__()
        self._layout = layout
        self._strain = self.DeclareVectorInputPort("strain", layout.readings)
        self._X_WB = self.DeclareAbstractInputPort("X_WB", AbstractValue.Make(RigidTransform()))
        self._pose = self._cache("pose", self._estimate, self._strain)
        self._plane = self._cache("bending plane", self._calc_plane, self._X_WB)
        sections, joints = layout.sections, layout.finger.segments
        self._declare("theta", sections, lambda pose: pose.arcs.theta)
        self._declare("kappa", sections, lambda pose: pose.arcs.kappa)
        self._declare("arcs", sections * 7, lambda pose: _arc_table(pose.arcs))
        self._declare("joint_positions", joints * 2, lambda pose: as_points(pose.joints))
        self._declare("tip_pose", 3, lambda pose: _tip_pose(pose.arcs))
        self.DeclareVectorOutputPort(
            "joint_positions_world",
            joints * 3,
            self._calc_world,
            {self.cache_entry_ticket(entry.cache_index()) for entry in (self._pose, self._plane)},
        )

    def _cache(self, name: str, calc: Callable[[Context, AbstractValue], None], port: InputPort) -> CacheEntry:
        producer = ValueProducer(allocate=lambda: AbstractValue.Make(object()), calc=calc)
        return self.DeclareCacheEntry(name, producer, {port.ticket()})

    def _declare(self, name: str, size: int, part: Callable[[Pose], Array]) -> None:
        def calc(context: Context, output: BasicVector) -> None:
            output.SetFromVector(part(self._pose.Eval(context)).ravel())

        self.DeclareVectorOutputPort(name, size, calc, {self.cache_entry_ticket(self._pose.cache_index())})

    def _calc_plane(self, context: Context, value: AbstractValue) -> None:
        value.set_value(bending_plane(self._X_WB.Eval(context)))

    def _estimate(self, context: Context, value: AbstractValue) -> None:
        arcs = arcs_from_readings(self._layout, self._strain.Eval(context))
        value.set_value(Pose(arcs, joints_on_arcs(self._layout, arcs)))

    def _calc_world(self, context: Context, output: BasicVector) -> None:
        joints = self._pose.Eval(context).joints
        output.SetFromVector(to_world(joints, self._plane.Eval(context)).ravel())


def _arc_table(arcs: Arcs) -> Array:
    start, center = arcs.start, arcs.centers
    columns = (start.imag, start.real, arcs.heading, arcs.kappa, arcs.length, center.imag, center.real)
    return np.array(columns).T


def _tip_pose(arcs: Arcs) -> Array:
    tip = arcs.end[-1]
    return np.array((tip.imag, tip.real, arcs.tip_heading))
