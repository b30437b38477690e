"""The search for the best placement: all of them where they are few, else by exchange of one border at a time.

Up to EXHAUSTIVE placements, none is left out: of 12 segments there are 462 at most. For finer fingers the search begins
at a given placement and goes through the borders in turn; each goes to the best of all places between its neighbours.
It ends when no border moves: the placement is then the best of all that differ from it in one border, though perhaps
not of all. (Coordinate exchange, as for designs of experiments: Meyer and Nachtsheim 1995, doi
10.1080/00401706.1995.10485889.)
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from soft_gripper.arrays import Array
from soft_gripper.placement.placements import Placement, all_placements, number_of_placements

EXHAUSTIVE = 500
Objective = Callable[[Placement], float]


def ranked(objective: Objective, segments: int, begin: Placement) -> list[Placement]:
    """The placements that were tried, that with the least objective first.

    `begin` is where the exchange begins; it has as many borders as all others, and is among those tried.
    """
    tried: dict[Placement, float] = {}

    def score(placement: Placement) -> float:
        if placement not in tried:
            tried[placement] = objective(placement)
        return tried[placement]

    if number_of_placements(segments, len(begin) + 1) <= EXHAUSTIVE:
        for placement in all_placements(segments, len(begin) + 1):
            score(placement)
    else:
        _exchange(score, segments, begin)
    return sorted(tried, key=lambda placement: (tried[placement], placement))


def _exchange(score: Objective, segments: int, begin: Placement) -> None:
    """Moves one border after the other to its best place, until none moves."""
    now, before = begin, None
    while now != before:
        before = now
        for i in range(len(now)):
            now = min(_moved(now, i, segments), key=score)


def _moved(placement: Placement, i: int, segments: int) -> list[Placement]:
    """All that differ from a placement in border i alone, itself among them."""
    low, _, high = (0, *placement, segments)[i : i + 3]
    return [(*placement[:i], end, *placement[i + 1 :]) for end in range(low + 1, high)]


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
