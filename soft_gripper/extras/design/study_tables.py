"""The tables of a design study: every design, the test, and sensitivities.

A sensitivity is the fraction of an end that a variable explains, over the designs that were tried. Ranks of the end are
regressed on ranks of the variables, all at once and standardised (SRRC: R. L. Iman and W. J. Conover, *The Use of the
Rank Transform in Regression*, 1979); ranks take care of monotonic laws that are not linear. A choice between things
that have no order has a column for each of them. Designs of a search crowd round the best, so that this is a statement
about them, not about the whole range; and what acts only together with another variable is not seen.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from math import nan
from pathlib import Path
from typing import Annotated, Any

import numpy as np
from scipy.stats import binomtest, rankdata

from soft_gripper.arrays import Array
from soft_gripper.extras.design.run_design import DESIGN, OBJECT, DesignResult, summarize_runs
from soft_gripper.extras.sweeps.cells import cell, numbers_in
from soft_gripper.files.row_table import columns, write_rows

DESIGNS, SENSITIVITY, TESTS = "designs.csv", "sensitivity.csv", "tests.csv"
SHARE_HELD = "held"  # fraction of runs that hold, treated as an end
Table = list[dict[str, Any]]


@dataclass(frozen=True)
class Sensitivity:
    """Effect of one variable on one end.

    slope_of_ranks: standardised regression coefficient, -1 to 1 for variables that are independent; NaN for a choice
        without order.
    explained: share of the variance of the end's ranks that is explained with this variable, but not without it.
    together: share that all variables explain.
    """

    end: str
    variable: str
    slope_of_ranks: Annotated[float, "+.2f"]
    explained: Annotated[float, ".2f"]
    together: Annotated[float, ".2f"]
    designs: int


def design_rows(result: DesignResult) -> Table:
    """Rows of all designs; the first is the unchanged scenario."""
    return [
        {DESIGN: design.number}
        | {axis.key: design.values.get(axis.key) for axis in result.study.axes}
        | {"held": design.held, "runs": design.runs}
        | _named_ends(result, design.ends)
        | {"allowed": design.is_allowed, "front": design.number in result.front, "reason": design.reason}
        for design in result.designs
    ]


def _named_ends(result: DesignResult, values: Sequence[float]) -> dict[str, float]:
    names = [end.measure for end in result.study.config.ends]
    return dict(zip(names, values or [nan] * len(names), strict=True))


def test_rows(result: DesignResult) -> Table:
    """The reference and the best design with each object, and a 95 % confidence interval; ends of runs that hold it."""
    rows = []
    for number, name in dict.fromkeys((row[DESIGN], row[OBJECT]) for row, _ in result.tests):
        runs = [row for row, _ in result.tests if (row[DESIGN], row[OBJECT]) == (number, name)]
        held, ends = summarize_runs(runs, result.study.config.ends)
        low, high = binomtest(len(held), len(runs)).proportion_ci(0.95, "wilson")
        rows.append(
            {DESIGN: number, OBJECT: name, "unseen": name in result.study.unseen, "held": len(held), "runs": len(runs)}
            | {"least_percent": 100 * low, "most_percent": 100 * high}
            | _named_ends(result, ends)
        )
    return rows


def sensitivity_rows(result: DesignResult) -> list[Sensitivity]:
    """Sensitivity of each end among allowed designs, and of the fraction of held runs among all simulated ones."""
    simulated_designs = [design for design in result.designs[1:] if not design.refused]
    allowed = [design for design in simulated_designs if design.is_allowed]
    values = {
        end.measure: (allowed, [design.ends[i] for design in allowed]) for i, end in enumerate(result.study.config.ends)
    }
    values[SHARE_HELD] = simulated_designs, [design.held / design.runs for design in simulated_designs]
    rows = []
    for name, (designs, end_values) in values.items():
        cells = {axis.key: [cell(design.values[axis.key]) for design in designs] for axis in result.study.axes}
        rows += sensitivities(name, end_values, cells)
    return rows


def sensitivities(end: str, values: Sequence[float], variables: Mapping[str, Sequence[str]]) -> list[Sensitivity]:
    """Effect of each variable, K cells with numbers or choices, on an end, over K designs.

    Empty if there are fewer designs than it takes, or the end is the same for all.
    """
    if len(values) < 2 or np.ptp(values) == 0:
        return []
    numbers = {name: numbers_in(cells) for name, cells in variables.items()}
    ranks = {name: _rank_columns(cells, numbers[name]) for name, cells in variables.items()}
    if len(values) <= sum(column.shape[1] for column in ranks.values()) + 2:
        return []
    y = _standardized(rankdata(values)[:, None])
    slopes, together = _fit(y, list(ranks.values()))
    rows = []
    for name, column in ranks.items():
        explained = together - _fit(y, [ranks[other] for other in ranks if other != name])[1]
        first_slope, slopes = slopes[0], slopes[column.shape[1] :]
        slope = float(first_slope) if np.isfinite(numbers[name]).all() else nan
        rows.append(Sensitivity(end, name, slope, max(explained, 0.0), together, len(y)))
    return rows


def _rank_columns(cells: Sequence[str], numbers: Array) -> Array:
    """Standardised ranks, (K, 1), or whether each choice but the first is taken, (K, C - 1)."""
    if np.isfinite(numbers).all():
        return _standardized(rankdata(numbers)[:, None])
    return _standardized(np.array(cells)[:, None] == sorted(set(cells))[1:])


def _standardized(columns: Array) -> Array:
    """Zero mean and unit variance of columns; zeros if all are the same."""
    centered = columns - columns.mean(axis=0)
    scale = centered.std(axis=0)
    return centered / np.where(scale > 0, scale, 1.0)


def _fit(y: Array, columns: Sequence[Array]) -> tuple[Array, float]:
    """Coefficients of a least-squares fit to y, (K, 1) of unit variance, and the share of the variance it explains."""
    x = np.hstack([np.zeros((len(y), 0)), *columns])
    slopes = np.linalg.lstsq(x, y, rcond=None)[0]
    return slopes[:, 0], 1 - float(np.mean((y - x @ slopes) ** 2))


def write_tables(result: DesignResult, out: Path) -> list[str]:
    """Writes the tables; returns their names."""
    tables = {DESIGNS: design_rows(result), TESTS: test_rows(result)}
    tables[SENSITIVITY] = [vars(row) for row in sensitivity_rows(result)]
    for name, rows in tables.items():
        names = list(rows[0]) if rows else columns(Sensitivity)
        write_rows(out / name, names, ([*map(cell, row.values())] for row in rows))
    return list(tables)
