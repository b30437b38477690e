"""Finds readings of a finger, possibly at rest, that are clipped by their converter or never change.

A finger at rest has readings that stay the same too, often its smallest. A reading counts as clipped if another signal
that it followed continues while it stays at its largest or smallest value, or has left the range that belongs to it.
"""

from collections.abc import Mapping
from typing import NamedTuple

import numpy as np

from soft_gripper.arrays import Array

_MIN_CLIPPED_SHARE = 0.03  # of the samples that are clipped; fewer hardly change a fit
_GLITCH_PERCENT = 2.0  # %, samples that may lie beyond: glitches
_MIN_SAMPLES = 20
_MIN_CORRELATION = 0.8  # with the signal that is followed, in the other samples
_MIN_MOTION_SHARE = 0.15  # of the range: motion of the followed signal while the reading stays
_MIN_EXCESS_SHARE = 0.05  # of the range: excess of the followed signal over the end
_MIN_MOTION_STDS = 5.0  # of the residuals of a line through both: these include curved responses and hysteresis
_MIN_MOTION_STEPS = 2.0  # of the converter beside the end: a coarse reading stays the same while others move a little
_MAX_FLICKER = 10  # a reading with more values moves


class StuckReading(NamedTuple):
    """A reading that stays at a value while others change."""

    name: str
    value: float
    question: str


def stuck_readings(readings: Mapping[str, Array], others: Mapping[str, Array]) -> list[StuckReading]:
    """Readings, (T,) by name, that seem clipped or dead beside each other and other signals, (T,)."""
    signals = {**readings, **others}
    questions = []
    for name, reading in readings.items():
        references = {other: values for other, values in signals.items() if other != name}
        values_ = reading[np.isfinite(reading)]
        if len(values_) < _MIN_SAMPLES:
            continue
        if np.ptp(values_) == 0:
            levels = (len(np.unique(other[np.isfinite(other)])) for other in readings.values())
            if max(levels) > _MAX_FLICKER:  # another does more than flicker by the steps of its converter
                question = "never changes, and others do: is it connected?"
                questions.append(StuckReading(name, float(values_[0]), question))
            continue
        low, high = map(float, np.percentile(values_, [_GLITCH_PERCENT, 100 - _GLITCH_PERCENT], method="nearest"))
        in_range = np.where((reading >= low) & (reading <= high), reading, np.nan)
        for word, end in (("largest", high), ("smallest", low)):
            share = float((values_ == end).mean())
            if share >= _MIN_CLIPPED_SHARE and any(_continues(in_range, end, values) for values in references.values()):
                question = f"has its {word} value in {100 * share:.0f} % of the samples: is it clipped?"
                questions.append(StuckReading(name, end, question))
    return questions


def _continues(reading: Array, end: float, other: Array) -> bool:
    """Whether a signal that a reading follows, by a line, goes on while the reading stays at an end of its range."""
    is_known = np.isfinite(reading) & np.isfinite(other)
    is_at_end, free = is_known & (reading == end), is_known & (reading != end)
    sample_counts = is_at_end.sum(), free.sum()
    if min(sample_counts) < _MIN_SAMPLES or min(np.ptp(other[free]), np.ptp(reading[free])) == 0:
        return False
    correlation = float(np.corrcoef(reading[free], other[free])[0, 1])
    if not abs(correlation) >= _MIN_CORRELATION:
        return False
    slope = correlation * np.std(reading[free]) / np.std(other[free])
    std = float(np.std(reading[free] - slope * other[free]))
    expected = np.mean(reading[free]) + slope * (other[is_at_end] - np.mean(other[free]))
    size = _range(reading[is_known])
    min_motion = max(_MIN_MOTION_STDS * std, _MIN_MOTION_STEPS * float(np.abs(reading[free] - end).min()))
    outward = np.sign(end - np.median(reading[free]))
    excess = float(outward * (np.median(expected) - end))
    is_moving = _range(expected) > max(_MIN_MOTION_SHARE * size, min_motion)
    return is_moving or excess > max(_MIN_EXCESS_SHARE * size, min_motion)


def _range(values: Array) -> float:
    low, high = np.percentile(values, [10, 90])
    return float(high - low)
