"""The most probable shape and its uncertainty, from readings, driving torque and weight: the estimator `gaussian`.

Before the sensors are read the joints are Gaussian about those of the free finger (`mechanics`),

    q ~ N(q_0, P) ,   q_0 = (u + w) / k .

The readings give values  z = g(q) + noise  (`sensors.measurement`), with variances R. With A their slopes by the
joints, linearized about a shape q_1 close to the true one,

    q | z ~ N(q_0 + G (z - g(q_1) - A (q_0 - q_1)), P - G A P) ,   G = P A^T (A P A^T + R)^-1 .

Weight and prior depend on the posture. The prior is that of a finger that is bent as a first guess says, for which
everything is linearized about the straight one; weight and readings are those there, and then those where this leaves
the joints: iterated extended Kalman update (Bell and Cathey 1993, doi 10.1109/9.250476). Lilge, Barfoot and
Burgner-Kahrs (2022, doi 10.1177/02783649221128843) estimate a continuum robot's shape with a Gaussian process in the
same spirit; here the prior is on the load, not on the curvature, so that driving torque and stiffness are put to use.

A finger under 60 kPa and a force of 0.2 N across its tip, whose stiffness is known to some 10 %:

    >>> import numpy as np
    >>> import soft_gripper as sg
    >>> finger = sg.make_station(sg.load_scenario("free_bending")).fingers[0].finger
    >>> layout = sg.sensors.SensorLayout(finger, sections=4)
    >>> driving, force = finger.pressure_torque(60e3), -0.2 * (finger.length - finger.joint_arc_lengths)
    >>> q = finger.angle(driving + force)
    >>> shape = sg.estimators.GaussianShape(layout)(layout.read(q), driving, np.zeros(3))
    >>> print(f"off by {np.degrees(np.abs(shape.q - q).max()):.3f} degrees at most")
    off by 0.009 degrees at most
    >>> print(f"{np.degrees(np.sqrt(np.diag(shape.covariance)).max()):.1f} degrees of deviation at most")
    0.2 degrees of deviation at most

Leading axes are free; S values, D joints, one deformation after the other (`MeasurementModel.deformations`).

Symbols: q joint positions, rad; q_0 those without a load; P their covariance before the sensors are read; u driving
torque, w torque of the weight, N m; k stiffness, N m/rad; z values that are read, g their model, A its slopes by the
joints, R the variances of their noise; G the gain.
"""

from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from soft_gripper.arrays import Array
from soft_gripper.estimators.batches import memoized
from soft_gripper.estimators.estimate import ShapeEstimate
from soft_gripper.estimators.mechanics import ExtrapolationStd, Mechanics
from soft_gripper.estimators.uncertainty import Uncertainty
from soft_gripper.estimators.zeroing import Zeroing
from soft_gripper.sensors.measurement import UNKNOWN, LinearReadings, MeasurementModel
from soft_gripper.sensors.observability import shared_equally, weak_prior

_ITERATIONS = 2


@dataclass(frozen=True)
class GaussianShape:
    """The estimator `gaussian` of one finger; a ShapeFunction."""

    layout: MeasurementModel
    uncertainty: Uncertainty = field(default_factory=Uncertainty)
    period: float = 0.01  # s, between samples of sensors whose zeros are followed

    def __call__(self, readings: Array, driving: Array, gravity: Array, std: Array | None = None) -> ShapeEstimate:
        """Estimates the joint positions and their covariance; see ShapeFunction.

        `std` is the standard deviation of the readings, (..., 1); None: that of sensors zeroed within a minute.
        """
        mechanics, extrapolation = self.mechanics, self.extrapolation(readings, driving, gravity)
        linear = self.read(readings, std, extrapolation)
        q = self.guess(linear, driving, gravity)
        bent = mechanics.bent_finger(q)
        prior = mechanics.prior(bent, q, driving, extrapolation)
        for i in range(_ITERATIONS):
            bent = mechanics.bent_finger(q) if i else bent
            q_free = mechanics.positions_under(driving + mechanics.weight(bent, gravity))
            prediction, A = self.layout.values_at(q)
            gain, cross_covariance = kalman_gain(A, prior, linear.variance)
            residual = linear.values - prediction - (A @ (q_free - q)[..., None])[..., 0]
            q = q_free + (gain @ residual[..., None])[..., 0]
        return ShapeEstimate(q, prior - gain @ cross_covariance + mechanics.scale_covariance(q))

    def guess(self, linear: LinearReadings, driving: Array, gravity: Array) -> Array:
        """Joint positions if readings, prior and weight were those of the straight finger, (..., D)."""
        weight, gain, A = self._straight_update
        q_free = self.mechanics.positions_under(driving + gravity @ weight)
        residual = np.where(linear.variance < UNKNOWN / 2, linear.values - q_free @ A.T, 0.0)
        return q_free + residual @ gain.T

    @cached_property
    def _straight_update(self) -> tuple[Array, Array, Array]:
        """Torques of unit gravity on the straight finger, (3, D), gain, (D, S), and slopes of the values, (S, D).

        Sections may bend and twist by as much as `weak_prior` says, in addition to the effect of a load.
        """
        mechanics, layout, q = self.mechanics, self.layout, self.layout.straight
        section_deviations = shared_equally(layout) * weak_prior(layout)
        bent = mechanics.bent_finger(q)
        prior = mechanics.prior(bent, q, np.zeros_like(q)) + section_deviations @ section_deviations.T
        (_, A), noise = layout.values_at(q), self.read(layout.read(q)).variance
        return mechanics.weight(bent, np.eye(3)), kalman_gain(A, prior, noise)[0], A

    def read(self, readings: Array, std: Array | None = None, errors: ExtrapolationStd | None = None) -> LinearReadings:
        """Values of readings, 0 where one is missing, and their variances; `std` as for the estimate."""
        noise = self.uncertainty.any_reading() if std is None else std
        linear = self.layout.values(readings, noise).uncertain_by(self.uncertainty.gain)
        return linear if errors is None else LinearReadings(linear.values, linear.variance + errors.values**2)

    def extrapolation(self, readings: Array, driving: Array, gravity: Array) -> ExtrapolationStd | None:
        """Extrapolation error, see `Mechanics.extrapolation`."""
        return memoized(Mechanics.extrapolation, self.mechanics, readings, driving, gravity)

    @cached_property
    def zeroing(self) -> Zeroing | None:
        """The filter of the zeros of the sensors; see `Zeroing.from_mechanics`."""
        return Zeroing.from_mechanics(self.mechanics, self.period)

    @cached_property
    def mechanics(self) -> Mechanics:
        return Mechanics(self.layout, self.uncertainty)


def condition(A: Array, covariance: Array, variance: Array) -> tuple[Array, Array]:
    """Gain G, (..., D, S), and posterior covariance, (..., D, D), after measuring  z = A q + noise .

    Args:
        A: (..., S, D).
        covariance: P, of the joints before, (..., D, D).
        variance: of the noise, (..., S).
    """
    gain, cross_covariance = kalman_gain(A, covariance, variance)
    return gain, covariance - gain @ cross_covariance


def kalman_gain(A: Array, covariance: Array, variance: Array) -> tuple[Array, Array]:
    """Gain G, (..., D, S), and A P, (..., S, D)."""
    cross_covariance = A @ covariance
    innovation_covariance = cross_covariance @ np.swapaxes(A, -1, -2) + variance[..., None] * np.eye(A.shape[-2])
    return np.swapaxes(np.linalg.solve(innovation_covariance, cross_covariance), -1, -2), cross_covariance
