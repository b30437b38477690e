"""An instrument that reads late, from a zero of its own, and drifts: found by comparison with an estimate of the same.

With e the estimate, each run of the instrument reads

    m(t) = a e(t - T) + m_0 + d t .

The delay T and the drift d are those of the instrument in all runs, its zero m_0 is that of a run, which may begin with
another tare. T is that with the least sum of absolute residuals of a line through each run; m_0 and d are those of what
is read while the estimate is as good as zero, at rest: by lines of one slope, robustly. The factor a is not applied:
how estimate and instrument differ is what is to be known.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from soft_gripper.arrays import Array

MOST_DELAY = 2.0  # s
_FREE_SHARE = 0.1  # of the 95th percentile of the estimate, below which nothing touches
_FEWEST = 10  # samples from which a zero is found
_LEAST_SPAN = 10.0  # s between the first and the last of them from which a drift is found
_PASSES, _HUBER, _STD_PER_MEDIAN = 8, 1.5, 1.4826  # of the robust lines; standard deviations; of a normal variable
_NOTHING = 1e-9  # smallest spread of residuals
_MOST_ROWS = 4000  # samples of a run that the delay is sought in


@dataclass(frozen=True)
class InstrumentRun:
    """T samples of an instrument and an estimate of what it measures, at equal steps; NaN where there is none."""

    time: Array  # (T,) s
    value: Array  # (T,)
    estimate: Array  # (T,)
    rest: NDArray[np.bool_]  # (T,) whether the finger rests


@dataclass(frozen=True)
class Instrument:
    """Delay, zero and drift found of an instrument."""

    delay: float  # s
    zeros: tuple[float, ...]  # in each run; NaN: not found, since the finger was never free
    drift: float  # per s, in all runs; NaN: not found, since the finger was never free for long enough

    def corrected(self, number: int, run: InstrumentRun) -> Array:
        """Readings that it would have had in a run without delay, zero and drift, (T,); as far as these are known."""
        zero, drift = np.nan_to_num([self.zeros[number], self.drift])
        return _earlier(run.value - zero - drift * run.time, _steps(self.delay, run))


def find_instrument(runs: Sequence[InstrumentRun], least: float, most_delay: float = MOST_DELAY) -> Instrument:
    """Delay, zeros and drifts; `least` is an estimate below which nothing touches, whatever its range."""
    steps = range(int(most_delay / _period(runs[0])) + 1)
    spread = [float(np.nanstd(run.estimate)) for run in runs]
    costs = [sum(_misfit(run, shift) for run in runs) for shift in steps] if max(spread) > 0 else [0.0]
    delay = _period(runs[0]) * int(np.argmin(costs))
    zeros, drift = _lines(runs, delay, least)
    return Instrument(delay, zeros, drift)


def _period(run: InstrumentRun) -> float:
    return float(run.time[1] - run.time[0]) if len(run.time) > 1 else np.inf


def _steps(delay: float, run: InstrumentRun) -> int:
    return round(delay / _period(run))


def _earlier(value: Array, steps: int) -> Array:
    """Values `steps` samples later, in the place of those now; NaN at the end."""
    return np.append(value[steps:], np.full(min(steps, len(value)), np.nan))


def _misfit(run: InstrumentRun, steps: int) -> float:
    """Sum of absolute residuals of a line through what an instrument reads `steps` later, over the estimate."""
    value = _earlier(run.value, steps)
    known = np.flatnonzero(np.isfinite(value + run.estimate))
    known = known[:: max(1, len(known) // _MOST_ROWS)]
    if len(known) < _FEWEST:
        return np.inf
    basis = np.column_stack([run.estimate[known], np.ones(len(known)), run.time[known]])
    found = np.linalg.lstsq(basis, value[known], rcond=None)[0]
    return float(np.abs(value[known] - basis @ found).mean())


def _lines(runs: Sequence[InstrumentRun], delay: float, least: float) -> tuple[tuple[float, ...], float]:
    """Zeros and drift of what an instrument reads while nothing touches, by lines of one slope, fitted robustly."""
    free = [_free(run, delay, least) for run in runs]
    known = [i for i, (time, _) in enumerate(free) if len(time) >= _FEWEST]
    if not known:
        return (np.nan,) * len(runs), np.nan
    time, value = (np.concatenate([free[i][part] for i in known]) for part in (0, 1))
    number = np.repeat(np.arange(len(known)), [len(free[i][0]) for i in known])
    drifts = max(np.ptp(free[i][0]) for i in known) >= _LEAST_SPAN
    basis = np.column_stack([number[:, None] == np.arange(len(known)), time * drifts]).astype(float)
    weight, steps = np.ones(len(time)), np.diff(np.unique(value))
    resolution = float(steps.min()) if len(steps) else 0.0  # 0 if it never changes
    for _ in range(_PASSES):
        found = np.linalg.lstsq(basis * weight[:, None], value * weight, rcond=None)[0]
        left = np.abs(value - basis @ found)
        spread = max(_HUBER * _STD_PER_MEDIAN * float(np.median(left)), resolution, _NOTHING)
        weight = np.sqrt(spread / np.maximum(left, spread))
    zeros = dict(zip(known, found.tolist(), strict=False))
    return tuple(zeros.get(i, np.nan) for i in range(len(runs))), float(found[-1]) if drifts else np.nan


def _free(run: InstrumentRun, delay: float, least: float) -> tuple[Array, Array]:
    """Times, and what an instrument reads at them, while nothing touches."""
    size, steps = np.abs(run.estimate), _steps(delay, run)
    most = max(least, _FREE_SHARE * float(np.nanpercentile(size, 95))) if np.isfinite(size).any() else least
    value = _earlier(run.value, steps)
    free = run.rest & (size < most) & np.isfinite(value)
    return run.time[free] + steps * _period(run), value[free]
