"""The estimators that take every sensor section for a circular arc: `arcs`, and `constant_curvature` as published.

Both give the same curve, equations (2) to (6) of the paper (see `arcs`), and differ in the joint angles, from which
the external torque follows. `constant_curvature` shares the bend of a section equally among its joints and takes the
torque of every joint from equation (7) alone, at rest:

    external torque = k (q - q_free) ,   q_free: free bending, under driving torque and weight.

It assumes nothing else, and so reads taper, and a weight that bends the joints of a section differently, as external
torque. `arcs` shares the bend as stiffness, driving torque and load require; its external torque is
that of the dynamic balance.

Leading axes are free; S sections, N joints. A reading that is NaN or infinite makes the curve NaN from its section on.

Two-sided readings give the sum of the joint angles of a section and no more. An arc shares it equally among the joints;
a finger does not. At every joint the elastic torque balances driving torque, weight and external load,

    k q = u + w + tau ,

with the stiffness k and the driving torque u, that of the pressure and what else is known of it.

The load is smooth and zero beyond the tip: let it be linear between the middles of the sections, tau = T tau_S, with
one unknown a section. The readings, A q = theta, determine these:

    A (u + w + T tau_S) / k = theta .

So the sum of each section's angles is the measured one, and free bending is exact for every number of sections.

Leading axes are free; S sections, N joints.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from soft_gripper.arrays import Array, Planar
from soft_gripper.estimators.arcs import ArcCurve, bends_from_readings
from soft_gripper.estimators.estimate import ShapeEstimate
from soft_gripper.fingers.kinematics import as_planar, gravity_torque
from soft_gripper.sensors.sensor_layout import SensorLayout

_MAX_ITERATIONS = 8  # of Newton's method, for an elastic law; it ends when the correct pieces of the law are found
_STEP_FRACTIONS = 0.5 ** np.arange(4)  # step fractions, of which the best is used: full steps alone may cycle


@dataclass(frozen=True)
class BendSharing:
    """The shares of the joints of one finger in the bends of its sections, from its nominal model."""

    layout: SensorLayout

    def joint_angles(self, theta: Array, driving: Array, gravity: Planar | complex) -> Array:
        """Joint angles, (..., N) rad, of a finger under load.

        Args:
            theta: measured bend of the sections, rad, (..., S).
            driving: torque at the joints, N m, (..., N).
            gravity: in the bending plane, z + i x in B, m/s^2, a number or (..., 1).
        """
        finger = self.layout.finger
        if finger.elastic_law is not None:
            q = self._solve_elastic_law(theta, driving)
            return self._solve_elastic_law(theta, driving + gravity_torque(finger, q, gravity))
        q = theta @ self._bend_gain.T + driving @ self._torque_gain.T
        return q + gravity_torque(finger, q, gravity) @ self._torque_gain.T

    def _solve_elastic_law(self, theta: Array, torque_without_load: Array) -> Array:
        """Newton's method for the loads of the sections, from none."""
        finger = self.layout.finger
        torque = np.zeros_like(theta)
        q = self.layout.finger.angle(torque_without_load)
        for _ in range(_MAX_ITERATIONS):
            compliance = 1 / finger.joint_law.slope(q)
            bends = self.layout.matrix @ (compliance[..., None] * self.interpolation)
            step = np.linalg.solve(bends, (theta - self.layout.sums(q))[..., None])[..., 0]
            torques = torque + np.multiply.outer(_STEP_FRACTIONS, step)
            shapes = finger.angle(torques @ self.interpolation.T + torque_without_load)
            best = np.linalg.norm(theta - self.layout.sums(shapes), axis=-1).argmin(axis=0)[None, ..., None]
            torque, q = (np.take_along_axis(values, best, axis=0)[0] for values in (torques, shapes))
        return q + self.layout.shared_equally(theta - self.layout.sums(q))

    @cached_property
    def _bend_gain(self) -> Array:
        """Joint angles per bend of the sections if only the load bends them, (N, S)."""
        compliant = self.interpolation / self.layout.finger.stiffness[:, None]
        return compliant @ np.linalg.inv(self.layout.matrix @ compliant)

    @cached_property
    def _torque_gain(self) -> Array:
        """Joint angles per known torque, rad/(N m), with zero bend of every section, (N, N)."""
        compliance = np.diag(1 / self.layout.finger.stiffness)
        return compliance - self._bend_gain @ self.layout.matrix @ compliance

    @cached_property
    def interpolation(self) -> Array:
        """The matrix T from torques in the middles of the sections to torques at the joints, (N, S).

        The torque is linear between the middles of the sections and beyond the first, and zero at the tip.
        """
        layout = self.layout
        s = layout.finger.joint_arc_lengths
        middles = np.add.reduceat(s, layout.section_ends[:-1]) / layout.joints_per_section
        nodes = np.append(middles, layout.finger.length)
        piece = np.clip(np.searchsorted(nodes, s) - 1, 0, layout.sections - 1)
        fractions = (s - nodes[piece]) / (nodes[piece + 1] - nodes[piece])
        joints = np.arange(len(s))
        weights = np.zeros((len(s), len(nodes)))
        weights[joints, piece], weights[joints, piece + 1] = 1 - fractions, fractions
        return weights[:, :-1]


@dataclass(frozen=True)
class ArcShape:
    """The estimator `arcs` of one finger; a ShapeFunction. Joints and tip lie on the arcs."""

    layout: SensorLayout

    def __call__(self, readings: Array, driving: Array, gravity: Array) -> ShapeEstimate:
        """Joint angles, all NaN where a reading is not finite, and the curve; see ShapeFunction."""
        return self.shape(self.curve(readings), driving, gravity)

    def curve(self, readings: Array) -> ArcCurve:
        """The arcs, which follow from the readings alone."""
        return ArcCurve(self.layout, *bends_from_readings(self.layout, readings))

    def shape(self, curve: ArcCurve, driving: Array, gravity: Array) -> ShapeEstimate:
        """Joint angles that share the bends of a curve, and the curve; other arguments as in ShapeFunction."""
        q = self._sharing.joint_angles(curve.theta, driving, as_planar(gravity[..., ::2])[..., None])
        return ShapeEstimate(q, curve=curve)

    @cached_property
    def _sharing(self) -> BendSharing:
        return BendSharing(self.layout)


@dataclass(frozen=True)
class ConstantCurvatureShape:
    """The estimator `constant_curvature` of one finger, as published; a ShapeFunction."""

    layout: SensorLayout

    def __call__(self, readings: Array, driving: Array, gravity: Array) -> ShapeEstimate:
        """Joint angles, the curve and the static external torque; see ShapeFunction."""
        layout, (theta, length) = self.layout, bends_from_readings(self.layout, readings)
        q, curve = layout.shared_equally(theta), ArcCurve(layout, theta, length)
        torque = driving + gravity_torque(layout.finger, q, as_planar(gravity[..., ::2])[..., None])
        return ShapeEstimate(q, curve=curve, external_torque=layout.finger.elastic_torque(q) - torque)
