"""Zeros of drifting sensors, found again while the finger is known to be free, and their uncertainty.

A finger that touches nothing rests where driving torque and weight bend it. While the pressure that drives it is below
`Uncertainty.free_pressure`, it is known to touch nothing; once it has settled there, what its readings are off, as a
running mean, are their zeros. Afterwards they count as they were found, a time t ago, and a reading has the standard
deviation

    sqrt(s^2 + o^2 + (d max(t, 60 s))^2)

with s that of a single reading, o that of the offsets, and d that of the rate at which sensors drift, which is steady.
The finger begins with zeros that were just found, as after a calibration.

Leading axes are free; R readings.
"""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from soft_gripper.arrays import Array
from soft_gripper.estimators.mechanics import Mechanics

_SETTLING_TIME = 0.5  # s, until a finger that became free rests
_MIN_AVERAGING_TIME, _MAX_AVERAGING_TIME = 0.2, 1.0  # s
_MAX_ITERATIONS, _ANGLE_TOLERANCE = 30, 1e-7  # and rad, for a finger in balance with its weight


class Zeros(NamedTuple):
    """State of the zeros after a sample."""

    offset: Array  # (..., R) of the quantity that is read
    mean: Array  # (..., R) by which the readings are off, since the finger rests freely
    free_time: Array  # (..., R) s, a period for each of the latest samples at which the finger was free
    age: Array  # (..., R) s since the zeros were found


@dataclass(frozen=True)
class Zeroing:
    """The zeros of the sensors of one nominal finger, from sample to sample."""

    mechanics: Mechanics
    period: float  # s, between samples

    @classmethod
    def from_mechanics(cls, mechanics: Mechanics, period: float) -> "Zeroing | None":
        """The zeros of sensors that drift, or are zeroed while the finger is free; None of others."""
        follows = mechanics.uncertainty.drift > 0 or mechanics.uncertainty.free_pressure > 0
        return cls(mechanics, period) if follows else None

    def begin(self, shape: tuple[int, ...] = ()) -> Zeros:
        """State before the first sample, with leading axes."""
        return Zeros(*np.zeros((4, *shape, self.mechanics.layout.readings)))

    def step(self, last_zeros: Zeros, readings: Array, driving: Array, gravity: Array) -> Zeros:
        """The zeros at a sample; see ShapeFunction for the inputs."""
        free_time = np.where(self._is_known_free(driving)[..., None], last_zeros.free_time + self.period, 0.0)
        age = last_zeros.age + self.period
        if not (self._resting_time(free_time) > 0).any():
            return last_zeros._replace(free_time=free_time, age=age)
        inputs = readings, driving, gravity
        offset, mean, is_found = self._find_zeros(last_zeros.offset, last_zeros.mean, free_time, inputs)
        return Zeros(offset, mean, free_time, np.where(is_found, 0.0, age))

    def _find_zeros(
        self, offset: Array, mean: Array, free_time: Array, inputs: tuple[Array, Array, Array]
    ) -> tuple[Array, Array, NDArray[np.bool_]]:
        """Updates offset and mean at a sample at which a finger rests; also returns a mask of the zeros found."""
        readings, driving, gravity = inputs
        layout, resting_time = self.mechanics.layout, self._resting_time(free_time)
        differences = layout.measured(readings) - layout.measured(free_readings(self.mechanics, driving, gravity))
        is_read = np.isfinite(differences) & (resting_time > 0)
        weight = self.period / np.clip(resting_time, self.period, max(_MAX_AVERAGING_TIME, self.period))
        mean = np.where(is_read, mean + weight * (differences - mean), mean)
        is_found = is_read & (resting_time >= _MIN_AVERAGING_TIME)
        return np.where(is_found, mean, offset), mean, is_found

    def zeros_over_time(self, readings: Array, driving: Array, gravity: Array, first: int = 0) -> Zeros:
        """The zeros at all samples of a recording, (T, ...), by `step`; those before the `first` leave no trace."""
        gravity = np.broadcast_to(gravity, (*driving.shape[:-1], 3))
        inputs = readings, driving, gravity
        parts = [self._zeros_over_time(*(array[part] for array in inputs)) for part in _split_at(first)]
        return Zeros(*(np.concatenate(part) for part in zip(*parts, strict=True)))

    def _zeros_over_time(self, readings: Array, driving: Array, gravity: Array) -> Zeros:
        if not len(readings):
            return self.begin(readings.shape[:-1])
        shape = (*readings.shape[:-1], self.mechanics.layout.readings)
        is_free = self._is_known_free(driving)[..., None]
        free_time = self._elapsed(np.broadcast_to(~is_free, shape))
        rests = np.flatnonzero((self._resting_time(free_time) > 0).reshape(len(free_time), -1).any(axis=1))
        offset, mean = np.zeros((2, len(rests) + 1, *shape[1:]))  # before the first sample at which any finger rests
        is_found = np.zeros(shape, bool)
        for k, i in enumerate(rests):
            inputs = readings[i], driving[i], gravity[i]
            zeros = self._find_zeros(offset[k], mean[k], free_time[i], inputs)
            offset[k + 1], mean[k + 1], is_found[i] = zeros
        latest = np.searchsorted(rests, np.arange(len(free_time)), "right")
        return Zeros(offset[latest], mean[latest], free_time, self._elapsed(is_found))

    def _resting_time(self, free_time: Array) -> Array:
        """Time at rest, s, of a finger that has been free for a time, s, counted from its first free sample."""
        return free_time - self.period - _SETTLING_TIME

    def _elapsed(self, ends: NDArray[np.bool_]) -> Array:
        """The time since the last sample at which something `ends`, (T, ...) s, or since a period before the first."""
        number = np.arange(len(ends)).reshape(-1, *[1] * (ends.ndim - 1))
        last = np.maximum.accumulate(np.where(ends, number, -1))
        return np.cumsum(np.append(0.0, np.full(len(ends), self.period)))[number - last]

    def correct(self, zeros: Zeros, readings: Array) -> Array:
        """Readings without their offsets, (..., R)."""
        layout = self.mechanics.layout
        return layout.response.reading(1 + layout.measured(readings) - zeros.offset)

    def std(self, zeros: Zeros, readings: Array) -> Array:
        """The standard deviation of the quantity in all readings of a sample, by the oldest zero, (..., 1)."""
        age = np.where(np.isfinite(readings), zeros.age, 0.0).max(axis=-1, keepdims=True)
        return np.asarray(self.mechanics.uncertainty.any_reading(age))

    def _is_known_free(self, driving: Array) -> NDArray[np.bool_]:
        """Whether a driving torque, (..., D), means a pressure below `free_pressure`."""
        gain = self.mechanics.pressure_gain
        return np.abs(driving @ gain) / (gain @ gain) < self.mechanics.uncertainty.free_pressure


def _split_at(first: int) -> tuple[slice, slice]:
    return slice(first), slice(first, None)


def free_readings(mechanics: Mechanics, driving: Array, gravity: Array) -> Array:
    """Readings of a finger that rests and touches nothing, (..., R).

    Args:
        mechanics: of the nominal finger.
        driving: torque, (..., D) N m.
        gravity: in B, (..., 3) m/s^2.
    """
    q = mechanics.positions_under(driving)
    for _ in range(_MAX_ITERATIONS):
        last = q
        q = mechanics.positions_under(driving + mechanics.weight(mechanics.bent_finger(q), gravity))
        if np.abs(q - last).max(initial=0.0) < _ANGLE_TOLERANCE:
            break
    return mechanics.layout.read(q)


def zeroing_of(function: object) -> Zeroing | None:
    """The zeros that an estimator follows, if it does."""
    zeroing = getattr(function, "zeroing", None)
    return zeroing if isinstance(zeroing, Zeroing) else None


def recorded_zeros(
    function: object, readings: Array, driving: Array, gravity: Array
) -> tuple[Array, tuple[Array, ...]]:
    """The readings of a recording, (T, ..., R), as an estimator uses them, and further arguments that it takes.

    Arguments as of ShapeFunction, after the name of the estimator.
    """
    zeroing = zeroing_of(function)
    if zeroing is None:
        return readings, ()
    zeros = zeroing.zeros_over_time(readings, driving, gravity)
    return zeroing.correct(zeros, readings), (zeroing.std(zeros, readings),)
