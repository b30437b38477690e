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

from soft_gripper.arrays import Array
from soft_gripper.estimators.mechanics import Mechanics

_SETTLING = 0.5  # s, after which a finger that became free rests
_LEAST, _AVERAGED = 0.2, 1.0  # s, over which readings are averaged, at least and at most
_REPETITIONS, _BALANCED = 30, 1e-7  # turns, at most, and rad, for a finger in balance with its weight


class Zeros(NamedTuple):
    """State of the zeros after a sample."""

    offset: Array  # (..., R) of the quantity that is read
    mean: Array  # (..., R) by which the readings are off, since the finger rests freely
    free: Array  # (..., R) s, a period for each of the latest samples at which the finger was free
    age: Array  # (..., R) s since the zeros were found


@dataclass(frozen=True)
class Zeroing:
    """The zeros of the sensors of one nominal finger, from sample to sample."""

    mechanics: Mechanics
    period: float  # s, between samples

    @classmethod
    def of(cls, mechanics: Mechanics, period: float) -> "Zeroing | None":
        """The zeros of sensors that drift, or are zeroed while the finger is free; None of others."""
        follows = mechanics.uncertainty.drift > 0 or mechanics.uncertainty.free_pressure > 0
        return cls(mechanics, period) if follows else None

    def begin(self, shape: tuple[int, ...] = ()) -> Zeros:
        """Before the first sample, with leading axes."""
        return Zeros(*np.zeros((4, *shape, self.mechanics.layout.readings)))

    def step(self, before: Zeros, readings: Array, driving: Array, gravity: Array) -> Zeros:
        """The zeros at a sample; see ShapeFunction for the inputs."""
        known_free = (self._pressure(driving) < self.mechanics.uncertainty.free_pressure)[..., None]
        free = np.where(known_free, before.free + self.period, 0.0)
        age, resting = before.age + self.period, free - self.period - _SETTLING  # free since the first such sample
        if not (resting > 0).any():
            return before._replace(free=free, age=age)
        layout = self.mechanics.layout
        off = layout.measured(readings) - layout.measured(free_readings(self.mechanics, driving, gravity))
        read = np.isfinite(off) & (resting > 0)
        weight = self.period / np.clip(resting, self.period, max(_AVERAGED, self.period))
        mean = np.where(read, before.mean + weight * (off - before.mean), before.mean)
        found = read & (resting >= _LEAST)
        return Zeros(np.where(found, mean, before.offset), mean, free, np.where(found, 0.0, age))

    def over_time(self, readings: Array, driving: Array, gravity: Array, first: int = 0) -> Zeros:
        """The zeros at all samples of a recording, (T, ...); those before the `first` one leave no trace."""
        begin, zeros = self.begin(readings.shape[1:-1]), list[Zeros]()
        gravity = np.broadcast_to(gravity, (*driving.shape[:-1], 3))
        for i, sample in enumerate(zip(readings, driving, gravity, strict=True)):
            zeros.append(self.step(zeros[-1] if i > first else begin, *sample))
        return Zeros(*(np.array(part) for part in zip(*zeros, strict=True)))

    def corrected(self, zeros: Zeros, readings: Array) -> Array:
        """The readings without what they are off, (..., R)."""
        layout = self.mechanics.layout
        return layout.response.reading(1 + layout.measured(readings) - zeros.offset)

    def std(self, zeros: Zeros, readings: Array) -> Array:
        """The standard deviation of the quantity in all readings of a sample, by the oldest zero, (..., 1)."""
        age = np.where(np.isfinite(readings), zeros.age, 0.0).max(axis=-1, keepdims=True)
        return np.asarray(self.mechanics.uncertainty.any_reading(age))

    def _pressure(self, driving: Array) -> Array:
        """The pressure of which a driving torque, (..., D), could come, absolute, (...) Pa."""
        gain = self.mechanics.pressure_gain
        return np.abs(driving @ gain) / (gain @ gain)


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
