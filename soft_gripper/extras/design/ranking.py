"""Compares designs: scores from the measures of their runs, the Pareto front, and the best one. Pure functions.

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
from soft_gripper.extras.sweeps.cells import numbers_in
from soft_gripper.extras.sweeps.measured_runs import GRASP
from soft_gripper.runs.scores.grasp import HELD

Row = Mapping[str, str]  # cells of a run by column


@dataclass(frozen=True)
class DesignScore:
    """Summary of the runs of a design.

    held: runs in which the object is held, of `runs`.
    ends: the value of each end; NaN if it is not known in a run that holds.
    excess: excess over each limit, by its name; 0 or less: it is kept.
    refused: reason for which it was not simulated; empty if it was.
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


@dataclass(frozen=True)
class Design:
    """A design and its score in the search; values by dotted keys, empty for the unchanged scenario."""

    number: int
    values: Mapping[str, Any]
    score: DesignScore


def score(rows: Sequence[Row], ends: Sequence[EndConfig], limits: Mapping[str, LimitConfig]) -> DesignScore:
    """The score of a design from the measures of its runs; a run that failed has none."""
    held_rows, end_values = summarize_runs(rows, ends)
    excess = {GRASP: 1 - len(held_rows) / len(rows)}
    for name, limit in limits.items():
        excess |= _excess(name, limit, numbers_in([row[name] for row in held_rows]))
    excess |= {f"{end.measure} is known": 1.0 for end, value in zip(ends, end_values, strict=True) if math.isnan(value)}
    return DesignScore(len(held_rows), len(rows), end_values, excess)


def summarize_runs(rows: Sequence[Row], ends: Sequence[EndConfig]) -> tuple[list[Row], tuple[float, ...]]:
    """The runs that hold their object, and the value of each end over them, NaN where a run lacks it or none holds."""
    held_rows = [row for row in rows if row[GRASP] == HELD]
    values = [numbers_in([row[end.measure] for row in held_rows]) for end in ends] if held_rows else []
    end_values = (
        np.mean(row) if end.of == MEAN else np.max(row) if end.towards == LEAST else np.min(row)
        for end, row in zip(ends, values, strict=True)
    )
    return held_rows, tuple(map(float, end_values)) if held_rows else (math.nan,) * len(ends)


def _excess(name: str, limit: LimitConfig, values: Array) -> dict[str, float]:
    """Excess of the worst run over the limits of a measure, relative to them; 1 if unknown."""
    is_known = len(values) > 0 and not np.isnan(values).any()
    bounds = {"least": (limit.least, -1), "most": (limit.most, 1)}
    return {
        f"{name} at {kind} {bound:g}": float(np.max(sign * (values - bound)) / (abs(bound) or 1)) if is_known else 1.0
        for kind, (bound, sign) in bounds.items()
        if bound is not None
    }


def costs(designs: Sequence[Design], ends: Sequence[EndConfig]) -> Array:
    """Costs of designs, (K, E): their ends, negated where more is better; NaN for designs that are not allowed."""
    signs = np.array([1.0 if end.towards == LEAST else -1.0 for end in ends])
    scores = (design.score for design in designs)
    rows = [
        signs * design_score.ends if design_score.is_allowed else np.full(len(ends), math.nan)
        for design_score in scores
    ]
    return np.array(rows).reshape(-1, len(ends))


def pareto_front(cost: Array) -> list[int]:
    """Indices of the rows of (K, E) costs that no other dominates, as good in every column and better in one."""
    allowed_costs = cost[np.isfinite(cost).all(axis=1)]
    is_dominated = [((allowed_costs <= row).all(axis=1) & (allowed_costs < row).any(axis=1)).any() for row in cost]
    return [i for i, row in enumerate(cost) if np.isfinite(row).all() and not is_dominated[i]]


def find_best(cost: Array) -> int | None:
    """Index of the row that is best in the first column, among equals in the next; None if all are NaN."""
    allowed_indices = [i for i in range(len(cost)) if np.isfinite(cost[i]).all()]
    return min(allowed_indices, key=lambda i: tuple(cost[i]), default=None)
