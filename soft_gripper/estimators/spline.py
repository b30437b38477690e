"""The smoothest shape that has the measured bends: no stiffness, drive or weight is assumed.

Of all joint angles with the sums that are read, those with the least sum of squared differences from joint to joint:
the curvature is continuous, and its slope is as small as can be. It is the limit of the most probable curvature that
is a random walk along the finger from an unknown beginning (Wahba 1978, doi 10.1111/j.2517-6161.1978.tb01050.x),
which serves to compute it: readings that are missing are bridged.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from soft_gripper.arrays import Array
from soft_gripper.estimators.estimate import ShapeEstimate
from soft_gripper.estimators.gaussian import kalman_gain
from soft_gripper.sensors.measurement import MeasurementModel

_READING_STD = 1e-5  # of the quantity, in its unit: so small that what is measured is matched
_START_STD, _STEP_STD = 1e3, 1.0  # rad, of the random walk: uninformative start, large changes between joints


@dataclass(frozen=True)
class SplineShape:
    """The estimator `spline` of one finger; a ShapeFunction."""

    layout: MeasurementModel

    def __call__(self, readings: Array, driving: Array, gravity: Array) -> ShapeEstimate:
        """The joint angles; see ShapeFunction. Driving torque and gravity are ignored."""
        linear = self.layout.linear(readings, _READING_STD)
        gain, _ = kalman_gain(self.layout.matrix, self._walk_covariance, linear.variance)
        return ShapeEstimate((gain @ linear.values[..., None])[..., 0])

    @cached_property
    def _walk_covariance(self) -> Array:
        steps = np.arange(self.layout.finger.segments)
        return _START_STD**2 + _STEP_STD**2 * np.minimum.outer(steps, steps)
