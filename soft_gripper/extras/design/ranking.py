"""How designs compare: scores from the measures of their runs, the Pareto front, and the best one. Pure functions.

A design is first of all allowed or not: every run has to hold its object and to stay within the limits. By how much it
is not, each as a number above 0, leads the search back. Allowed designs are then compared by their ends.
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from soft_gripper.arrays import Array
from soft_gripper.extras.design.study_file import LEAST, MEAN, EndConfig, LimitConfig
from soft_gripper.files.number import number as decimal
from soft_gripper.runs.scores.grasp import HELD

GRASP, WALL = "grasp", "wall"
NAN = float("nan")


@dataclass(frozen=True)
class Score:
    """Summary of the runs of a design.

    held: runs in which the object is held, of `runs`.
    ends: the value of each end; NaN if it is not known in a run that holds.
    excess: by how much the design breaks the limits, by their names; 0 or less: it keeps them.
    refused: why it was not simulated; empty if it was.
    """

    held: int = 0
    runs: int = 0
    ends: tuple[float, ...] = ()
    excess: Mapping[str, float] = field(default_factory=dict)
    refused: str = ""

    @property
    def is_allowed(self) -> bool:
        """Whether it holds everything, within all limits."""
        return not self.refused and all(value <= 0 for value in self.excess.values())


def score(rows: Sequence[Mapping[str, Any]], ends: Sequence[EndConfig], limits: Mapping[str, LimitConfig]) -> Score:
    """The score of a design from the measures of its runs; a run that failed has none."""
    held = [row for row in rows if row.get(GRASP) == HELD]
    excess = {GRASP: 1 - len(held) / len(rows)}
    for name, limit in limits.items():
        excess |= _beyond(name, limit, [number(row.get(name)) for row in held])
    of_ends = tuple(over(end, [number(row.get(end.measure)) for row in held]) for end in ends)
    for end, value in zip(ends, of_ends, strict=True):
        if math.isnan(value):
            excess[f"{end.measure} is known"] = 1.0
    return Score(len(held), len(rows), of_ends, excess)


def _beyond(name: str, limit: LimitConfig, values: Sequence[float]) -> dict[str, float]:
    """By how much the worst run is beyond the limits of a measure, relative to them; unknown: by 1."""
    found = {}
    for kind, bound, sign in (("least", limit.least, -1), ("most", limit.most, 1)):
        if bound is not None:
            worst = max((sign * (value - bound) for value in values), default=NAN)
            known = bool(values) and not any(map(math.isnan, values))
            found[f"{name} at {kind} {bound:g}"] = worst / (abs(bound) or 1.0) if known else 1.0
    return found


def over(end: EndConfig, values: Sequence[float]) -> float:
    """The mean or the worst of an end over runs; NaN if one is not known, or there are none."""
    if not values or any(map(math.isnan, values)):
        return NAN
    if end.of == MEAN:
        return float(np.mean(values))
    return max(values) if end.towards == LEAST else min(values)


def number(value: Any) -> float:
    """A measure as a number: true is 1; NaN for words, and for what is missing."""
    if isinstance(value, str):
        try:
            return {"True": 1.0, "False": 0.0}[value] if value in ("True", "False") else decimal(value)
        except ValueError:
            return NAN
    return float(value) if isinstance(value, int | float) else NAN


def costs(scores: Sequence[Score], ends: Sequence[EndConfig]) -> Array:
    """The ends of designs, of which less is better, (K, E); NaN for designs that are not allowed."""
    signs = np.array([1.0 if end.towards == LEAST else -1.0 for end in ends])
    rows = [signs * each.ends if each.is_allowed else np.full(len(ends), NAN) for each in scores]
    return np.array(rows).reshape(-1, len(ends))


def pareto_front(cost: Array) -> list[int]:
    """The rows of (K, E) costs that no other dominates, as good in every column and better in one; NaN is none."""
    known = [i for i in range(len(cost)) if np.isfinite(cost[i]).all()]
    return [i for i in known if not any(_dominates(cost[j], cost[i]) for j in known)]


def _dominates(one: Array, other: Array) -> bool:
    return bool((one <= other).all() and (one < other).any())


def best(cost: Array) -> int | None:
    """The row that is best in the first column, of equals in the next; None if all are NaN."""
    known = [i for i in range(len(cost)) if np.isfinite(cost[i]).all()]
    return min(known, key=lambda i: tuple(cost[i]), default=None)
