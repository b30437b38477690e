"""Piecewise constant curvature in space: the estimator `constant_curvature` of a finger that leaves its plane.

Every section bends in both planes, twists and stretches equally along itself: one rotation vector, shared by its
joints. Nothing else is assumed than that it is weakly known before anything is read (`sensors.observability`), which
matters only for what the readings leave open: they say little of twist, unless a path is slanted.

Leading axes are free; S sections, D joints.
"""

from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from soft_gripper.arrays import Array
from soft_gripper.estimators.estimate import ShapeEstimate
from soft_gripper.estimators.gaussian import condition
from soft_gripper.estimators.mechanics import Mechanics
from soft_gripper.estimators.uncertainty import Uncertainty
from soft_gripper.estimators.zeroing import Zeroing
from soft_gripper.sensors.measurement import UNKNOWN, MeasurementModel
from soft_gripper.sensors.observability import shared_equally, weak_prior

_ITERATIONS = 3  # of Newton's method


@dataclass(frozen=True)
class SpatialCurvatureShape:
    """The estimator `constant_curvature` of one finger whose sensors see it leave its plane."""

    layout: MeasurementModel
    uncertainty: Uncertainty = field(default_factory=Uncertainty)
    period: float = 0.01  # s, between samples of sensors whose zeros are followed

    def __call__(self, readings: Array, driving: Array, gravity: Array, std: Array | None = None) -> ShapeEstimate:
        """Joint positions, and their covariance under the weak prior; driving torque and gravity are ignored.

        For `std` see GaussianShape.
        """
        layout, shared_bends = self.layout, self._shared
        quantities = layout.measured(readings)
        is_finite = np.isfinite(quantities)
        sections = np.zeros((*readings.shape[:-1], shared_bends.shape[-1]))
        noise = self.uncertainty.any_reading() if std is None else std
        variance = np.where(is_finite, noise**2, UNKNOWN)
        for _ in range(_ITERATIONS):
            q = sections @ shared_bends.T
            slopes = layout.slopes(q) @ shared_bends
            gain, covariance = condition(slopes, self._prior, variance)
            residual = np.where(is_finite, quantities - layout.predict(q), 0.0) + (slopes @ sections[..., None])[..., 0]
            sections = (gain @ residual[..., None])[..., 0]
        return ShapeEstimate(sections @ shared_bends.T, shared_bends @ covariance @ shared_bends.T)

    @cached_property
    def zeroing(self) -> Zeroing | None:
        """The block that follows the zeros of the sensors; see `Zeroing.from_mechanics`."""
        return Zeroing.from_mechanics(Mechanics(self.layout, self.uncertainty), self.period)

    @cached_property
    def _shared(self) -> Array:
        return shared_equally(self.layout)

    @cached_property
    def _prior(self) -> Array:
        return np.diag(weak_prior(self.layout) ** 2)
