"""Tasks and the errors of sensors -> designs of sensors in space by their errors, the best of each number verified."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np

from soft_gripper.estimators.uncertainty import Uncertainty, uncertainty_of
from soft_gripper.extras.placement.catalogue import KINDS, PATHS, STRAIN, Design, divisions, errors_of
from soft_gripper.extras.placement.design_search import Paths, try_sets
from soft_gripper.extras.placement.samples import Assumptions
from soft_gripper.extras.placement.spatial_scores import Errors, Scores
from soft_gripper.extras.placement.spatial_tasks import Tasks
from soft_gripper.extras.placement.spatial_trials import made_errors
from soft_gripper.fingers.finger import Finger
from soft_gripper.scenario.schema import SensorConfig, StrainErrorsConfig
from soft_gripper.scenario.sensor_presets import strain_errors


@dataclass(frozen=True)
class SpatialAssumptions:
    """The errors of all kinds of sensors, and by how much the nominal stiffness is wrong."""

    preset: str | None = None  # of the errors of strain sensors; None: all kinds are ideal
    nominal_error: float = 0.0  # %, of Young's modulus, up and down
    seed: int = 1  # of what is random

    def errors(self, kind: str) -> StrainErrorsConfig | None:
        """Errors of sensors of a kind."""
        return errors_of(kind, self.preset)

    def uncertainty(self, kind: str) -> Uncertainty:
        """The sizes of these errors that the estimator assumes."""
        errors = strain_errors(SensorConfig(errors=self.errors(kind)))
        return uncertainty_of(errors, finger=self.nominal_error / 100)


@dataclass(frozen=True)
class Verified:
    """The best design of its kind with so many sensors."""

    design: Design
    predicted: Errors
    made: Errors  # in simulated statics


@dataclass(frozen=True, eq=False)
class PlacedInSpace:
    """The results of a search."""

    finger: Finger
    tried: Mapping[Design, Errors]  # as predicted
    best: list[Verified]  # by number of sensors; none that is worse than one with fewer sensors of its kind

    def best_of(self, kind: str) -> Verified:
        """The best design of a kind."""
        return min((one for one in self.best if one.design.kind == kind), key=lambda one: one.predicted.score)


def place_in_space(
    count: int, tasks: Tasks, assumptions: SpatialAssumptions, progress: Callable[[], Any] = lambda: None
) -> PlacedInSpace:
    """Tries designs of at most `count` sensors.

    Args:
        count: most sensors.
        tasks: by which they are scored.
        assumptions: errors of sensors and nominal finger.
        progress: called after every design that was tried, and every one that was verified.
    """
    tried: dict[Design, Errors] = {}
    for kind in KINDS:
        tried |= _tried(count, Scores(tasks, kind, assumptions.uncertainty(kind)), progress)
    best, finger = [], tasks.statics.finger
    nominal = Assumptions(nominal_error=assumptions.nominal_error).nominal(finger)
    for number, design in enumerate(best_designs(tried)):
        errors = strain_errors(SensorConfig(errors=assumptions.errors(design.kind)))
        rng, assumed = np.random.default_rng([assumptions.seed, number]), assumptions.uncertainty(design.kind)
        best.append(Verified(design, tried[design], made_errors(design, tasks, nominal, errors, assumed, rng)))
        progress()
    return PlacedInSpace(finger, tried, best)


def _tried(count: int, scores: Scores, progress: Callable[[], Any]) -> dict[Design, Errors]:
    """Designs of one kind."""
    finger, tried = scores.tasks.statics.finger, dict[Design, Errors]()

    def score(design: Design) -> float:
        tried[design] = scores(design)
        progress()
        return tried[design].score

    def of_paths(borders: tuple[float, ...], paths: Paths) -> float:
        return score(Design(STRAIN, borders, paths))

    for borders in divisions(finger, count):
        if scores.kind != STRAIN:
            score(Design(scores.kind, borders))
            continue
        most = count // (len(borders) + 1)
        try_sets(partial(of_paths, borders), list(PATHS), most)
    return tried


def best_designs(tried: Mapping[Design, Errors]) -> list[Design]:
    """The best of every kind and number of sensors, unless one with fewer sensors is as good."""
    best: list[Design] = []
    least = dict.fromkeys(KINDS, np.inf)
    for design in sorted(tried, key=lambda design: (design.sensors, tried[design].score, design)):
        if tried[design].score < least[design.kind]:
            least[design.kind] = tried[design].score
            best.append(design)
    return best
