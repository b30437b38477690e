"""A response that differs from sensor to sensor: a gain and an offset for each."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from soft_gripper.arrays import Array
from soft_gripper.sensors.response_curve import ResponseCurve


@dataclass(frozen=True)
class CalibratedResponse:
    """A curve for all sensors, of whose extension ratios each shows its own: 1 + gain (ratio - 1) + offset.

    Arrays of ratios and readings are (..., R), with R gains and offsets.
    """

    curve: ResponseCurve
    gains: tuple[float, ...]
    offsets: tuple[float, ...]  # extension ratio

    def reading(self, ratio: Array) -> Array:
        """Sensor readings for extension ratios."""
        return self.curve.reading(1 + self._gains * (ratio - 1) + self._offsets)

    def ratio(self, reading: Array) -> Array:
        """Extension ratios for sensor readings; the inverse of `reading`."""
        return 1 + (self.curve.ratio(reading) - 1 - self._offsets) / self._gains

    @cached_property
    def _gains(self) -> Array:
        return np.array(self.gains)

    @cached_property
    def _offsets(self) -> Array:
        return np.array(self.offsets)
