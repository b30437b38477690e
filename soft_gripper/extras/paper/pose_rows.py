"""Rows of pose errors by scenario, estimator and number of sensors."""

from collections.abc import Sequence
from typing import TypeVar

import numpy as np

from soft_gripper.arrays import Array
from soft_gripper.runs.scores.poses import HeldStep, PoseRow

Row = TypeVar("Row", bound=HeldStep)


def estimator_rows(rows: Sequence[Row], estimator: str) -> list[Row]:
    """The rows of one estimator."""
    return [row for row in rows if row.estimator == estimator]


def errors_of(rows: Sequence[PoseRow], scenario: str, sections: int, error: str) -> Array:
    """A column of errors, mm, of the rows of a scenario with a given number of sensors, in row order."""
    return np.array([getattr(row, error) for row in rows if (row.scenario, row.sections) == (scenario, sections)])


def mean_errors(rows: Sequence[PoseRow], scenario: str, error: str) -> Array:
    """Mean of a column of errors over the steps and fingers of a scenario, mm, for each number of sensors."""
    sensor_counts = sorted({row.sections for row in rows})
    return np.array([errors_of(rows, scenario, sections, error).mean() for sections in sensor_counts])


def largest_gain(rows: Sequence[PoseRow], scenarios: Sequence[str], low: int, high: int, error: str) -> float:
    """Largest reduction of the error from `few` to `more` sensors at any step of any scenario, mm."""
    gains = [errors_of(rows, name, low, error) - errors_of(rows, name, high, error) for name in scenarios]
    return float(np.max([gain.max() for gain in gains]))
