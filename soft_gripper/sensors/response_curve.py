"""The response of a sensor to stretch: a curve through points, and its exact inverse."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from soft_gripper.arrays import Array
from soft_gripper.errors import InputError
from soft_gripper.piecewise_linear import PiecewiseLinear

_LEAST_STEP = 1e-9  # between points; smaller ones are lost in rounding
LINEAR = ((1.0, 0.0), (2.0, 1.0))


@dataclass(frozen=True)
class ResponseCurve:
    """Piecewise linear curve through (extension ratio, reading) points, extrapolated linearly beyond the ends.

    The default is the linear response: the reading is the engineering strain, extension ratio - 1.

    Raises:
        InputError: unless there are two finite points at least, both columns strictly increasing, by 1e-9 at least.
    """

    points: Sequence[Sequence[float]] = LINEAR

    def __post_init__(self) -> None:
        try:
            columns = np.array(self.points, dtype=float)
        except (TypeError, ValueError):
            columns = np.empty((0, 2))
        pairs = columns.shape[1:] == (2,) and len(columns) >= 2
        if not pairs or not np.isfinite(columns).all() or not np.all(np.diff(columns, axis=0) >= _LEAST_STEP):
            expected = "give at least two finite [extension ratio, reading] pairs, both strictly increasing"
            raise InputError("sensor", "response", self.points, expected)

    def reading(self, ratio: Array) -> Array:
        """Sensor readings for extension ratios, any shape."""
        return self._to_reading(ratio)

    def ratio(self, reading: Array) -> Array:
        """Extension ratios for sensor readings, any shape; the inverse of `reading`."""
        return self._to_ratio(reading)

    @cached_property
    def _to_reading(self) -> PiecewiseLinear:
        return PiecewiseLinear(*np.array(self.points, dtype=float).T)

    @cached_property
    def _to_ratio(self) -> PiecewiseLinear:
        return self._to_reading.inverse()


@dataclass(frozen=True)
class CalibratedResponse:
    """One curve for all sensors, applied to an extension ratio specific to each: 1 + gain (s + curvature s^2) + offset.

    s is the strain, ratio - 1. Arrays of ratios and readings are (..., R), with R gains and offsets. A reading beyond
    the extreme of the parabola counts as that extreme.
    """

    curve: ResponseCurve
    gains: tuple[float, ...]
    offsets: tuple[float, ...]  # extension ratio
    curvature: float = 0.0

    def reading(self, ratio: Array) -> Array:
        strain = ratio - 1
        gains, offsets = self._columns
        return self.curve.reading(1 + gains * (strain + self.curvature * strain**2) + offsets)

    def ratio(self, reading: Array) -> Array:
        gains, offsets = self._columns
        bent = (self.curve.ratio(reading) - 1 - offsets) / gains
        # The root near `bent` of s + curvature s^2 = bent, in a form that holds without a curvature too.
        return 1 + 2 * bent / (1 + np.sqrt(np.maximum(1 + 4 * self.curvature * bent, 0.0)))

    @cached_property
    def _columns(self) -> tuple[Array, Array]:
        return np.array(self.gains), np.array(self.offsets)
