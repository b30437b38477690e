"""What placed sensors gain in runs by which they were not placed: each is left out in turn."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from soft_gripper.arrays import Array
from soft_gripper.evaluation.placement.placements import Placement
from soft_gripper.evaluation.placement.search import ranked


@dataclass(frozen=True)
class LeftOut:
    """A run, and sensors that were placed by the others alone."""

    run: str
    placement: Placement
    equal: float  # m, mean pose error with equal sections
    placed: float  # m, with the placement


def leave_one_out(
    errors: Callable[[Placement], Array], runs: Sequence[str], segments: int, equal: Placement
) -> list[LeftOut]:
    """One for every run; with a single run there are no others to place by, and none.

    `errors` are mean pose errors of a placement in all runs, (R) m.
    """
    if len(runs) < 2:
        return []
    left_out = []
    for i, run in enumerate(runs):
        best = best_placement(errors, np.arange(len(runs)) != i, segments, equal)
        left_out.append(LeftOut(run, best, float(errors(equal)[i]), float(errors(best)[i])))
    return left_out


def best_placement(
    errors: Callable[[Placement], Array], by: NDArray[np.bool_], segments: int, begin: Placement
) -> Placement:
    """The best in the mean over the runs `by`, (R)."""
    return ranked(lambda placement: float(errors(placement)[by].mean()), segments, begin)[0]
