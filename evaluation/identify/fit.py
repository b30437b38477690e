"""Free parameters fitted to recordings: nonlinear least squares over simulations, in processes.

What is made small is the distance between markers measured and simulated, in parts of the largest displacement of their
recording, so that every recording counts alike. The times of a recording's events are unknown too and fitted with the
rest; of a recording that only tests a fit they are all that is fitted.
"""

from collections.abc import Callable, Sequence
from concurrent.futures import Future, ProcessPoolExecutor
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import least_squares

from soft_gripper.arrays import Array
from soft_gripper.errors import InputError, SimulationDivergedError
from soft_gripper.evaluation.identify.free_parameters import FreeParameters, Model
from soft_gripper.evaluation.identify.measured_motion import MeasuredMotion
from soft_gripper.evaluation.identify.simulated_motion import simulated_markers
from soft_gripper.evaluation.processes import submit_quietly

_OF_SCALE = 0.02  # by which a number is moved to see what it changes, in usual changes
_EVENT_SCALE = 0.01  # s
_OF_HAND, _OF_VALVE = 0.1, 0.05  # s, by which an event may be off from where it is seen
_TOLERANCE = 2e-4  # relative, of the sum of squares
_MOST_STEPS = 40
_IMPOSSIBLE = 10.0  # largest displacements, that a finger which cannot be, or diverges, is taken to be off by

Report = Callable[[float], None]


@dataclass(frozen=True)
class Fit:
    """What was found."""

    free: FreeParameters
    x: Array  # (P,) the vector of the free parameters
    motions: tuple[MeasuredMotion, ...]  # as fitted, with their events
    residuals: Array  # (R,)
    jacobian: Array  # (R, P) by the free parameters, with that of the events taken out

    @property
    def model(self) -> Model:
        """The fitted finger in its set-up."""
        return self.free.at(self.x)

    @property
    def root_mean_square(self) -> float:
        """Of the residuals, in parts of the largest displacements."""
        return _root_mean_square(self.residuals, len(self.motions))


def fit(
    free: FreeParameters,
    motions: Sequence[MeasuredMotion],
    pool: ProcessPoolExecutor,
    report: Report = lambda error: None,
    start: Array | None = None,
) -> Fit:
    """Fits free parameters, and the times of events, to recordings.

    Args:
        free: and where the fit begins.
        motions: of the recordings.
        pool: in which simulations run.
        report: called with the root mean square that every step has reached.
        start: vector of the free parameters to begin from; None: of the model as it is.

    Raises:
        InputError: if the fit does not converge.
    """
    problem = _Problem(free, tuple(motions), pool, report)
    x0 = np.concatenate([free.start if start is None else start, *(motion.events for motion in motions)])
    bounds = problem.bounds(x0)
    found = least_squares(
        problem.residuals,
        np.clip(x0, *bounds),
        problem.jacobian,
        bounds=bounds,
        x_scale=problem.scales,
        ftol=_TOLERANCE,
        xtol=_TOLERANCE,
        max_nfev=_MOST_STEPS,
    )
    of_free = len(free.start)
    if not found.success or not np.isfinite(found.cost) or _root_mean_square(found.fun, len(motions)) > 1:
        rms = f"{100 * _root_mean_square(found.fun, len(motions)):.3g} % of the largest displacement"
        expected = f"the fit does not converge in {_MOST_STEPS} steps: begin closer, or free fewer keys"
        raise InputError("identify", "residual", rms, expected)
    fitted = tuple(problem.with_events(found.x))
    of_events = found.jac[:, of_free:]
    seen = found.jac[:, :of_free]
    seen = seen - of_events @ np.linalg.lstsq(of_events, seen, rcond=None)[0]
    return Fit(free, found.x[:of_free], fitted, found.fun, seen)


def fit_events(model: Model, motion: MeasuredMotion) -> MeasuredMotion:
    """A recording with the events at which a model that is not fitted to it agrees best."""

    def residuals(events: Array) -> Array:
        return marker_residuals(model, motion.with_events(events))

    seen = np.array(motion.events)
    bounds = (seen - _event_range(motion), seen + _event_range(motion))
    step = _OF_SCALE * _EVENT_SCALE / np.maximum(np.abs(seen), _EVENT_SCALE)
    found = least_squares(
        residuals, seen, bounds=bounds, x_scale=_EVENT_SCALE, diff_step=step, ftol=_TOLERANCE, max_nfev=_MOST_STEPS
    )
    return motion.with_events(found.x)


def marker_residuals(model: Model, motion: MeasuredMotion) -> Array:
    """Markers simulated less measured, in parts of the largest displacement; 0 where none was seen.

    Their squares sum up to the mean square, so that a recording counts alike however long it is.
    """
    away = (simulated_markers(model.finger, model.setup, motion) - motion.markers) / motion.largest
    parts: Array = np.nan_to_num(away).ravel().view(float)
    return parts / np.sqrt(away.size)


def _residuals_or_impossible(model: Model | None, motion: MeasuredMotion) -> Array:
    """Those of a model; large ones where there can be no such finger, or it diverges."""
    try:
        if model is not None:
            return marker_residuals(model, motion)
    except (InputError, SimulationDivergedError):
        pass
    return np.full(2 * motion.markers.size, _IMPOSSIBLE / np.sqrt(motion.markers.size))


def _event_range(motion: MeasuredMotion) -> float:
    return _OF_HAND if motion.pressure is None else _OF_VALVE


def _root_mean_square(residuals: Array, recordings: int) -> float:
    return float(np.sqrt(np.sum(residuals**2) / recordings))


@dataclass(frozen=True)
class _Problem:
    """The least squares of a fit; a vector holds the free parameters and then the events of every recording."""

    free: FreeParameters
    motions: tuple[MeasuredMotion, ...]
    pool: ProcessPoolExecutor
    report: Report

    @property
    def scales(self) -> Array:
        events = sum(len(motion.events) for motion in self.motions)
        return np.concatenate([self.free.scales, np.full(events, _EVENT_SCALE)])

    def bounds(self, x0: Array) -> tuple[Array, Array]:
        """Events stay near where they are seen."""
        (lower, upper), events = self.free.bounds, x0[len(self.free.start) :]
        room = np.concatenate([np.full(len(motion.events), _event_range(motion)) for motion in self.motions])
        return np.concatenate([lower, events - room]), np.concatenate([upper, events + room])

    def events_of(self, i: int) -> NDArray[np.int_]:
        """Where in the vector the events of a recording are."""
        before = len(self.free.start) + sum(len(motion.events) for motion in self.motions[:i])
        return before + np.arange(len(self.motions[i].events))

    def with_events(self, x: Array) -> list[MeasuredMotion]:
        return [motion.with_events(x[self.events_of(i)]) for i, motion in enumerate(self.motions)]

    def residuals(self, x: Array) -> Array:
        return np.concatenate([future.result() for future in self._submit(x, range(len(self.motions)))])

    def jacobian(self, x: Array) -> Array:
        """By differences to one side; a recording's events change nothing of the others."""
        base = [future.result() for future in self._submit(x, range(len(self.motions)))]
        self.report(_root_mean_square(np.concatenate(base), len(base)))
        steps, everything = _OF_SCALE * self.scales, range(len(self.motions))
        owner = {column: i for i in everything for column in self.events_of(i)}
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
        motions = self.with_events(x)
        try:
            model = self.free.at(x[: len(self.free.start)])
        except InputError:
            model = None  # a step of the search may lead to what cannot be
        return [submit_quietly(self.pool, _residuals_or_impossible, model, motions[i]) for i in which]
