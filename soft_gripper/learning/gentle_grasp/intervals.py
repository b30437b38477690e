"""Intervals of what a number of episodes shows."""

from typing import NamedTuple

import numpy as np

from soft_gripper.arrays import Array

_Z = 1.959964  # of the standard normal distribution, for 95 %
_RESAMPLES = 10_000


class Interval(NamedTuple):
    """A value with the limits of its 95 % interval."""

    value: float
    low: float
    high: float

    def __str__(self) -> str:
        return f"{self.value:.3f} ({self.low:.3f} to {self.high:.3f})"


def share(successes: int, number: int) -> Interval:
    """The share of successes, with the score interval of Wilson (J. Am. Stat. Assoc. 22, 1927, 209-212)."""
    found, square = successes / number, _Z**2 / number
    middle = (found + square / 2) / (1 + square)
    half = _Z * np.sqrt(found * (1 - found) / number + square / (4 * number)) / (1 + square)
    return Interval(found, float(middle - half), float(middle + half))


def mean(values: Array, seed: int = 0) -> Interval:
    """The mean of values, (n), with the percentile interval of the bootstrap (Efron, Ann. Stat. 7, 1979, 1-26)."""
    rng = np.random.default_rng(seed)
    means = values[rng.integers(len(values), size=(_RESAMPLES, len(values)))].mean(axis=1)
    low, high = np.quantile(means, [0.025, 0.975])
    return Interval(float(values.mean()), float(low), float(high))
