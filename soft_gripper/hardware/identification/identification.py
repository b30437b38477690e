"""Recordings of hardware -> the parameters of a finger, their confidence, and their predictions."""

from collections.abc import Callable, Sequence
from concurrent.futures import Executor
from dataclasses import dataclass

import numpy as np

from soft_gripper.arrays import Array
from soft_gripper.errors import InputError
from soft_gripper.fingers.finger import Finger
from soft_gripper.hardware.identification.fit import Confidence, Fit, Report, confidence, fit, fit_events
from soft_gripper.hardware.identification.free_parameters import Model, free_parameters
from soft_gripper.hardware.identification.measured_motion import MeasuredMotion
from soft_gripper.hardware.identification.motion_scores import MotionScore, score

_JITTER = 2.0  # usual changes, standard deviation of where further fits begin


@dataclass(frozen=True)
class Identified:
    """What was found."""

    fit: Fit
    confidence: Confidence
    motions: tuple[MeasuredMotion, ...]  # those fitted to, then those that test, with their events
    scores: tuple[MotionScore, ...]  # of the same

    @property
    def model(self) -> Model:
        """The finger in its set-up."""
        return self.fit.model


def identify(
    finger: Finger,
    names: Sequence[str],
    fitted: Sequence[MeasuredMotion],
    tested: Sequence[MeasuredMotion],
    executor: Executor,
    starts: int = 1,
    seed: int = 0,
    report: Report = lambda error: None,
) -> Identified:
    """Fits keys of a finger to recordings and tests the result on others.

    Args:
        finger: where the fit begins.
        names: of the keys that are free, see `free_parameters`.
        fitted: recordings to fit to.
        tested: held-out recordings, of which only the times of their events are fitted.
        executor: runs the simulations.
        starts: number of fits, of which the best is kept; the first begins with the finger, the others near it.
        seed: of the random starts.
        report: called with the root mean square that every step has reached, relative to the largest displacement.

    Raises:
        InputError: if a key cannot be fitted, or no fit converges.
    """
    pressures = [motion.pressure for motion in fitted if motion.pressure is not None]
    free = free_parameters(finger, names, pressures)
    jitter = np.random.default_rng(seed).normal(size=(starts, len(free.start))) * _JITTER * free.scales
    jitter[0] = 0.0
    best = _best(lambda away: fit(free, fitted, executor, report, free.start + away), list(jitter))
    calls = [(best.model, motion, "fit") for motion in best.motions] + [(best.model, m, "test") for m in tested]
    scored = [future.result() for future in [executor.submit(_score, *call) for call in calls]]
    return Identified(best, confidence(best), *(tuple(column) for column in zip(*scored, strict=True)))


def _best(fit_from: Callable[[Array], Fit], starts: Sequence[Array]) -> Fit:
    """The best of the fits that converge, from any of the starts."""
    fits = []
    for start in starts:
        try:
            fits.append(fit_from(start))
        except InputError as error:
            last = error
    if not fits:
        raise last
    return min(fits, key=lambda found: found.root_mean_square)


def _score(model: Model, motion: MeasuredMotion, role: str) -> tuple[MeasuredMotion, MotionScore]:
    timed = fit_events(model, motion) if role == "test" else motion
    return timed, score(model, timed, role)
