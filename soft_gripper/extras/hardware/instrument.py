"""Finds delay, zero and drift of an instrument by comparison with an estimate of the same quantity, T samples of both.

With e the estimate, each run of the instrument reads

    m(t) = a e(t - T) + m_0 + d t .

The delay T and the drift d are those of the instrument in all runs, its zero m_0 is that of a run, which may begin with
another tare. T has the least sum of absolute residuals of a line through each run; m_0 and d are lines of one slope
through the readings at rest with an estimate of about zero, fitted robustly. The factor a is not applied: it is the
difference of estimate and instrument that is sought.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from soft_gripper.arrays import Array

MAX_DELAY = 2.0  # s
_MAX_FREE_SHARE = 0.1  # of the 95th percentile of the estimate, below which nothing touches
_MIN_ZERO_SAMPLES = 10  # samples from which a zero is found
_MIN_DRIFT_SPAN = 10.0  # s between the first and the last of them from which a drift is found
_LINE_ITERATIONS, _HUBER_DEVIATIONS = 8, 1.5  # of the robust lines; standard deviations
_STD_PER_MEDIAN, _MIN_RESIDUAL = 1.4826, 1e-9  # of absolute values of a normal variable; smallest residual
_MAX_DELAY_SAMPLES = 4000  # samples of a run that the delay is sought in


@dataclass(frozen=True)
class InstrumentRun:
    """T samples of an instrument and of an estimate of its quantity, at equal steps; NaN where missing."""

    time: Array  # (T,) s
    value: Array  # (T,)
    estimate: Array  # (T,)
    rest: NDArray[np.bool_]  # (T,) whether the finger rests


@dataclass(frozen=True)
class Instrument:
    """Delay, zero and drift of an instrument."""

    delay: float  # s
    zeros: tuple[float, ...]  # in each run; NaN: not found, since the finger was never free
    drift: float  # per s, in all runs; NaN: not found, since the finger was never free for long enough

    def corrected(self, number: int, run: InstrumentRun) -> Array:
        """Readings in a run, (T,), corrected for delay, zero and drift as far as these are known."""
        zero, drift = np.nan_to_num([self.zeros[number], self.drift])
        return _advance(run.value - zero - drift * run.time, _delay_steps(self.delay, run))


def find_instrument(runs: Sequence[InstrumentRun], minimum: float, max_delay: float = MAX_DELAY) -> Instrument:
    """Finds delay, zeros and drift; nothing touches where the estimate is below `minimum`."""
    steps, has_changes = range(int(max_delay / _period(runs[0])) + 1), max(np.nanstd(run.estimate) for run in runs) > 0
    costs = [sum(_line_misfit(run, step_count) for run in runs) for step_count in steps] if has_changes else [0.0]
    delay = _period(runs[0]) * int(np.argmin(costs))
    zeros, drift = _fit_zeros(runs, delay, minimum)
    return Instrument(delay, zeros, drift)


def _period(run: InstrumentRun) -> float:
    return float(run.time[1] - run.time[0]) if len(run.time) > 1 else np.inf


def _delay_steps(delay: float, run: InstrumentRun) -> int:
    return round(delay / _period(run))


def _advance(value: Array, steps: int) -> Array:
    """Values moved forward by `steps` samples; NaN at the end."""
    return np.append(value[steps:], np.full(min(steps, len(value)), np.nan))


def _line_misfit(run: InstrumentRun, steps: int) -> float:
    """Mean absolute residual of a line through the readings `steps` later, over the estimate."""
    value = _advance(run.value, steps)
    rows = np.flatnonzero(np.isfinite(value + run.estimate))
    rows = rows[:: max(1, len(rows) // _MAX_DELAY_SAMPLES)]
    if len(rows) < _MIN_ZERO_SAMPLES:
        return np.inf
    basis = np.column_stack([run.estimate[rows], np.ones(len(rows)), run.time[rows]])
    coefficients = np.linalg.lstsq(basis, value[rows], rcond=None)[0]
    return float(np.abs(value[rows] - basis @ coefficients).mean())


def _fit_zeros(runs: Sequence[InstrumentRun], delay: float, minimum: float) -> tuple[tuple[float, ...], float]:
    """Zeros and drift of the readings while nothing touches, by robust lines of one slope."""
    free_readings = [_free_readings(run, delay, minimum) for run in runs]
    usable_runs = [i for i, (time, _) in enumerate(free_readings) if len(time) >= _MIN_ZERO_SAMPLES]
    if not usable_runs:
        return (np.nan,) * len(runs), np.nan
    time, value = (np.concatenate([free_readings[i][field] for i in usable_runs]) for field in (0, 1))
    run_numbers = np.repeat(np.arange(len(usable_runs)), [len(free_readings[i][0]) for i in usable_runs])
    has_drift = max(np.ptp(free_readings[i][0]) for i in usable_runs) >= _MIN_DRIFT_SPAN
    basis = np.column_stack([run_numbers[:, None] == np.arange(len(usable_runs)), time * has_drift]).astype(float)
    weight, steps = np.ones(len(time)), np.diff(np.unique(value))
    resolution = float(steps.min()) if len(steps) else 0.0  # 0 if it never changes
    for _ in range(_LINE_ITERATIONS):
        coefficients = np.linalg.lstsq(basis * weight[:, None], value * weight, rcond=None)[0]
        residuals = np.abs(value - basis @ coefficients)
        max_residual = max(_HUBER_DEVIATIONS * _STD_PER_MEDIAN * float(np.median(residuals)), resolution, _MIN_RESIDUAL)
        weight = np.sqrt(max_residual / np.maximum(residuals, max_residual))
    zeros = dict(zip(usable_runs, coefficients.tolist(), strict=False))
    return tuple(zeros.get(i, np.nan) for i in range(len(runs))), float(coefficients[-1]) if has_drift else np.nan


def _free_readings(run: InstrumentRun, delay: float, minimum: float) -> tuple[Array, Array]:
    """Times and readings while nothing touches."""
    size, steps = np.abs(run.estimate), _delay_steps(delay, run)
    limit = max(minimum, _MAX_FREE_SHARE * float(np.nanpercentile(size, 95))) if np.isfinite(size).any() else minimum
    value = _advance(run.value, steps)
    free = run.rest & (size < limit) & np.isfinite(value)
    return run.time[free] + steps * _period(run), value[free]
