"""The most probable shape in space and its uncertainty: the estimator `gaussian` of a finger that leaves its plane.

As in the plane (`gaussian`), the joints are Gaussian about those of the free finger; `mechanics` has the covariance.
Prior and weight are those of a finger that is bent as a first guess says, for which everything is linearized about the
straight one. The readings  y = h(q) + noise  are linearized there, and once more where this leaves the joints: iterated
extended Kalman update (Bell and Cathey 1993, doi 10.1109/9.250476).

Leading axes are free; D joints, way after way (`MeasurementModel.ways`); R readings.
"""

from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from soft_gripper.arrays import Array
from soft_gripper.estimators.estimate import SpatialShape
from soft_gripper.estimators.gaussian import gain_of
from soft_gripper.estimators.mechanics import SpatialMechanics
from soft_gripper.estimators.uncertainty import Uncertainty
from soft_gripper.sensors.measurement import UNKNOWN, MeasurementModel
from soft_gripper.sensors.observability import shared_equally, weak_prior

_PASSES = 2


@dataclass(frozen=True)
class SpatialGaussianShape:
    """The estimator `gaussian` of one finger whose sensors see it leave its plane."""

    layout: MeasurementModel
    uncertainty: Uncertainty = field(default_factory=Uncertainty)

    def __call__(self, readings: Array, driving: Array, gravity: Array) -> SpatialShape:
        """The joint positions and their covariance.

        Args:
            readings: of the sensors, (..., R); NaN where there is none.
            driving: torque at the joints that is known before anything is read, (..., D) N m, and N where they slide.
            gravity: in B, (..., 3) m/s^2.
        """
        mechanics, (measured, variance) = self.mechanics, self.measured(readings)
        q = self.guess(measured, variance, driving, gravity)
        at = mechanics.posture(q)
        free, prior = mechanics.free(driving + mechanics.weight(at, gravity)), mechanics.prior(at, q, driving)
        for _ in range(_PASSES):
            predicted, H = self.layout.linearized(q)
            gain, seen = gain_of(H, prior, variance)
            left = measured - predicted - (H @ (free - q)[..., None])[..., 0]
            q = free + (gain @ left[..., None])[..., 0]
        return SpatialShape(q, prior - gain @ seen)

    def guess(self, measured: Array, variance: Array, driving: Array, gravity: Array) -> Array:
        """Joint positions if readings, prior and weight were those of the straight finger, (..., D)."""
        weight, gain, straight = self._straight
        free = self.mechanics.free(driving + gravity @ weight)
        left = np.where(variance < UNKNOWN, measured - free @ straight.T, 0.0)
        return free + left @ gain.T

    @cached_property
    def _straight(self) -> tuple[Array, Array, Array]:
        """Torques of unit gravity on the straight finger, (3, D), gain, (D, R), and slopes of the readings, (R, D).

        Sections may bend and twist by as much as `weak_prior` says, in addition to what a load does to a straight one.
        """
        mechanics, layout, q = self.mechanics, self.layout, self.layout.straight
        at, shared = mechanics.posture(q), shared_equally(layout) * weak_prior(layout)
        prior = mechanics.prior(at, q, np.zeros_like(q)) + shared @ shared.T
        noise = np.full(layout.readings, self.uncertainty.any_reading**2)
        return mechanics.weight(at, np.eye(3)), gain_of(layout.jacobian, prior, noise)[0], layout.jacobian

    def measured(self, readings: Array) -> tuple[Array, Array]:
        """The measured quantity, 0 where nothing is read, and its variance, (..., R) each."""
        measured, assumed = self.layout.measured(readings), self.uncertainty
        read = np.isfinite(measured)
        measured = np.where(read, measured, 0.0)
        return measured, np.where(read, assumed.any_reading**2 + (assumed.gain * measured) ** 2, UNKNOWN)

    @cached_property
    def mechanics(self) -> SpatialMechanics:
        return SpatialMechanics(self.layout, self.uncertainty)
