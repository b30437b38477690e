"""The zeros of sensors that drift, found again while a finger is known to be free, and how well they are still known.

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

_SETTLING = 0.5  # s, after which a finger that became free rests
_LEAST, _AVERAGED = 0.2, 1.0  # s, over which readings are averaged, at least and at most
_REPETITIONS, _BALANCED = 30, 1e-7  # turns, at most, and rad, for a finger in balance with its weight


class Zeros(NamedTuple):
    """What is known of the zeros after a sample."""

    offset: Array  # (..., R) of the quantity that is read
    mean: Array  # (..., R) by which the readings are off, since the finger rests freely
    free: Array  # (..., R) s for which the finger has been free
    age: Array  # (..., R) s since the zeros were found


@dataclass(frozen=True)
class Zeroing:
    """The zeros of the sensors of one nominal finger, from sample to sample."""

    mechanics: Mechanics
    period: float  # s, between samples

    def begin(self, shape: tuple[int, ...] = ()) -> Zeros:
        """Before the first sample, with leading axes."""
        return Zeros(*np.zeros((4, *shape, self.mechanics.layout.readings)))

    def step(self, before: Zeros, readings: Array, driving: Array, gravity: Array) -> Zeros:
        """The zeros at a sample; see ShapeFunction for the inputs."""
        free = np.where(self._known_free(driving)[..., None], before.free + self.period, 0.0)
        age = before.age + self.period
        if not (free > _SETTLING).any():
            return before._replace(free=free, age=age)
        offset, mean, found = self._found(before.offset, before.mean, free, (readings, driving, gravity))
        return Zeros(offset, mean, free, np.where(found, 0.0, age))

    def _found(
        self, offset: Array, mean: Array, free: Array, given: tuple[Array, Array, Array]
    ) -> tuple[Array, Array, NDArray[np.bool_]]:
        """Offset and mean at a sample at which a finger rests, and which zeros were found, from those before it."""
        readings, driving, gravity = given
        layout, resting = self.mechanics.layout, free - _SETTLING
        off = layout.measured(readings) - layout.measured(free_readings(self.mechanics, driving, gravity))
        read = np.isfinite(off) & (resting > 0)
        weight = self.period / np.clip(resting, self.period, _AVERAGED)
        mean = np.where(read, mean + weight * (off - mean), mean)
        found = read & (resting >= _LEAST)
        return np.where(found, mean, offset), mean, found

    def over_time(self, readings: Array, driving: Array, gravity: Array, first: int = 0) -> Zeros:
        """The zeros at all samples of a recording, (T, ...), by `step`; those before the `first` leave no trace."""
        gravity = np.broadcast_to(gravity, (*driving.shape[:-1], 3))
        parts = [self._over_time(*(each[part] for each in (readings, driving, gravity))) for part in _split(first)]
        return Zeros(*(np.concatenate(part) for part in zip(*parts, strict=True)))

    def _over_time(self, readings: Array, driving: Array, gravity: Array) -> Zeros:
        if not len(readings):
            return self.begin(readings.shape[:-1])
        shape, is_free = (*readings.shape[:-1], self.mechanics.layout.readings), self._known_free(driving)[..., None]
        free = self._elapsed(np.broadcast_to(~is_free, shape))
        offset, mean, found = np.zeros(shape), np.zeros(shape), np.zeros(shape, bool)
        for i in np.flatnonzero((free > _SETTLING).reshape(len(free), -1).any(axis=1)):
            given = readings[i], driving[i], gravity[i]
            offset[i:], mean[i:], found[i] = self._found(offset[i], mean[i], free[i], given)
        return Zeros(offset, mean, free, self._elapsed(found))

    def _elapsed(self, ends: NDArray[np.bool_]) -> Array:
        """The time since the last sample at which something `ends`, (T, ...) s, or since a period before the first."""
        number = np.arange(len(ends)).reshape(-1, *[1] * (ends.ndim - 1))
        last = np.maximum.accumulate(np.where(ends, number, -1))
        since: Array = np.cumsum(np.append(0.0, np.full(len(ends), self.period)))[number - last]
        return since

    def corrected(self, zeros: Zeros, readings: Array) -> Array:
        """The readings without what they are off, (..., R)."""
        layout = self.mechanics.layout
        return layout.response.reading(1 + layout.measured(readings) - zeros.offset)

    def std(self, zeros: Zeros, readings: Array) -> Array:
        """The standard deviation of the quantity in all readings of a sample, by the oldest zero, (..., 1)."""
        age = np.where(np.isfinite(readings), zeros.age, 0.0).max(axis=-1, keepdims=True)
        return np.asarray(self.mechanics.uncertainty.any_reading(age))

    def _known_free(self, driving: Array) -> NDArray[np.bool_]:
        """Whether the pressure of which a driving torque, (..., D), could come is so low that nothing is touched."""
        gain = self.mechanics.pressure_gain
        found: NDArray[np.bool_] = np.abs(driving @ gain) / (gain @ gain) < self.mechanics.uncertainty.free_pressure
        return found


def _split(first: int) -> tuple[slice, slice]:
    return slice(first), slice(first, None)


def free_readings(mechanics: Mechanics, driving: Array, gravity: Array) -> Array:
    """Readings of a finger that rests and touches nothing, (..., R).

    Args:
        mechanics: of the nominal finger.
        driving: torque, (..., D) N m.
        gravity: in B, (..., 3) m/s^2.
    """
    q = mechanics.free(driving)
    for _ in range(_REPETITIONS):
        before, q = q, mechanics.free(driving + mechanics.weight(mechanics.posture(q), gravity))
        if np.abs(q - before).max(initial=0.0) < _BALANCED:
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
    zeros = zeroing.over_time(readings, driving, gravity)
    return zeroing.corrected(zeros, readings), (zeroing.std(zeros, readings),)
