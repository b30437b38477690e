"""The estimators that take every sensor section for a circular arc: `arcs`, and `constant_curvature` as published.

Both give the same curve, equations (2) to (6) of the paper (see `arcs`), and differ in the joint angles, from which
the external torque follows. `constant_curvature` shares the bend of a section equally among its joints and takes the
torque of every joint from equation (7) alone, at rest:

    external torque = k (q - q_free) ,   q_free: free bending, under driving torque and weight.

It assumes nothing else, and so reads taper, and a weight that bends the joints of a section differently, as external
torque. `arcs` shares the bend as stiffness, driving torque and load require, see `bend_sharing`; its external torque is
that of the dynamic balance.

Leading axes are free; S sections, N joints. A reading that is NaN or infinite makes the curve NaN from its section on.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from soft_gripper.arrays import Array, Planar
from soft_gripper.estimators.arcs import ArcCurve, bends_from_readings
from soft_gripper.estimators.bend_sharing import BendSharing
from soft_gripper.estimators.estimate import ShapeEstimate
from soft_gripper.fingers.kinematics import gravity_torque
from soft_gripper.sensors.sensor_layout import SensorLayout


@dataclass(frozen=True)
class ArcShape:
    """The estimator `arcs` of one finger; a ShapeFunction. Joints and tip lie on the arcs."""

    layout: SensorLayout

    def __call__(self, readings: Array, driving: Array, gravity: Planar | complex) -> ShapeEstimate:
        """Joint angles, all NaN where a reading is not finite, and the curve; see ShapeFunction."""
        theta, length = bends_from_readings(self.layout, readings)
        q = self._sharing.joint_angles(theta, driving, np.asarray(gravity)[..., None])
        return ShapeEstimate(q, curve=ArcCurve(self.layout, theta, length))

    @cached_property
    def _sharing(self) -> BendSharing:
        return BendSharing(self.layout)


@dataclass(frozen=True)
class ConstantCurvatureShape:
    """The estimator `constant_curvature` of one finger, that of the paper; a ShapeFunction."""

    layout: SensorLayout

    def __call__(self, readings: Array, driving: Array, gravity: Planar | complex) -> ShapeEstimate:
        """Joint angles, the curve and the static external torque; see ShapeFunction."""
        layout, (theta, length) = self.layout, bends_from_readings(self.layout, readings)
        q, curve = layout.shared_equally(theta), ArcCurve(layout, theta, length)
        known = driving + gravity_torque(layout.finger, q, np.asarray(gravity)[..., None])
        return ShapeEstimate(q, curve=curve, external_torque=layout.finger.elastic_torque(q) - known)
