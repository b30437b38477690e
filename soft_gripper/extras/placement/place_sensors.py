"""Runs and the errors of sensors -> designs of sensors by the errors they leave, the best of each number verified."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np

from soft_gripper.extras.placement.catalogue import (
    KINDS,
    PATHS,
    STRAIN,
    Design,
    as_borders,
    divisions,
    leaves_its_plane,
)
from soft_gripper.extras.placement.errors import Assumptions, Errors, Judge
from soft_gripper.extras.placement.samples import Samples
from soft_gripper.extras.placement.search import search_borders, search_sets
from soft_gripper.fingers.finger import Finger


@dataclass(frozen=True)
class Verified:
    """A design, and the errors that it leaves."""

    design: Design
    predicted: Errors
    made: dict[str, Errors]  # by run


@dataclass(frozen=True, eq=False)
class Placed:
    """The results of a search."""

    finger: Finger
    tried: Mapping[Design, Errors]  # as predicted
    best: list[Verified]  # by number of sensors; none that is worse than one with fewer sensors of its kind
    equal: list[Verified]  # the same with equal sections, where they are other ones

    def best_of(self, kind: str) -> Design:
        """The best design of a kind."""
        return min((one for one in self.best if one.design.kind == kind), key=lambda one: one.predicted.score).design

    @property
    def kinds(self) -> list[str]:
        """The kinds of sensors that were tried."""
        return list(dict.fromkeys(design.kind for design in self.tried))


def place_sensors(
    count: int,
    samples: Sequence[Samples],
    assumptions: Assumptions,
    estimator: str = "contact",
    progress: Callable[[], Any] = lambda: None,
) -> Placed:
    """Tries designs of at most `count` sensors; on a finger in its plane, at most so many sections of each side.

    Args:
        count: most sensors.
        samples: by which they are judged, of fingers with as many segments that yield alike.
        assumptions: errors of sensors and nominal finger.
        estimator: whose errors are verified.
        progress: called after every design that was tried, and every one that was verified.

    Raises:
        InputError: if the estimator is not for such fingers.
    """
    finger, judge, tried = samples[0].finger, Judge(samples, assumptions), dict[Design, Errors]()
    judge.check(estimator)

    def score(design: Design) -> float:
        if design not in tried:
            tried[design] = judge.predicted(design)
            progress()
        return tried[design].score

    if leaves_its_plane(finger):
        _try_in_space(score, finger, count)
    else:
        for sections in range(1, count + 1):
            equal = tuple(map(int, finger.section_ends(sections)[1:-1]))
            search_borders(lambda ends: score(Design(STRAIN, as_borders(ends, finger))), finger.segments, equal)

    def verified(number: int, design: Design) -> Verified:
        score(design)
        made = judge.made(design, estimator, number)
        progress()
        return Verified(design, tried[design], made)

    best = best_designs(tried)
    with_equal = [_with_equal_sections(design, finger) for design in best]
    return Placed(
        finger,
        tried,
        [verified(number, design) for number, design in enumerate(best)],
        [verified(number, design) for number, design in enumerate(with_equal) if design != best[number]],
    )


def _try_in_space(score: Callable[[Design], float], finger: Finger, count: int) -> None:
    for ends in divisions(finger, count):
        borders = as_borders(ends, finger)
        search_sets(partial(_score_paths, score, borders), list(PATHS), count // (len(borders) + 1))
        for kind in KINDS:
            if kind != STRAIN:
                score(Design(kind, borders))


def _score_paths(score: Callable[[Design], float], borders: tuple[float, ...], paths: tuple[str, ...]) -> float:
    return score(Design(STRAIN, borders, paths))


def _with_equal_sections(design: Design, finger: Finger) -> Design:
    ends = tuple(map(int, finger.section_ends(len(design.borders) + 1)[1:-1]))
    return Design(design.kind, as_borders(ends, finger), design.paths)


def best_designs(tried: Mapping[Design, Errors]) -> list[Design]:
    """The best of every kind and number of sensors, unless one with fewer sensors is as good."""
    best, least = list[Design](), dict.fromkeys(KINDS, np.inf)
    for design in sorted(tried, key=lambda design: (design.sensors, tried[design].score, design)):
        if tried[design].score < least[design.kind]:
            least[design.kind] = tried[design].score
            best.append(design)
    return best
