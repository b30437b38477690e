"""Readings that ended at the end of their converter's range, or never moved, told from readings of a finger at rest.

A finger at rest has readings that stay the same too, often its smallest. A reading counts as clipped if another signal
that it followed goes on while it stays at its largest or smallest value, or has gone on beyond where that one belongs.
"""

from collections.abc import Mapping
from typing import NamedTuple

import numpy as np

from soft_gripper.arrays import Array

_MIN_SHARE = 0.03  # of the samples that are clipped; fewer hardly change a fit
_BEYOND = 2.0  # %, samples that may lie beyond: glitches
_MIN_SAMPLES = 20
_MIN_CORRELATION = 0.8  # with the signal that is followed, in the other samples
_MOVES = 0.15  # of the range: followed motion while the reading stays
_GOES_BEYOND = 0.05  # of the range, likewise
_STDS = 5.0  # of the residuals of the line by which it is followed: curved responses and hysteresis are in them
_STEPS = 2.0  # of the reading beside its end: a coarse one stays the same while others move a little
_MOVING_LEVELS = 10  # values of a reading that moves; more


class StuckReading(NamedTuple):
    """A reading that stays at a value while others move."""

    name: str
    value: float
    question: str


def stuck_readings(readings: Mapping[str, Array], others: Mapping[str, Array]) -> list[StuckReading]:
    """Readings, (T,) by name, that seem to be clipped or dead, judged by each other and by other signals, (T,)."""
    signals = {**readings, **others}
    questions = []
    for name, reading in readings.items():
        followed = {other: values for other, values in signals.items() if other != name}
        seen = reading[np.isfinite(reading)]
        if len(seen) < _MIN_SAMPLES:
            continue
        if np.ptp(seen) == 0:
            levels = (len(np.unique(other[np.isfinite(other)])) for other in readings.values())
            if max(levels) > _MOVING_LEVELS:  # another does more than flicker by the steps of its converter
                questions.append(StuckReading(name, float(seen[0]), "never changes, and others do: is it connected?"))
            continue
        low, high = map(float, np.percentile(seen, [_BEYOND, 100 - _BEYOND], method="nearest"))
        inside = np.where((reading >= low) & (reading <= high), reading, np.nan)
        for word, end in (("largest", high), ("smallest", low)):
            share = float((seen == end).mean())
            if share >= _MIN_SHARE and any(_goes_on(inside, end, values) for values in followed.values()):
                question = f"has its {word} value in {100 * share:.0f} % of the samples: is it clipped?"
                questions.append(StuckReading(name, end, question))
    return questions


def _goes_on(reading: Array, end: float, other: Array) -> bool:
    """Whether a signal that a reading follows, by a line, goes on while the reading stays at an end of its range."""
    known = np.isfinite(reading) & np.isfinite(other)
    at_end, free = known & (reading == end), known & (reading != end)
    if at_end.sum() < _MIN_SAMPLES or free.sum() < _MIN_SAMPLES or min(np.ptp(other[free]), np.ptp(reading[free])) == 0:
        return False
    correlation = float(np.corrcoef(reading[free], other[free])[0, 1])
    if not abs(correlation) >= _MIN_CORRELATION:
        return False
    slope = correlation * np.std(reading[free]) / np.std(other[free])
    std = float(np.std(reading[free] - slope * other[free]))
    expected = np.mean(reading[free]) + slope * (other[at_end] - np.mean(other[free]))
    size, least = _range(reading[known]), max(_STDS * std, _STEPS * float(np.abs(reading[free] - end).min()))
    outward = np.sign(end - np.median(reading[free]))
    moves, beyond = _range(expected), float(outward * (np.median(expected) - end))
    return moves > max(_MOVES * size, least) or beyond > max(_GOES_BEYOND * size, least)


def _range(values: Array) -> float:
    low, high = np.percentile(values, [10, 90])
    return float(high - low)
