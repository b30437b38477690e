"""Scores of an estimator on the tasks."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from soft_gripper.arrays import Array
from soft_gripper.benchmark.baselines import Estimator, Predict
from soft_gripper.benchmark.tasks import Recorded, Task
from soft_gripper.errors import InputError, described

_BAND = 1.959964  # standard deviations to either side that hold 95 % of normal errors


@dataclass(frozen=True)
class Score:
    """The errors of one estimator in one region of a task: distances between outputs, in their unit."""

    task: str
    region: str
    estimator: str
    samples: int
    unit: str
    mean: float
    median: float
    percentile_95: float
    within_band_percent: float | None  # of single outputs in the stated 95 % band; None without a band


def score_task(
    task: Task, name: str, estimator: Estimator, train: Sequence[Recorded], tested: dict[str, list[Recorded]]
) -> Iterator[Score]:
    """A row for every region. Raises an `InputError` for an estimator that fails or breaks the protocol."""
    predict = _called(name, task, estimator, task, train)
    if not callable(predict):
        raise InputError(name, "returned", type(predict).__name__, "must be a function predict(inputs)")
    for region, recordings in tested.items():
        found = [_predicted(name, task, predict, recorded) for recorded in recordings]
        truth = np.vstack([recorded.outputs for recorded in recordings])
        mean = np.vstack([mean for mean, _ in found])
        bands = [std for _, std in found if std is not None]
        distance = np.linalg.norm(mean - truth, axis=1)
        within = 100 * float((np.abs(mean - truth) <= _BAND * np.vstack(bands)).mean()) if bands else None
        median, most = (float(value) for value in np.percentile(distance, (50, 95)))
        unit = task.outputs[0].unit
        yield Score(task.name, region, name, len(truth), unit, float(distance.mean()), median, most, within)


def _called(name: str, task: Task, function: Any, *arguments: object) -> Any:
    try:
        return function(*arguments)
    except Exception as error:
        expected = "must run: estimator(task, train) -> predict, predict(inputs) -> mean or (mean, std)"
        raise InputError(name, f"failed on {task.name}", described(error), expected) from error


def _predicted(name: str, task: Task, predict: Predict, recorded: Recorded) -> tuple[Array, Array | None]:
    """Mean and standard deviation, checked; also that the first half does not depend on the second."""
    mean, std = _checked(name, task, predict, recorded.inputs)
    half = len(recorded.inputs) // 2
    alone, _ = _checked(name, task, predict, recorded.inputs[:half])
    if not np.allclose(alone, mean[:half], rtol=1e-6, atol=1e-9):
        raise InputError(name, f"estimate on {task.name}", "depends on later inputs", "must use past inputs only")
    return mean, std


def _checked(name: str, task: Task, predict: Predict, inputs: Array) -> tuple[Array, Array | None]:
    found = _called(name, task, predict, inputs.copy())
    mean, std = found if isinstance(found, tuple) and len(found) == 2 else (found, None)
    shape = len(inputs), len(task.outputs)
    checked = _array(name, task, "mean", mean, shape)
    if std is None:
        return checked, None
    band = _array(name, task, "std", std, shape)
    if (band < 0).any():
        raise InputError(name, f"std on {task.name}", float(band.min()), "must not be negative")
    return checked, band


def _array(name: str, task: Task, what: str, value: object, shape: tuple[int, int]) -> Array:
    try:
        array = np.asarray(value, dtype=float)
    except (TypeError, ValueError):
        raise InputError(name, f"{what} on {task.name}", type(value).__name__, f"must be numbers {shape}") from None
    if array.shape != shape:
        raise InputError(name, f"shape of {what} on {task.name}", array.shape, f"must be {shape}")
    if not np.isfinite(array).all():
        raise InputError(name, f"{what} on {task.name}", "NaN or infinite", "must be finite")
    return array
