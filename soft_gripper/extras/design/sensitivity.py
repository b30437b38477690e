"""Sensitivity: how much of an end each variable explains, over the designs that were tried.

Ranks of the end are regressed on ranks of the variables, all at once and standardised (SRRC: R. L. Iman and
W. J. Conover, *The Use of the Rank Transform in Regression*, 1979); ranks take care of monotonic laws that are not
linear. A choice between things that have no order has a column for each of them. `explained` is by how much the
explained variance of the ranks falls without the variable. Designs of a search crowd round the best, so that this is a
statement about them, not about the whole range; and what acts only together with another variable is not seen.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.stats import rankdata

from soft_gripper.arrays import Array

NAN = float("nan")


@dataclass(frozen=True)
class Sensitivity:
    """Effect of one variable on one end.

    slope: standardised regression coefficient of the ranks, -1 to 1 for variables that are independent; NaN for a
        choice without order.
    explained: share of the variance of the end's ranks that is explained with this variable, but not without it.
    together: share that all variables explain.
    designs: number of designs.
    """

    end: str
    variable: str
    slope: float
    explained: float
    together: float
    designs: int


def sensitivities(end: str, values: Array, variables: Mapping[str, Sequence[Any]]) -> list[Sensitivity]:
    """Effect of each variable on an end, over K designs.

    Args:
        end: its name.
        values: of the end, (K,).
        variables: values of each variable, K each; numbers or choices.

    Returns:
        a row for each variable; empty if there are fewer designs than it takes, or the end is the same for all.
    """
    if len(values) < 2 or np.ptp(values) == 0:
        return []
    columns = {name: _columns(given) for name, given in variables.items()}
    needed = sum(column.shape[1] for column in columns.values()) + 2
    if len(values) <= needed:
        return []
    y = _standard(rankdata(values))
    slopes, together = _fit(y, list(columns.values()))
    found, place = [], 0
    for name, column in columns.items():
        others = [other for key, other in columns.items() if key != name]
        slope = float(slopes[place]) if _is_ordered(variables[name]) else NAN
        found.append(Sensitivity(end, name, slope, max(together - _fit(y, others)[1], 0.0), together, len(y)))
        place += column.shape[1]
    return found


def _is_ordered(values: Sequence[Any]) -> bool:
    return all(isinstance(value, int | float) and not isinstance(value, bool) for value in values)


def _columns(values: Sequence[Any]) -> Array:
    """Standardised ranks, (K, 1), or whether each choice but the first is taken, (K, C - 1)."""
    if _is_ordered(values):
        return _standard(rankdata(np.array(values, float)))[:, None]
    texts = list(map(str, values))
    columns = [_standard(np.array([text == choice for text in texts], float)) for choice in sorted(set(texts))[1:]]
    return np.array(columns).reshape(-1, len(texts)).T


def _standard(values: Array) -> Array:
    """Zero mean and unit variance; zeros if all are the same."""
    centered = values - values.mean()
    scale = centered.std()
    standard: Array = centered / scale if scale > 0 else centered
    return standard


def _fit(y: Array, columns: Sequence[Array]) -> tuple[Array, float]:
    """Coefficients of a least-squares fit to y of unit variance, and the share of the variance that it explains."""
    if not columns:
        return np.zeros(0), 0.0
    x = np.hstack(columns)
    slopes = np.linalg.lstsq(x, y, rcond=None)[0]
    return slopes, 1 - float(np.mean((y - x @ slopes) ** 2))
