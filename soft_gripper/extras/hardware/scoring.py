"""Splits recordings into fitted and held-out ones, predicts the latter, and gives statistics of their errors.

All experiments on recordings use this: a fit to the fitted recordings of a split is a function that predicts each of
its tested ones. Another statistic is a line of `_STATISTICS`.
"""

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass
from typing import Any, Generic, TypeVar

import numpy as np
from numpy.typing import NDArray

from soft_gripper.arrays import Array

FITTED, TESTED, LEFT_OUT = "fit", "test", "left out"  # roles of a recording in a table of scores
NORMAL_95 = 1.959964  # standard deviations to either side that hold 95 % of normal errors

_Recording = TypeVar("_Recording")
_Prediction = TypeVar("_Prediction")


@dataclass(frozen=True)
class Split(Generic[_Recording]):
    """Recordings that a model is fitted to, and others that it predicts."""

    fitted: Sequence[_Recording]
    tested: Sequence[_Recording]


def leave_one_out(recordings: Sequence[_Recording]) -> list[Split[_Recording]]:
    """Splits that hold out each recording in turn, to predict it by a fit to all others."""
    return [Split([*recordings[:i], *recordings[i + 1 :]], [recording]) for i, recording in enumerate(recordings)]


def leave_groups_out(groups: Sequence[NDArray[np.str_]]) -> list[list[NDArray[np.bool_]]]:
    """Mask (R,) of the fitted rows of each recording, for each group that is left out, in the order of their names.

    `groups` names the group of every row of each recording, (R,); a row whose name is empty is always fitted.
    """
    names = sorted({str(name) for row_groups in groups for name in row_groups} - {""})
    return [[row_groups != name for row_groups in groups] for name in names]


def predictions(
    splits: Iterable[Split[_Recording]], fit: Callable[[Sequence[_Recording]], Callable[[_Recording], _Prediction]]
) -> Iterator[_Prediction]:
    """Predictions of the tested recordings of every split, by one fit to its fitted ones."""
    for split in splits:
        predict = fit(split.fitted)
        yield from map(predict, split.tested)


_STATISTICS: dict[str, Callable[[Array], Any]] = {
    "mean": np.mean,
    "median": np.median,
    "percentile_95": lambda errors: np.percentile(errors, 95),
    "max": np.max,
    "rms": lambda errors: np.sqrt((errors**2).mean()),
}


def error_columns(errors: Array, *columns: str) -> dict[str, float]:
    """Statistics of distances of any shape by column: "mean_mm" has the mean of errors in mm.

    NaN (not seen) does not count.
    """
    finite_errors = errors[np.isfinite(errors)]
    return {column: float(_STATISTICS[column.removesuffix("_mm")](finite_errors)) for column in columns}


def ball_radius(deviations: Array) -> Array:
    """Radius of a ball that holds 95 % of the sum of K independent normal deviations, by its longest axis, (...).

    Given are one standard deviation of each in D dimensions, (K, ..., D).
    """
    covariance = np.einsum("k...i,k...j->...ij", deviations, deviations)
    largest_variance = np.maximum(0, np.linalg.eigvalsh(covariance)[..., -1])
    return np.sqrt(_squared_radius(deviations.shape[-1]) * largest_variance)


def ball_std(radius: Array, dimensions: int) -> Array:
    """Standard deviation along an axis of a normal distribution with 95 % in a ball of a radius."""
    return np.asarray(radius / np.sqrt(_squared_radius(dimensions)))


def ball_rms_z(errors: Array, radius: Array, dimensions: int) -> float:
    """Root mean square of errors along an axis over their standard deviations; 1 if the 95 % balls are right.

    Errors are distances, of which NaN does not count; `dimensions` are those of space.
    """
    ratios = errors / (np.sqrt(dimensions) * ball_std(radius, dimensions))
    return float(np.sqrt(np.nanmean(ratios**2)))


def _squared_radius(dimensions: int) -> float:
    """Square of the distance, in standard deviations, within which 95 % of a normal distribution lie."""
    from scipy.special import chdtri

    return float(chdtri(dimensions, 0.05))


def percent_within(errors: Array, band: Array) -> float:
    """Percentage of errors within a band to either side of 0, of the same shape; NaN does not count."""
    return 100 * float((np.abs(errors) <= band)[np.isfinite(errors)].mean())
