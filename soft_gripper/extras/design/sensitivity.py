"""Sensitivity: the fraction of an end that each variable explains, over the designs that were tried.

Ranks of the end are regressed on ranks of the variables, all at once and standardised (SRRC: R. L. Iman and
W. J. Conover, *The Use of the Rank Transform in Regression*, 1979); ranks take care of monotonic laws that are not
linear. A choice between things that have no order has a column for each of them. `explained` is by how much the
explained variance of the ranks falls without the variable. Designs of a search crowd round the best, so that this is a
statement about them, not about the whole range; and what acts only together with another variable is not seen.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from math import nan
from typing import Annotated

import numpy as np
from scipy.stats import rankdata

from soft_gripper.arrays import Array
from soft_gripper.extras.sweeps.cells import numbers_in


@dataclass(frozen=True)
class Sensitivity:
    """Effect of one variable on one end.

    slope_of_ranks: standardised regression coefficient, -1 to 1 for variables that are independent; NaN for a choice
        without order.
    explained: share of the variance of the end's ranks that is explained with this variable, but not without it.
    together: share that all variables explain.
    designs: number of designs.
    """

    end: str
    variable: str
    slope_of_ranks: Annotated[float, "+.2f"]
    explained: Annotated[float, ".2f"]
    together: Annotated[float, ".2f"]
    designs: int


def sensitivities(end: str, values: Sequence[float], variables: Mapping[str, Sequence[str]]) -> list[Sensitivity]:
    """Effect of each variable on an end, over K designs.

    Args:
        end: its name.
        values: of the end, K.
        variables: cells of each variable, K each; numbers or choices.

    Returns:
        a row for each variable; empty if there are fewer designs than it takes, or the end is the same for all.
    """
    if len(values) < 2 or np.ptp(values) == 0:
        return []
    columns = {name: _rank_columns(cells) for name, cells in variables.items()}
    if len(values) <= sum(column.shape[1] for column in columns.values()) + 2:
        return []
    y = _standardized(rankdata(values)[:, None])[:, 0]
    slopes, explained = _fit(y, list(columns.values()))
    rows = []
    begin = 0
    for name, column in columns.items():
        other_columns = [column_cells for key, column_cells in columns.items() if key != name]
        slope = float(slopes[begin]) if np.isfinite(numbers_in(variables[name])).all() else nan
        rows.append(Sensitivity(end, name, slope, max(explained - _fit(y, other_columns)[1], 0.0), explained, len(y)))
        begin += column.shape[1]
    return rows


def _rank_columns(cells: Sequence[str]) -> Array:
    """Standardised ranks, (K, 1), or whether each choice but the first is taken, (K, C - 1)."""
    numbers = numbers_in(cells)
    if np.isfinite(numbers).all():
        return _standardized(rankdata(numbers)[:, None])
    return _standardized(np.array(cells)[:, None] == sorted(set(cells))[1:])


def _standardized(columns: Array) -> Array:
    """Zero mean and unit variance of columns; zeros if all are the same."""
    centered = columns - columns.mean(axis=0)
    scale = centered.std(axis=0)
    return centered / np.where(scale > 0, scale, 1.0)


def _fit(y: Array, columns: Sequence[Array]) -> tuple[Array, float]:
    """Coefficients of a least-squares fit to y of unit variance, and the share of the variance that it explains."""
    x = np.hstack([np.zeros((len(y), 0)), *columns])
    slopes = np.linalg.lstsq(x, y, rcond=None)[0]
    return slopes, 1 - float(np.mean((y - x @ slopes) ** 2))
