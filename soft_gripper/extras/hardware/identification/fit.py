"""Free parameters fitted to recordings: nonlinear least squares over simulations, in processes.

The fit minimises the distance between measured and simulated markers, relative to the largest displacement of their
recording, so that all recordings have equal weight. Half a second after a chamber was emptied, samples weigh more: no
pressure, which was not recorded, hides the creep of the material there. The times of a recording's events are also
unknown and fitted with the rest; for a held-out recording, nothing else is fitted.
"""

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.signal import find_peaks

from soft_gripper.arrays import Array, Planar
from soft_gripper.errors import InputError, SimulationDivergedError
from soft_gripper.extras.hardware.identification.confidence import (
    Confidence,
    confidence_of,
    mean_correlation_time,
    square_root,
)
from soft_gripper.extras.hardware.identification.free_parameters import FingerFit, FreeParameters, Model
from soft_gripper.extras.hardware.identification.simulated_motion import (
    SETTLED_TIME,
    MeasuredMotion,
    marker_rotation,
    settled_mean,
    simulated_markers,
)
from soft_gripper.extras.hardware.least_squares import Problem, Report, no_report
from soft_gripper.extras.hardware.least_squares import fit as solve
from soft_gripper.fingers.kinematics import as_points

_DIFFERENCE_STEP = 0.02  # step of the finite differences, in typical changes
_UNKNOWN_SCALES = (0.01, 0.01, 1e-3, 0.01)  # s, s, m, rad: typical changes of what was not recorded
_MAX_HAND_SHIFT, _MAX_VALVE_SHIFT = 0.1, 0.05  # s, maximum difference of an event from its detected time
_MAX_SAG_SHARE, _MAX_TURN = 0.2, 0.1  # of the largest displacement, and rad: from straight, as a hand holds the tip
_TOLERANCE = 1e-3  # relative, of the sum of squares
_MAX_STEPS = 40
_CREEP_DELAY = 0.5  # s after an event, after which further motion counts as creep
_EMPTIED_WEIGHT = 4.0  # weight of a sample of creep without pressure
_IMPOSSIBLE_ERROR = 10.0  # largest displacements: the error assigned to an impossible or diverging finger
Run = Callable[..., Iterable[Array]]


def fit(
    free: FreeParameters,
    motions: Sequence[MeasuredMotion],
    run: Run,
    report: Report = no_report,
    starts: ArrayLike | None = None,
) -> FingerFit[MeasuredMotion]:
    """Fits free parameters, and the times of events, to recordings.

    `run` calls a function with every pair of a model and a motion, as `map` does, or that of an executor. `starts` are
    initial vectors, (K, P); None: that of the given model.
    """
    motions, key_count = tuple(motions), len(free.start)
    unknowns = np.concatenate([motion.unknowns for motion in motions])
    unknown_columns = np.split(
        np.arange(len(unknowns)) + key_count, np.cumsum([len(motion.unknowns) for motion in motions])[:-1]
    )
    scales, room = (np.concatenate([*map(values, motions)]) for values in (_unknown_scales, _unknown_room))
    lower, upper = free.bounds

    def build_model(x: Array) -> Model:
        return free.build_model(x[:key_count])

    def with_unknowns(x: Array) -> tuple[MeasuredMotion, ...]:
        return tuple(motion.with_unknowns(x[columns]) for motion, columns in zip(motions, unknown_columns, strict=True))

    def possible_model(x: Array) -> Model | None:
        try:
            return build_model(x)
        except InputError:  # a step of the search may lead to an impossible finger
            return None

    def residuals(x: Array) -> Array:
        return np.concatenate([*run(_residuals_or_impossible, [possible_model(x)] * len(motions), with_unknowns(x))])

    def slopes(x: Array, residuals: Array) -> Array:
        """Slopes by one-sided differences; the unknowns of a recording do not affect other recordings."""
        steps = np.concatenate([free.steps(x[:key_count], _DIFFERENCE_STEP), _DIFFERENCE_STEP * scales])
        points = x + np.diag(steps)
        calls = [(column, i) for column in range(key_count) for i in range(len(motions))]
        calls += [(column, i) for i, columns in enumerate(unknown_columns) for column in columns.tolist()]
        models, motions_ = [*map(possible_model, points)], [*map(with_unknowns, points)]
        results = run(_residuals_or_impossible, [models[c] for c, _ in calls], [motions_[c][i] for c, i in calls])
        ends = np.cumsum([2 * motion.markers.size for motion in motions])
        rows = np.split(np.arange(len(residuals)), ends[:-1])
        jacobian = np.zeros((len(residuals), len(x)))
        for (column, i), result in zip(calls, results, strict=True):
            jacobian[rows[i], column] = (result - residuals[rows[i]]) / steps[column]
        return jacobian

    problem = Problem(
        build_model,
        residuals,
        slopes,
        weights=np.concatenate([*map(_weights, motions)]),
        bounds=(np.append(lower, unknowns - room), np.append(upper, unknowns + room)),
        error=(lambda residuals: float(np.sqrt(np.sum(residuals**2) / len(motions)))) if key_count else None,
        options={"x_scale": np.append(free.scales, scales), "ftol": _TOLERANCE, "max_nfev": _MAX_STEPS},
    )
    begin = np.atleast_2d(free.start if starts is None else starts)
    solution = solve(problem, np.column_stack([begin, np.tile(unknowns, (len(begin), 1))]), report)
    return FingerFit(**vars(solution.profile(key_count)), free=free, recordings=with_unknowns(solution.x))


def fit_unknowns(model: Model, motion: MeasuredMotion) -> MeasuredMotion:
    """A recording with the events, and held sag, at which a model that was not fitted to it agrees best."""
    return fit(FreeParameters(model, {}), [motion], map).recordings[0]


def _unknown_scales(motion: MeasuredMotion) -> Array:
    """Typical changes of the unknowns."""
    return np.array(_UNKNOWN_SCALES[: len(motion.unknowns)])


def _unknown_room(motion: MeasuredMotion) -> Array:
    """Ranges of the unknowns about their first guess: events are near, and the held finger is straight."""
    event = _MAX_HAND_SHIFT if motion.pressure is None else _MAX_VALVE_SHIFT
    return np.array([event, event, _MAX_SAG_SHARE * motion.largest, _MAX_TURN][: len(motion.unknowns)])


def marker_residuals(model: Model, motion: MeasuredMotion) -> Array:
    """Simulated minus measured markers over the largest displacement; 0 where a marker was not seen.

    Their squares add up to the mean square, so that the weight of a recording does not depend on its length.
    """
    errors = (simulated_markers(model.finger, model.setup, motion) - motion.markers) / motion.largest
    components: Array = np.nan_to_num(errors).ravel().view(float)
    return components / np.sqrt(errors.size)


def _weights(motion: MeasuredMotion) -> Array:
    """Weights of the residuals of a motion, by the detected times of its events."""
    is_emptied = (motion.pressure is not None) & (motion.time > motion.events[1] + _CREEP_DELAY)
    return np.repeat(np.where(is_emptied, _EMPTIED_WEIGHT, 1.0), 2 * motion.markers.shape[1])


def _residuals_or_impossible(model: Model | None, motion: MeasuredMotion) -> Array:
    """Residuals of a model; large ones if the finger is impossible or diverges."""
    try:
        if model is not None:
            return marker_residuals(model, motion)
    except (InputError, SimulationDivergedError):
        pass
    return np.full(2 * motion.markers.size, _IMPOSSIBLE_ERROR / np.sqrt(motion.markers.size))


def fit_confidence(fit: FingerFit[MeasuredMotion], kept: NDArray[np.bool_] | None = None) -> Confidence:
    """Confidence in a fit to motions; with `kept`, (R,), to first order that in a fit to these residuals."""
    residuals, slopes = fit.weights * fit.residuals, fit.weights[:, None] * fit.slopes
    ends = np.cumsum([2 * motion.markers.size for motion in fit.recordings])
    pairs = zip(np.split(residuals, ends[:-1]), fit.recordings, strict=True)
    correlated_samples = mean_correlation_time([rows.reshape(len(motion.time), -1) for rows, motion in pairs])
    rows_used = slice(None) if kept is None else kept
    return confidence_of(fit.free, fit.x, residuals[rows_used], slopes[rows_used], correlated_samples)


def marker_deviations(free: FreeParameters, covariance: Array, motion: MeasuredMotion, run: Run = map) -> Planar:
    """Deviations z + i x of the markers of a recording, whose unknowns follow the keys, (P, T, M) m.

    They are one standard deviation of each of P independent unknowns, by the covariance of the keys, (P, P).
    """
    key_steps = np.diag(free.steps(free.start, _DIFFERENCE_STEP))
    unknown_steps = _DIFFERENCE_STEP * np.diag(_unknown_scales(motion))
    calls = [(free.model, motion), *((free.build_model(free.start + step), motion) for step in key_steps)]
    calls += [(free.model, motion.with_unknowns(motion.unknowns + step)) for step in unknown_steps]
    markers, *changed_markers = run(motion_markers, *zip(*calls, strict=True))
    sizes = np.concatenate([key_steps.sum(axis=1), unknown_steps.sum(axis=1)])
    derivatives = [(shifted - markers) / size for shifted, size in zip(changed_markers, sizes, strict=True)]
    slopes = np.stack([values.ravel().view(float) for values in derivatives], axis=-1)
    keys, unknowns = np.split(slopes, [len(key_steps)], axis=1)
    keys = keys - unknowns @ np.linalg.lstsq(unknowns, keys, rcond=None)[0]
    deviations: Planar = np.ascontiguousarray((keys @ square_root(covariance)).T).view(complex)
    return deviations.reshape(-1, *markers.shape)


def motion_markers(model: Model, motion: MeasuredMotion) -> Planar:
    """Simulated markers of a recording, (T, M) m."""
    return simulated_markers(model.finger, model.setup, motion)


_RISE_SHARES = (0.5, 0.63)  # of the settled turn: the times below them say how fast a finger rises
_MEAN_HALF_WIDTH = 0.1  # s on either side, over which that is averaged
_MAX_EXTREMA = 9  # maximum number of maxima and minima used for frequency and decrement
_MIN_PROMINENCE = 0.04  # share of the settled displacement: smallest prominence of one of them


UNHELD = "test, hold unknown"  # role of a recording that is tested, with a hand that is taken to hold straight


@dataclass(frozen=True)
class MotionScore:
    """A row of the table: one recording, measured and simulated."""

    recording: str
    role: str  # FITTED, TESTED, or UNHELD
    settled_error_mm: float  # of the markers, mean
    motion_error_mm: float  # of the markers, mean over the whole motion
    tip_error_percent: float  # largest error of the marker centre, relative to the finger length
    settled_turn_deg: float
    simulated_settled_turn_deg: float
    creep_deg: float  # from half a second after the event to the settled turn
    simulated_creep_deg: float
    recovery_deg: float  # from half a second after the valve closes to the end; NaN: no valve, or it ends too soon
    simulated_recovery_deg: float
    t50_ms: float  # for which the turn is below half the settled one, see `_time_below`
    simulated_t50_ms: float
    t63_ms: float  # below 63 % of it
    simulated_t63_ms: float
    frequency_hz: float
    simulated_frequency_hz: float
    decrement: float  # logarithmic
    simulated_decrement: float


@dataclass(frozen=True)
class TurnResponse:
    """Characteristics of the rotation of a tip."""

    settled: float  # rad
    creep: float  # rad
    recovery: float  # rad
    t50: float  # s
    t63: float  # s
    frequency: float  # Hz, NaN without oscillation
    decrement: float

    def columns(self, prefix: str = "") -> dict[str, float]:
        """Columns of a `MotionScore`, in their units; names begin with the prefix."""
        numbers = {
            "settled_turn_deg": float(np.degrees(self.settled)),
            "creep_deg": float(np.degrees(self.creep)),
            "recovery_deg": float(np.degrees(self.recovery)),
            "t50_ms": 1e3 * self.t50,
            "t63_ms": 1e3 * self.t63,
            "frequency_hz": self.frequency,
            "decrement": self.decrement,
        }
        return {f"{prefix}{name}": value for name, value in numbers.items()}


def score(model: Model, motion: MeasuredMotion, role: str) -> MotionScore:
    """Compares a recording, with its fitted events, to the simulation."""
    simulated = simulated_markers(model.finger, model.setup, motion)
    errors, is_moving = simulated - motion.markers, motion.time >= motion.events[0]
    simulated_rest, rest = (settled_mean(motion.time, markers, motion.end) for markers in (simulated, motion.markers))
    return MotionScore(
        recording=motion.name,
        role=role,
        settled_error_mm=1e3 * float(np.nanmean(np.abs(simulated_rest - rest))),
        motion_error_mm=1e3 * float(np.nanmean(np.abs(errors)[is_moving])),
        tip_error_percent=100 * float(np.nanmax(np.abs(np.nanmean(errors, axis=1))[is_moving])) / model.finger.length,
        **turn_response(motion, motion.markers).columns(),
        **turn_response(motion, simulated).columns("simulated_"),
    )


def turn_response(motion: MeasuredMotion, markers: Planar) -> TurnResponse:
    """Characteristics of the rotation of markers, measured or simulated, from a recording's first event to its end."""
    rotation, time = marker_rotation(markers, motion.reference), motion.time - motion.events[0]
    end = motion.end - motion.events[0]
    settled = float(settled_mean(time, rotation, end))
    recovery = np.nan
    if motion.pressure is not None and time[-1] - end > _CREEP_DELAY + _MEAN_HALF_WIDTH + SETTLED_TIME:
        recovery = _early_rotation(time - end, rotation) - float(settled_mean(time, rotation, time[-1]))
    is_open = (time >= 0) & (time <= end)
    t50, t63 = (_time_below(time[is_open], np.abs(rotation[is_open]), share * abs(settled)) for share in _RISE_SHARES)
    frequency, decrement = _swing(time, _settling_share(motion, markers), end)
    return TurnResponse(settled, settled - _early_rotation(time, rotation), recovery, t50, t63, frequency, decrement)


def _early_rotation(time: Array, rotation: Array) -> float:
    """Mean rotation, rad, of the samples about half a second after time 0."""
    return float(np.nanmean(rotation[np.abs(time - _CREEP_DELAY) <= _MEAN_HALF_WIDTH]))


def _time_below(time: Array, rotation: Array, level: float) -> float:
    """Time, s, for which a rotation is below a level, linear between samples; NaN if it never reaches the level.

    Without a swing it is the time at which the level is reached. Where a swing only just crosses the level, that is a
    matter of luck: whether it is by a little jumps by a period, this does not.
    """
    is_seen = np.isfinite(rotation)
    time, excess = time[is_seen], rotation[is_seen] - level
    if not (excess >= 0).any():
        return np.nan
    higher, lower = np.maximum(excess[1:], excess[:-1]), np.minimum(excess[1:], excess[:-1])
    fractions = np.clip(np.divide(-lower, higher - lower, out=(lower < 0) * 1.0, where=higher > lower), 0, 1)
    return float(time[0] + fractions @ np.diff(time))


def _settling_share(motion: MeasuredMotion, markers: Planar) -> Array:
    """Displacement of the middle of markers in the direction in which it settles, over that distance, (T,)."""
    shifts = np.mean(markers - motion.reference, axis=1)
    settled_shift = as_points(settled_mean(motion.time, shifts, motion.end))
    return as_points(shifts) @ settled_shift / (settled_shift @ settled_shift)


def _swing(time: Array, displacement: Array, end: float) -> tuple[float, float]:
    """Frequency, Hz, and logarithmic decrement, from peak to peak: a middle that drifts matters little."""
    swing = np.nan_to_num(displacement[(time >= 0) & (time <= end)])
    extrema = np.sort(np.concatenate([find_peaks(side, prominence=_MIN_PROMINENCE)[0] for side in (swing, -swing)]))
    extrema = extrema[:_MAX_EXTREMA]
    if len(extrema) < 4:
        return np.nan, np.nan
    vertices = np.array([_vertex(swing[i - 1 : i + 2]) for i in extrema])
    instants = (extrema + vertices[:, 0]) * np.median(np.diff(time))
    amplitudes = np.log(np.abs(np.diff(vertices[:, 1])))
    half_period = float(np.polyfit(np.arange(len(extrema)), instants, 1)[0])
    decay = -float(np.polyfit(np.arange(len(extrema) - 1), amplitudes, 1)[0])
    return 1 / (2 * half_period), 2 * decay


def _vertex(samples: Array) -> tuple[float, float]:
    """Vertex of the parabola through three samples: offset from the middle one, in samples, and height."""
    first, middle, last = samples
    curvature = first - 2 * middle + last
    offset = 0.0 if curvature == 0 else 0.5 * (first - last) / curvature
    return float(offset), float(middle - 0.25 * (first - last) * offset)
