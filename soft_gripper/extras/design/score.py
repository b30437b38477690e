"""Scores of designs, from the measures of their runs, and the best design. Pure functions.

A design is first of all allowed or not: every run has to hold its object and to stay within the limits. By how much it
is not, each as a number above 0, leads the search back. Allowed designs are then compared by their ends.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from math import isnan, nan
from typing import Any

import numpy as np

from soft_gripper.arrays import Array
from soft_gripper.extras.design.study_file import LEAST, MEAN, DesignConfig, EndConfig, LimitConfig
from soft_gripper.runs.scores.grasp import HELD
from soft_gripper.runs.sweep.cells import numbers_in
from soft_gripper.runs.sweep.measures import GRASP, column_of

Row = Mapping[str, str]  # cells of a run by column


@dataclass(frozen=True)
class Design:
    """A design and the summary of its runs in the search.

    values: by dotted keys; empty for the unchanged scenario.
    held: runs in which the object is held, of `runs`.
    ends: the value of each end; NaN if it is not known in a run that holds.
    excess: excess over each limit, by its name; 0 or less: it is kept.
    refused: reason for which it was not simulated; empty if it was.
    """

    number: int
    values: Mapping[str, Any]
    held: int = 0
    runs: int = 0
    ends: tuple[float, ...] = ()
    excess: Mapping[str, float] = field(default_factory=dict)
    refused: str = ""

    @property
    def is_allowed(self) -> bool:
        """Whether it holds everything, within all limits."""
        return not self.refused and all(value <= 0 for value in self.excess.values())

    @property
    def reason(self) -> str:
        """Text that says why a design is not allowed; empty if it is."""
        if self.refused or self.held < self.runs:
            return self.refused or f"holds in {self.held} of {self.runs} runs"
        return "; ".join(f"not: {name}" for name, excess in self.excess.items() if excess > 0)


def score_design(number: int, values: Mapping[str, Any], rows: Sequence[Row], config: DesignConfig) -> Design:
    """The score of a design from the measures of its runs; a run that failed has none."""
    held_rows, ends = summarize_runs(rows, config.ends)
    excess = {GRASP: 1 - len(held_rows) / len(rows)}
    for name, limit in config.limits.items():
        excess |= _excess(name, limit, _measured(held_rows, name))
    excess |= {f"{end.measure} is known": 1.0 for end, value in zip(config.ends, ends, strict=True) if isnan(value)}
    return Design(number, values, len(held_rows), len(rows), ends, excess)


def summarize_runs(rows: Sequence[Row], ends: Sequence[EndConfig]) -> tuple[list[Row], tuple[float, ...]]:
    """The runs that hold their object, and the value of each end over them, NaN where a run lacks it or none holds."""
    held_rows = [row for row in rows if row[GRASP] == HELD]
    if not held_rows:
        return [], (nan,) * len(ends)
    end_values = []
    for end in ends:
        values = _measured(held_rows, end.measure)
        worst = np.max if end.towards == LEAST else np.min
        end_values.append(float(np.mean(values) if end.of == MEAN else worst(values)))
    return held_rows, tuple(end_values)


def _measured(rows: Sequence[Row], measure: str) -> Array:
    return numbers_in([row[column_of(measure)] for row in rows])


def _excess(name: str, limit: LimitConfig, values: Array) -> dict[str, float]:
    """Excess of the worst run over the limits of a measure, relative to them; 1 if unknown."""
    is_known = len(values) > 0 and not np.isnan(values).any()
    bounds = {"least": (limit.least, -1), "most": (limit.most, 1)}
    return {
        f"{name} at {kind} {bound:g}": float(np.max(sign * (values - bound)) / (abs(bound) or 1)) if is_known else 1.0
        for kind, (bound, sign) in bounds.items()
        if bound is not None
    }


def find_best(designs: Sequence[Design], ends: Sequence[EndConfig]) -> Design | None:
    """The allowed design that is best by the first end, among equals by the next; None if no one is allowed."""
    signs = [1.0 if end.towards == LEAST else -1.0 for end in ends]
    allowed = [design for design in designs if design.is_allowed]
    return min(allowed, key=lambda design: [*np.multiply(signs, design.ends)], default=None)
