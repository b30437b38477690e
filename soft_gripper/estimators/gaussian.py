"""The most probable shape and its uncertainty, from readings, driving torque and weight.

Before the sensors are read the joint angles are Gaussian about those of the free finger (`mechanics`),

    q ~ N(q_0, P) ,   q_0 = (u + w) / k .

The readings say  z = A q + noise  (`sensors.measurement`), with variances R, so

    q | z ~ N(q_0 + G (z - A q_0), P - G A P) ,   G = P A^T (A P A^T + R)^-1 .

The weight depends a little on q, so this is done twice. Lilge, Barfoot and Burgner-Kahrs (2022, doi
10.1177/02783649221128843) estimate a continuum robot's shape with a Gaussian process in the same spirit; here the
prior is on the load, not on the curvature, so that driving torque and stiffness are put to use.

Leading axes are free; S values that are read, N joints.
"""

from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from soft_gripper.arrays import Array, Planar
from soft_gripper.estimators.estimate import ShapeEstimate
from soft_gripper.estimators.mechanics import PlanarMechanics
from soft_gripper.estimators.uncertainty import Uncertainty
from soft_gripper.sensors.measurement import MeasurementModel

_PASSES = 2


@dataclass(frozen=True)
class GaussianShape:
    """The estimator `gaussian` of one finger; a ShapeFunction."""

    layout: MeasurementModel
    uncertainty: Uncertainty = field(default_factory=Uncertainty)

    def __call__(self, readings: Array, driving: Array, gravity: Planar | complex) -> ShapeEstimate:
        """The joint angles and their covariance; see ShapeFunction."""
        layout, mechanics, assumed = self.layout, self.mechanics, self.uncertainty
        read, A = layout.linear(readings, assumed.any_reading).uncertain_by(assumed.gain), layout.matrix
        q = read.values @ self._least_bent.T
        gain, covariance = condition(A, mechanics.prior(q, q, driving), read.variance)
        for _ in range(_PASSES):
            free = mechanics.free(driving + mechanics.weight(q, gravity))
            q = free + (gain @ (read.values - free @ A.T)[..., None])[..., 0]
        return ShapeEstimate(q, covariance)

    @cached_property
    def mechanics(self) -> PlanarMechanics:
        return PlanarMechanics(self.layout, self.uncertainty)

    @cached_property
    def _least_bent(self) -> Array:
        """From measured values to the smallest joint angles that match, (N, S): joints of a section bend equally."""
        return np.linalg.pinv(self.layout.matrix)


def condition(A: Array, covariance: Array, variance: Array) -> tuple[Array, Array]:
    """The gain G, (..., N, S), and the posterior covariance, (..., N, N), after measuring  z = A q + noise .

    Args:
        A: (..., S, N).
        covariance: P, of the joint angles before, (..., N, N).
        variance: of the noise, (..., S).
    """
    gain, seen = gain_of(A, covariance, variance)
    return gain, covariance - gain @ seen


def gain_of(A: Array, covariance: Array, variance: Array) -> tuple[Array, Array]:
    """The gain as of `condition`, and A P, (..., S, N)."""
    seen = A @ covariance
    read = seen @ np.swapaxes(A, -1, -2) + variance[..., None] * np.eye(A.shape[-2])
    return np.swapaxes(np.linalg.solve(read, seen), -1, -2), seen
