"""The most probable shape and its uncertainty, from readings, driving torque and weight.

At every joint the elastic torque balances driving torque, weight and load,  k q = u + w + tau . Before the sensors are
read the joint angles are Gaussian about those of the free finger,

    q ~ N(q_0, P) ,   q_0 = (u + w) / k ,   P = C (T + r^2 u u^T + d^2 g g^T) C + a^2 I ,   C = diag(1 / k) ,

with T the covariance of the load (`load_prior`), r the uncertainty of the bend that the driving torque leads to, as a
share, d that of the pressure, whose gain is g, and a that of everything else. The readings say  z = A q + noise
(`sensors.measurement`), with variances R, so

    q | z ~ N(q_0 + G (z - A q_0), P - G A P) ,   G = P A^T (A P A^T + R)^-1 .

The weight depends a little on q, so this is done twice. Lilge, Barfoot and Burgner-Kahrs (2022, doi
10.1177/02783649221128843) estimate a continuum robot's shape with a Gaussian process in the same spirit; here the
prior is on the load, not on the curvature, so that driving torque and stiffness are put to use.

What is known of a load before anything is read: it is smooth, and zero beyond the tip.

Contact forces f(x) across the finger have at the arc length s the torque

    tau(s) = integral from s to L of (x - s) f(x) dx .

Let them be white noise along the finger, and one more, independent, press on the tip. Then tau is Gaussian. The
forces along the finger give it the covariance of twice integrated white noise, with u the distance from the tip over
the length,

    m^2 (3 M - m) / 2 ,   m = min(u, v) ,  M = max(u, v) ,

and the force on the tip gives it u v; each is 1 at the base. What is most probable between readings under the first
alone is a cubic spline (Wahba 1978, doi 10.1111/j.2517-6161.1978.tb01050.x).

Leading axes are free; S values that are read, N joints.
"""

from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from soft_gripper.arrays import Array, Planar
from soft_gripper.estimators.estimate import ShapeEstimate
from soft_gripper.estimators.uncertainty import Uncertainty
from soft_gripper.fingers.finger import Finger
from soft_gripper.fingers.kinematics import gravity_torque
from soft_gripper.sensors.measurement import MeasurementModel

TIP_SHARE = 0.3  # fraction of the variance at the base that is due to a force on the tip


def torque_covariance(finger: Finger, load_pressure: float) -> Array:
    """Covariance of the external torque at the joints, (N m)^2, (N, N).

    At the base the standard deviation is the largest torque of `load_pressure`, Pa, at a joint.
    """
    u = 1 - finger.joint_arc_lengths / finger.length
    less, more = np.minimum.outer(u, u), np.maximum.outer(u, u)
    along = less**2 * (3 * more - less) / 2
    covariance = TIP_SHARE * np.outer(u, u) + (1 - TIP_SHARE) * along
    return (load_pressure * finger.pressure_gain.max()) ** 2 * covariance


_PASSES = 2


@dataclass(frozen=True)
class GaussianShape:
    """The estimator `gaussian` of one finger; a ShapeFunction."""

    layout: MeasurementModel
    uncertainty: Uncertainty = field(default_factory=Uncertainty)

    def __call__(self, readings: Array, driving: Array, gravity: Planar | complex) -> ShapeEstimate:
        """The joint angles and their covariance; see ShapeFunction."""
        layout, finger, assumed = self.layout, self.layout.finger, self.uncertainty
        read, A = layout.linear(readings, assumed.any_reading).uncertain_by(assumed.gain), layout.matrix
        gravity = np.asarray(gravity)[..., None]
        q = read.values @ self._least_bent.T
        gain, covariance = condition(A, self.prior(q, driving), read.variance)
        for _ in range(_PASSES):
            free = finger.angle(driving + gravity_torque(finger, q, gravity))
            q = free + (gain @ (read.values - free @ A.T)[..., None])[..., 0]
        return ShapeEstimate(q, covariance)

    def prior(self, q: Array, driving: Array) -> Array:
        """The covariance P of the joint angles before the sensors are read, rad^2, (..., N, N)."""
        return self._of_load(q) + self.of_model(q, driving)

    def of_model(self, q: Array, driving: Array) -> Array:
        """The part of P that is due to deviations of finger and pressure from the nominal model, (..., N, N)."""
        assumed = self.uncertainty
        compliance = self.compliance(q)
        of_driving = compliance * (assumed.bend_per_pressure * driving)
        of_pressure = compliance * (assumed.pressure * self.layout.finger.pressure_gain)
        return _outer(of_driving) + _outer(of_pressure) + assumed.angle**2 * np.eye(q.shape[-1])

    def _of_load(self, q: Array) -> Array:
        if self.layout.finger.elastic_law is None:
            return self._of_load_if_linear
        compliance = self.compliance(q)
        return compliance[..., None] * self._torque_covariance * compliance[..., None, :]

    def compliance(self, q: Array) -> Array:
        """Compliance of the joints, rad/(N m), (N,) or, under an elastic law, (..., N)."""
        finger = self.layout.finger
        return 1 / (finger.stiffness if finger.elastic_law is None else finger.joint_law.slope(q))

    @cached_property
    def _least_bent(self) -> Array:
        """From measured values to the smallest joint angles that match, (N, S): joints of a section bend equally."""
        return np.linalg.pinv(self.layout.matrix)

    @cached_property
    def _of_load_if_linear(self) -> Array:
        compliance = 1 / self.layout.finger.stiffness
        return compliance[:, None] * self._torque_covariance * compliance

    @cached_property
    def _torque_covariance(self) -> Array:
        return torque_covariance(self.layout.finger, self.uncertainty.load_pressure)


def _outer(vector: Array) -> Array:
    """Outer product, (..., N) -> (..., N, N)."""
    return vector[..., None] * vector[..., None, :]


def condition(A: Array, covariance: Array, variance: Array) -> tuple[Array, Array]:
    """The gain G, (..., N, S), and the posterior covariance, (..., N, N), after measuring  z = A q + noise .

    Args:
        A: (..., S, N).
        covariance: P, of the joint angles before, (..., N, N).
        variance: of the noise, (..., S).
    """
    seen = A @ covariance
    read = seen @ np.swapaxes(A, -1, -2) + variance[..., None] * np.eye(A.shape[-2])
    gain = np.swapaxes(np.linalg.solve(read, seen), -1, -2)
    return gain, covariance - gain @ seen
