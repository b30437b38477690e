"""Free parameters fitted to recordings: nonlinear least squares over simulations, in processes.

The fit minimises the distance between measured and simulated markers, relative to the largest displacement of their
recording, so that all recordings have equal weight. Half a second after a chamber was emptied, samples weigh more: no
pressure, which was not recorded, hides the creep of the material there. The times of a recording's events are also
unknown and fitted with the rest; for a held-out recording, nothing else is fitted.
"""

from collections.abc import Callable, Sequence
from concurrent.futures import Executor, Future
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import least_squares
from scipy.signal import find_peaks

from soft_gripper.arrays import Array, Planar
from soft_gripper.errors import InputError, SimulationDivergedError
from soft_gripper.extras.hardware.identification.confidence import Confidence, confidence_of, correlation_time
from soft_gripper.extras.hardware.identification.free_parameters import FreeParameters, Model
from soft_gripper.extras.hardware.identification.simulated_motion import (
    SETTLED_TIME,
    MeasuredMotion,
    settled,
    simulated_markers,
    turned,
)
from soft_gripper.files.document import require
from soft_gripper.fingers.kinematics import as_points

_DIFFERENCE_STEP = 0.02  # step of the finite differences, in typical changes
_UNKNOWN_SCALES = (0.01, 0.01, 1e-3, 0.01)  # s, s, m, rad: typical changes of what was not recorded
_OF_HAND, _OF_VALVE = 0.1, 0.05  # s, maximum difference of an event from its detected time
_MOST_SAG, _MOST_TURN = 0.2, 0.1  # of the largest displacement, and rad: from straight, as a hand holds the tip
_TOLERANCE = 1e-3  # relative, of the sum of squares
_MOST_STEPS = 40
_CREEP_BEGIN = 0.5  # s after an event, after which further motion counts as creep
_EMPTIED_WEIGHT = 4.0  # weight of a sample of creep without pressure
_IMPOSSIBLE_ERROR = 10.0  # largest displacements: the error assigned to an impossible or diverging finger


class Progress(NamedTuple):
    """A search, after a step."""

    step: int
    error: float  # root mean square of the markers' errors, relative to the largest displacement, or to the length
    model: Model
    unbalanced: int = 0  # markers in rows in which the finger finds no balance, which do not count in the error


Report = Callable[[Progress], None]


@dataclass(frozen=True)
class Fit:
    """The result."""

    free: FreeParameters
    x: Array  # (P,) the vector of the free parameters
    motions: tuple[MeasuredMotion, ...]  # as fitted, with their events
    residuals: Array  # (R,) weighted
    jacobian: Array  # (R, P) of these by the free parameters, with the events projected out
    weights: Array | float = 1.0  # (R,)
    converged: bool = True

    @property
    def model(self) -> Model:
        """The fitted finger in its set-up."""
        return self.free.at(self.x)

    @property
    def root_mean_square(self) -> float:
        """Root mean square of the residuals without their weights, relative to the largest displacements."""
        return _root_mean_square(self.residuals / self.weights, len(self.motions))


def fit(
    free: FreeParameters,
    motions: Sequence[MeasuredMotion],
    executor: Executor,
    report: Report = lambda progress: None,
    start: Array | None = None,
) -> Fit:
    """Fits free parameters, and the times of events, to recordings.

    Args:
        free: the free parameters, with their initial values.
        motions: motions of the recordings.
        executor: runs the simulations.
        report: called after each step.
        start: initial vector of the free parameters; None: that of the given model.

    Raises:
        InputError: if the result comes nowhere near the markers.
    """
    problem = _Problem(free, tuple(motions), executor, report)
    x0 = np.concatenate([free.start if start is None else start, *(motion.unknowns for motion in motions)])
    bounds, weights = problem.bounds(x0), np.concatenate([*map(_weights, motions)])
    found = least_squares(
        lambda x: weights * problem.residuals(x),
        np.clip(x0, *bounds),
        lambda x: weights[:, None] * problem.jacobian(x),
        bounds=bounds,
        x_scale=problem.scales,
        ftol=_TOLERANCE,
        max_nfev=_MOST_STEPS,
    )
    of_free = len(free.start)
    error = _root_mean_square(found.fun / weights, len(motions))
    rms = f"{100 * error:.3g} % of the largest displacement"
    expected = "the fit found no finger that comes near the markers: start closer, or free fewer keys"
    require(bool(np.isfinite(found.cost)) and error <= 1, "identify", "residual", rms, expected)
    fitted = tuple(problem.with_unknowns(found.x))
    of_unknowns = found.jac[:, of_free:]
    seen = found.jac[:, :of_free]
    seen = seen - of_unknowns @ np.linalg.lstsq(of_unknowns, seen, rcond=None)[0]
    return Fit(free, found.x[:of_free], fitted, found.fun, seen, weights, bool(found.success))


def fit_unknowns(model: Model, motion: MeasuredMotion) -> MeasuredMotion:
    """A recording with the events, and held sag, at which a model that was not fitted to it agrees best."""

    def residuals(values: Array) -> Array:
        return marker_residuals(model, motion.with_unknowns(values))

    seen, scales = motion.unknowns, _scales(motion)
    found = least_squares(
        residuals,
        seen,
        bounds=(seen - _room(motion), seen + _room(motion)),
        x_scale=scales,
        diff_step=_DIFFERENCE_STEP * scales / np.maximum(np.abs(seen), scales),
        ftol=_TOLERANCE,
        max_nfev=_MOST_STEPS,
    )
    return motion.with_unknowns(found.x)


def _scales(motion: MeasuredMotion) -> Array:
    """Typical changes of what was not recorded."""
    return np.array(_UNKNOWN_SCALES[: len(motion.unknowns)])


def _room(motion: MeasuredMotion) -> Array:
    """How far what was not recorded may be from its first guess."""
    event = _OF_HAND if motion.pressure is None else _OF_VALVE
    return np.array([event, event, _MOST_SAG * motion.largest, _MOST_TURN][: len(motion.unknowns)])


def marker_residuals(model: Model, motion: MeasuredMotion) -> Array:
    """Simulated minus measured markers, relative to the largest displacement; 0 if a marker was not seen.

    Their squares add up to the mean square, so that the weight of a recording does not depend on its length.
    """
    away = (simulated_markers(model.finger, model.setup, motion) - motion.markers) / motion.largest
    parts: Array = np.nan_to_num(away).ravel().view(float)
    return parts / np.sqrt(away.size)


def _weights(motion: MeasuredMotion) -> Array:
    """Weights of the residuals of a motion, by the times of its events as they were detected."""
    emptied = (motion.pressure is not None) & (motion.time > motion.events[1] + _CREEP_BEGIN)
    return np.repeat(np.where(emptied, _EMPTIED_WEIGHT, 1.0), 2 * motion.markers.shape[1])


def _residuals_or_impossible(model: Model | None, motion: MeasuredMotion) -> Array:
    """Residuals of a model; large ones if the finger is impossible or diverges."""
    try:
        if model is not None:
            return marker_residuals(model, motion)
    except (InputError, SimulationDivergedError):
        pass
    return np.full(2 * motion.markers.size, _IMPOSSIBLE_ERROR / np.sqrt(motion.markers.size))


def _root_mean_square(residuals: Array, recordings: int) -> float:
    return float(np.sqrt(np.sum(residuals**2) / recordings))


@dataclass
class _Problem:
    """The least squares of a fit; a vector holds the free parameters and then the events of every recording."""

    free: FreeParameters
    motions: tuple[MeasuredMotion, ...]
    executor: Executor
    report: Report
    step: int = 0  # how many Jacobians were computed

    @property
    def scales(self) -> Array:
        return np.concatenate([self.free.scales, *map(_scales, self.motions)])

    def bounds(self, x0: Array) -> tuple[Array, Array]:
        """Events stay close to their detected times, and the held finger close to straight."""
        (lower, upper), unknowns = self.free.bounds, x0[len(self.free.start) :]
        room = np.concatenate([_room(motion) for motion in self.motions])
        return np.concatenate([lower, unknowns - room]), np.concatenate([upper, unknowns + room])

    def unknowns_of(self, i: int) -> NDArray[np.int_]:
        """The indices in the vector of what was not recorded of a motion."""
        before = len(self.free.start) + sum(len(motion.unknowns) for motion in self.motions[:i])
        return before + np.arange(len(self.motions[i].unknowns))

    def with_unknowns(self, x: Array) -> list[MeasuredMotion]:
        return [motion.with_unknowns(x[self.unknowns_of(i)]) for i, motion in enumerate(self.motions)]

    def residuals(self, x: Array) -> Array:
        return np.concatenate([future.result() for future in self._submit(x, range(len(self.motions)))])

    def jacobian(self, x: Array) -> Array:
        """By one-sided differences; the unknowns of a recording do not affect other recordings."""
        base = [future.result() for future in self._submit(x, range(len(self.motions)))]
        self.step += 1
        of_free = x[: len(self.free.start)]
        error = _root_mean_square(np.concatenate(base), len(base))
        self.report(Progress(self.step, error, self.free.at(of_free)))
        steps, everything = _DIFFERENCE_STEP * self.scales, range(len(self.motions))
        steps[: len(of_free)] = self.free.steps(of_free, _DIFFERENCE_STEP)
        owner = {column: i for i in everything for column in self.unknowns_of(i)}
        pending = {}
        for column, step in enumerate(steps):
            moved = x.copy()
            moved[column] += step
            concerned = [owner[column]] if column in owner else list(everything)
            for i, future in zip(concerned, self._submit(moved, concerned), strict=True):
                pending[column, i] = future
        rows = np.concatenate([[0], np.cumsum([len(part) for part in base])])
        jacobian = np.zeros((rows[-1], len(x)))
        for (column, i), future in pending.items():
            jacobian[rows[i] : rows[i + 1], column] = (future.result() - base[i]) / steps[column]
        return jacobian

    def _submit(self, x: Array, which: Sequence[int]) -> list["Future[Array]"]:
        motions = self.with_unknowns(x)
        try:
            model = self.free.at(x[: len(self.free.start)])
        except InputError:
            model = None  # a step of the search may lead to an impossible finger
        return [self.executor.submit(_residuals_or_impossible, model, motions[i]) for i in which]


def confidence(fit: Fit) -> Confidence:
    """Confidence in a fit to motions."""
    return confidence_of(fit.free, fit.x, fit.residuals, fit.jacobian, _lasting(fit))


def _lasting(fit: Fit) -> float:
    """Mean correlation time of the residuals of the recordings, in samples, at least 1."""
    lasting, begin = [], 0
    for motion in fit.motions:
        samples, markers = motion.markers.shape
        part = fit.residuals[begin : begin + 2 * samples * markers].reshape(samples, -1)
        begin += part.size
        lasting += [correlation_time(column) for column in part.T if np.ptp(column) > 0]
    return float(np.mean(lasting)) if lasting else 1.0


_SHARES = (0.5, 0.63)  # of the settled turn, whose times say how fast a finger rises
_MEAN_HALF_WIDTH = 0.1  # s on either side, over which that is averaged
_EXTREMA = 9  # maximum number of maxima and minima used for frequency and decrement
_LEAST_PROMINENCE = 0.04  # share of the settled displacement: smallest prominence of one of them


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
    t50_ms: float  # from the event to half the settled turn
    simulated_t50_ms: float
    t63_ms: float  # to 63 % of it
    simulated_t63_ms: float
    frequency_hz: float
    simulated_frequency_hz: float
    decrement: float  # logarithmic
    simulated_decrement: float


@dataclass(frozen=True)
class Turn:
    """Characteristics of the rotation of a tip."""

    settled: float  # rad
    creep: float  # rad
    recovery: float  # rad
    t50: float  # s
    t63: float  # s
    frequency: float  # Hz, NaN without oscillation
    decrement: float

    def columns(self, prefix: str = "") -> dict[str, float]:
        """These as columns of a `MotionScore`, in their units; names begin with the prefix."""
        numbers = {
            "settled_turn_deg": float(np.degrees(self.settled)),
            "creep_deg": float(np.degrees(self.creep)),
            "recovery_deg": float(np.degrees(self.recovery)),
            "t50_ms": 1e3 * self.t50,
            "t63_ms": 1e3 * self.t63,
            "frequency_hz": self.frequency,
            "decrement": self.decrement,
        }
        return {f"{prefix}{name}": number for name, number in numbers.items()}


def score(model: Model, motion: MeasuredMotion, role: str) -> MotionScore:
    """Compares a recording, with its fitted events, to the simulation."""
    simulated = simulated_markers(model.finger, model.setup, motion)
    off, moving = np.abs(simulated - motion.markers), motion.time >= motion.events[0]
    middle = np.abs(np.nanmean(simulated - motion.markers, axis=1))[moving]
    places = [settled(motion.time, markers, motion.end) for markers in (simulated, motion.markers)]
    return MotionScore(
        recording=motion.name,
        role=role,
        settled_error_mm=1e3 * float(np.nanmean(np.abs(places[0] - places[1]))),
        motion_error_mm=1e3 * float(np.nanmean(off[moving])),
        tip_error_percent=100 * float(np.nanmax(middle)) / model.finger.length,
        **tip_turn(motion, motion.markers).columns(),
        **tip_turn(motion, simulated).columns("simulated_"),
    )


def tip_turn(motion: MeasuredMotion, markers: Planar) -> Turn:
    """Characteristics of the rotation of markers, measured or simulated, from a recording's first event to its end."""
    turn, time = turned(markers, motion.reference), motion.time - motion.events[0]
    end = motion.end - motion.events[0]
    late = float(settled(time, turn, end))
    emptied = np.nan
    if motion.pressure is not None and time[-1] - end > _CREEP_BEGIN + _MEAN_HALF_WIDTH + SETTLED_TIME:
        emptied = _early(time - end, turn) - float(settled(time, turn, time[-1]))
    half, most = (_first(time[time >= 0], np.abs(turn[time >= 0]), share * abs(late)) for share in _SHARES)
    frequency, decrement = _swing(time, _along(motion, markers), end)
    return Turn(late, late - _early(time, turn), emptied, half, most, frequency, decrement)


def _early(time: Array, turn: Array) -> float:
    """A rotation half a second after time 0, mean of some samples around it."""
    return float(np.nanmean(turn[np.abs(time - _CREEP_BEGIN) <= _MEAN_HALF_WIDTH]))


def _first(time: Array, turn: Array, level: float) -> float:
    """The time, s, at which a rotation first reaches a level, interpolated between samples."""
    above = np.flatnonzero(turn >= level)
    if not len(above) or above[0] == 0:
        return float(time[0]) if len(above) else np.nan
    k = above[0]
    part = (level - turn[k - 1]) / (turn[k] - turn[k - 1])
    return float(time[k - 1] + part * (time[k] - time[k - 1]))


def _along(motion: MeasuredMotion, markers: Planar) -> Array:
    """How far the middle of markers is displaced in the direction in which it settles, of that distance, (T,)."""
    away = np.mean(markers - motion.reference, axis=1)
    rests = as_points(settled(motion.time, away, motion.end))
    along: Array = as_points(away) @ rests / (rests @ rests)
    return along


def _swing(time: Array, along: Array, end: float) -> tuple[float, float]:
    """Frequency, Hz, and logarithmic decrement, from peak to peak: a middle that drifts matters little."""
    swing = np.nan_to_num(along[(time >= 0) & (time <= end)])
    extrema = np.sort(np.concatenate([find_peaks(side, prominence=_LEAST_PROMINENCE)[0] for side in (swing, -swing)]))
    extrema = extrema[:_EXTREMA]
    if len(extrema) < 4:
        return np.nan, np.nan
    refined = np.array([_vertex(swing[k - 1 : k + 2]) for k in extrema])
    moments = (extrema + refined[:, 0]) * np.median(np.diff(time))
    from_peak_to_peak = np.log(np.abs(np.diff(refined[:, 1])))
    half = float(np.polyfit(np.arange(len(extrema)), moments, 1)[0])
    decay = -float(np.polyfit(np.arange(len(extrema) - 1), from_peak_to_peak, 1)[0])
    return 1 / (2 * half), 2 * decay


def _vertex(three: Array) -> tuple[float, float]:
    """Vertex of the parabola through three samples: offset from the middle one, in samples, and height."""
    before, at, after = three
    curvature = before - 2 * at + after
    shift = 0.0 if curvature == 0 else 0.5 * (before - after) / curvature
    return float(shift), float(at - 0.25 * (before - after) * shift)
