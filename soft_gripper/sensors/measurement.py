"""The measurement model of a finger: joint angles -> readings, and their information about the joint angles.

The sensors measure a quantity, y = h(q) + noise, of which the readings are what a response curve makes. Estimators that
are linear in the joint angles need no more of it than

    z = A q + noise ,

values z that follow from the readings, with their variances. One or several readings may see the same value: near the
straight finger y = c z, with the sensitivities c, so that the Jacobian of h is c A and readings of equal noise give

    z = sum c^2 z_reading / sum c^2 ,   variance = noise^2 / sum c^2 ,

over those that read anything.

Everything is pure and takes arrays whose leading axes are free, so that a block calls it for one sample and an
evaluation once for a whole recording. The positions q of the joints are flat, (..., D): by deformation that the
sensors see, bending first, and N from the base to the tip in each. R readings, S values.

Another kind of sensor is a subclass of `MeasurementModel` and its name in `SENSORS` (`scenario.sensor_presets`).
"""

from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, fields
from functools import cached_property
from typing import Any, ClassVar, NamedTuple

import numpy as np
from numpy.typing import NDArray

from soft_gripper.arrays import Array
from soft_gripper.errors import InputError
from soft_gripper.files.document import Place, read
from soft_gripper.fingers.finger import Finger
from soft_gripper.fingers.finger_parts import AXES
from soft_gripper.quantity import Rule
from soft_gripper.sensors.calibrated_states import CalibratedStates
from soft_gripper.sensors.response_curve import CalibratedResponse, ResponseCurve

UNKNOWN = 1e6  # variance of a value that is not measured, in the square of its unit


class LinearReadings(NamedTuple):
    """Information in the readings about the joint angles, each (..., S)."""

    values: Array  # z, rad where the readings are of bends or angles; 0 if not measured
    variance: Array

    def uncertain_by(self, share: float) -> "LinearReadings":
        """A copy with an additional error of every value, of a standard deviation that is a fraction of the value."""
        return LinearReadings(self.values, self.variance + (share * self.values) ** 2)


@dataclass(frozen=True)
class MeasurementModel(ABC):
    """Sensors of one finger, one or several in each of its `sections`.

    A subclass is a kind of sensor. It gives the quantity that is read, its unit and the matrix A: then h(q) = A q, and
    every row is one reading. What is not linear overrides `predict` and `inverse` as well, see `SensorLayout`.

    Sections are as equal as whole segments allow, or end at `borders`, one fewer than there are sections: shares of the
    finger's length, each taken to the nearest end of a segment.

    Raises:
        InputError: if there are fewer than 1 or more sections than segments, the borders do not make so many, the
            response is calibrated for other sensors, or A does not fit the joints.
    """

    quantity: ClassVar[str]  # names the port that carries the readings
    unit: ClassVar[str]  # of the quantity

    finger: Finger
    sections: int
    response: ResponseCurve | CalibratedResponse = field(default_factory=ResponseCurve, kw_only=True)  # of 1 + y
    borders: tuple[float, ...] | None = field(default=None, kw_only=True)
    calibrated: CalibratedStates | None = field(default=None, kw_only=True)  # None: it was not, or nobody knows where

    def __post_init__(self) -> None:
        ends, segments = self.section_ends, self.finger.segments
        if len(ends) != self.sections + 1 or not np.all(np.diff(ends) > 0):
            shares = f"{self.sections - 1} increasing shares of the length"
            expected = f"give {shares}, each at another end of {segments} segments"
            raise InputError("sensor", "borders", self.borders, expected)
        shape = np.shape(self.matrix)
        columns = segments * len(self.deformations)
        if len(shape) != 2 or shape[0] < 1 or shape[1] != columns or not np.isfinite(self.matrix).all():
            expected = f"give finite numbers, a row for each value and {columns} columns"
            raise InputError("sensor", f"matrix of {type(self).__name__}", shape, expected)
        if isinstance(self.response, CalibratedResponse) and len(self.response.gains) != self.readings:
            expected = f"the layout has {self.readings} readings"
            raise InputError("calibration", "gains", list(self.response.gains), expected)

    @property
    def unnamed(self) -> tuple[Any, ...]:
        """Key for a cache: equal for the sensors of fingers that differ by nothing but their names."""
        values = (getattr(self, parameter.name) for parameter in fields(self) if parameter.name != "finger")
        return type(self), self.finger.unnamed, *values

    @property
    @abstractmethod
    def matrix(self) -> Array:
        """A, from joint angles to the measured values, (S, D)."""

    @property
    def deformations(self) -> tuple[str, ...]:
        """Ways of yielding that change the readings, see `finger_parts.AXES`; bending comes first."""
        return ("bending",)

    @cached_property
    def sensitivity(self) -> Array:
        """Derivative of each measured quantity with respect to its value, at the straight finger, (R / S, S)."""
        return np.ones((1, len(self.matrix)))

    @cached_property
    def straight(self) -> Array:
        """Joint positions of the straight finger, (D,)."""
        return np.zeros(len(self.deformations) * self.finger.segments)

    @property
    def axes(self) -> Mapping[str, Sequence[Any]]:
        """Labels of the readings along each axis, for `describe`."""
        return {"sensor": range(self.readings)}

    @cached_property
    def readings(self) -> int:
        """Number of readings."""
        return int(self.sensitivity.size)

    @cached_property
    def jacobian(self) -> Array:
        """Jacobian of h at the straight finger, (R, D)."""
        return (self.sensitivity[..., None] * self.matrix).reshape(self.readings, -1)

    def predict(self, q: Array) -> Array:
        """The measured quantity, h(q): (..., D) -> (..., R)."""
        return q @ self.jacobian.T

    def slopes(self, q: Array) -> Array:
        """Jacobian of h at q, (..., D) -> (R, D), or (..., R, D) where it changes."""
        return self.jacobian

    def linearized(self, q: Array) -> tuple[Array, Array]:
        """The measured quantity and its Jacobian, as from `predict` and `slopes`."""
        return self.predict(q), self.slopes(q)

    def inverse(self, measured: Array) -> Array:
        """The value implied by each reading alone, (..., R / S, S), from its quantity y, of the same shape."""
        return measured / self.sensitivity

    def signals(self, q: Array) -> dict[str, Array]:
        """The sensor outputs, (..., R) each, by port name; the readings are `quantity`."""
        return {self.quantity: self.response.reading(1 + self.predict(q))}

    def read(self, q: Array) -> Array:
        """Readings of joint angles, (..., D) rad -> (..., R)."""
        return self.signals(q)[self.quantity]

    def measured(self, readings: Array) -> Array:
        """The quantity y that corresponds to readings, (..., R)."""
        return self.response.ratio(readings) - 1

    def linear(self, readings: Array, noise: Array | float) -> LinearReadings:
        """The values z computed from readings, (..., R).

        `noise` is the standard deviation of the quantity y, (..., 1), or the same for all. Where no reading of a value
        is finite it is 0, with the variance UNKNOWN.
        """
        quantities = self.measured(readings).reshape(*readings.shape[:-1], *self.sensitivity.shape)
        is_read = np.isfinite(quantities)
        if is_read.all():
            weights, information, divisor = self._complete_information
            values = (weights * self.inverse(quantities)).sum(axis=-2) / divisor
            variance = noise**2 / np.maximum(information, noise**2 / UNKNOWN)
            return LinearReadings(values, np.broadcast_to(variance, values.shape))
        weights = is_read * self.sensitivity**2
        information = weights.sum(axis=-2)
        reading_values = self.inverse(np.where(is_read, quantities, 0.0))
        values = (weights * reading_values).sum(axis=-2) / np.where(information == 0, 1.0, information)
        return LinearReadings(values, noise**2 / np.maximum(information, noise**2 / UNKNOWN))

    @cached_property
    def _complete_information(self) -> tuple[Array, Array, Array]:
        """Information of each reading, (R / S, S), their sum for each value, (S,), and that sum or 1."""
        information = (self.sensitivity**2).sum(axis=0)
        return self.sensitivity**2, information, np.where(information == 0, 1.0, information)

    def values(self, readings: Array, noise: Array | float) -> LinearReadings:
        """The values that estimators condition on; `values_at` has their slopes; arguments as in `linear`."""
        return self.linear(readings, noise)

    def values_at(self, q: Array) -> tuple[Array, Array]:
        """The values z of joint positions, (..., D) -> (..., S), and their slopes, (S, D), or (..., S, D)."""
        return q @ self.matrix.T, self.matrix

    @cached_property
    def section_ends(self) -> NDArray[np.int_]:
        """Segments covered up to the end of each section, from 0 to N."""
        equal = self.finger.section_ends(self.sections)
        if self.borders is None:
            return equal
        read(self.borders, tuple[float, ...], Rule(), Place("sensor", "borders", strict=True))
        return np.round(np.array([0.0, *self.borders, 1.0]) * self.finger.segments).astype(int)

    @cached_property
    def joints_per_section(self) -> NDArray[np.int_]:
        """Number of joints in every section."""
        return np.diff(self.section_ends)

    @cached_property
    def rest_lengths(self) -> Array:
        """Rest length of every section, m."""
        return self.joints_per_section * self.finger.segment_length

    @cached_property
    def joint_sections(self) -> NDArray[np.int_]:
        """Section that contains each joint, (N,)."""
        return np.repeat(np.arange(self.sections), self.joints_per_section)

    @cached_property
    def joint_fractions(self) -> Array:
        """Relative position of each joint within its section, 0 to 1, (N,)."""
        begin = self.section_ends[self.joint_sections] * self.finger.segment_length
        return (self.finger.joint_arc_lengths - begin) / self.rest_lengths[self.joint_sections]


@dataclass(frozen=True)
class SpatialSensors(MeasurementModel):
    """Sensors that see every deformation of their finger; estimators condition on each measured quantity."""

    def values(self, readings: Array, noise: Array | float) -> LinearReadings:
        quantities = self.measured(readings)
        is_read = np.isfinite(quantities)
        return LinearReadings(np.where(is_read, quantities, 0.0), np.where(is_read, noise**2, UNKNOWN))

    def values_at(self, q: Array) -> tuple[Array, Array]:
        return self.linearized(q)

    @cached_property
    def deformations(self) -> tuple[str, ...]:
        return spatial_deformations(self.finger)


def spatial_deformations(finger: Finger) -> tuple[str, ...]:
    """Names of the deformations of a finger, bending first."""
    return ("bending", *(name for name in AXES if name in finger.yields and name != "bending"))
