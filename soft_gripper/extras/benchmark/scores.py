"""Scores of estimates, and estimates of an estimator: the inputs of what is tested are all that it is given of it."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.special import ndtr

from soft_gripper.arrays import Array
from soft_gripper.errors import InputError, described
from soft_gripper.extras.benchmark.baselines import Estimator, Predict
from soft_gripper.extras.benchmark.benchmark_task import Recorded, Task
from soft_gripper.extras.hardware.scoring import NORMAL_95, error_columns, percent_within

_SET = 0.95  # of the probability, that a set of answers holds


@dataclass(frozen=True)
class Estimated:
    """Statements of an estimator about the samples of a test recording."""

    mean: Array  # (T, m)
    std: Array | None  # (T, m); None: it states no band


Tested = Mapping[str, Sequence[Recorded]]  # the recordings of every region
Answers = Mapping[str, Sequence[Estimated]]  # of the recordings of every region


@dataclass(frozen=True)
class Score:
    """The errors of one estimator in one region of a task.

    Errors are distances between outputs, in their unit. A band holds 95 % of normal errors if the stated standard
    deviations are right. In recognition the mean is the share of wrong answers, and the band is the fewest answers that
    have 95 % of the stated probability.
    """

    task: str
    region: str
    estimator: str
    samples: int
    unit: str
    mean: float
    median: float | None  # None in recognition
    percentile_95: float | None
    proper: float  # mean CRPS of single outputs, in the unit; in recognition the Brier score, from 0 to 2
    within_band_percent: float | None  # of single outputs, in their band; None without a band
    band: float | None  # mean width from end to end, in the unit; in recognition the mean number of answers
    unknown_percent: float | None = None  # of answers in recognition


def answers(task: Task, name: str, estimator: Estimator, train: Sequence[Recorded], tested: Tested) -> Answers:
    """Statements about every region; raises an `InputError` for an estimator that fails or breaks the protocol."""
    predict = _called(name, task, estimator, task.question, train)
    if not callable(predict):
        raise InputError(name, "returned", type(predict).__name__, "must be a function predict(inputs)")
    found = {}
    for region, recordings in tested.items():
        found[region] = [_predicted(name, task, predict, recorded.inputs) for recorded in recordings]
        if len({each.std is None for each in found[region]}) > 1:
            raise InputError(
                name, f"std on {task.name}", "missing in some recordings", "must be in all of them or none"
            )
    return found


def scores(task: Task, name: str, stated: Answers, tested: Tested) -> Iterator[Score]:
    """The scores of an estimator in every region of which it states something."""
    scored = _recognized if task.recognition else _measured
    for region, found in stated.items():
        truth = np.vstack([recorded.outputs for recorded in tested[region]])
        mean = np.vstack([each.mean for each in found])
        bands = [each.std for each in found if each.std is not None]
        found_std = np.vstack(bands) if bands else None
        yield Score(task.name, region, name, len(truth), **scored(task, truth, mean, found_std))


def crps(error: Array, std: Array) -> Array:
    """Continuous ranked probability score of normal estimates, in the unit of their errors.

    It is least in the mean for an estimator that states what it knows (Gneiting and Raftery, *JASA* 102, 2007, section
    4.2), and the size of the error if the standard deviation is 0.
    """
    size = np.abs(error)
    with np.errstate(divide="ignore", invalid="ignore"):
        z = np.where(std > 0, size / std, np.inf)
        density = np.exp(-(z**2) / 2) / np.sqrt(2 * np.pi)
    found: Array = size * (2 * ndtr(z) - 1) + std * (2 * density - 1 / np.sqrt(np.pi))
    return found


def _measured(task: Task, truth: Array, mean: Array, std: Array | None) -> dict[str, Any]:
    """The fields of a score from its unit on."""
    errors = mean - truth
    distances = error_columns(np.linalg.norm(errors, axis=1), "mean", "median", "percentile_95")
    proper = float(crps(errors, np.zeros_like(errors) if std is None else std).mean())
    within = None if std is None else percent_within(errors, NORMAL_95 * std)
    width = None if std is None else 2 * NORMAL_95 * float(std.mean())
    unit = task.outputs[0].unit
    return distances | {"unit": unit, "proper": proper, "within_band_percent": within, "band": width}


def _recognized(task: Task, truth: Array, mean: Array, std: Array | None) -> dict[str, Any]:
    """Scores of recognition, as those of numbers; standard deviations are not used."""
    stated, true = with_unknown(mean), with_unknown(truth)
    held = true.argmax(axis=1)
    order = np.argsort(-stated, axis=1, kind="stable")
    before = np.cumsum(np.take_along_axis(stated, order, axis=1), axis=1) - np.take_along_axis(stated, order, axis=1)
    counted = before < _SET - 1e-9  # the fewest of the likeliest answers
    place = (order == held[:, None]).argmax(axis=1)
    within = 100 * float(np.take_along_axis(counted, place[:, None], axis=1).mean())
    wrong, unknown = (100 * float(found.mean()) for found in (place > 0, order[:, 0] == mean.shape[1]))
    brier = float(((stated - true) ** 2).sum(axis=1).mean())
    band = float(counted.sum(axis=1).mean())
    counts = {"mean": wrong, "proper": brier, "within_band_percent": within, "band": band, "unknown_percent": unknown}
    return counts | {"unit": "%", "median": None, "percentile_95": None}


def with_unknown(stated: Array) -> Array:
    """Probabilities (T, C) of classes, and then that of no class; negative ones count as 0, sums above 1 are scaled."""
    known = np.maximum(stated, 0.0)
    total = known.sum(axis=1, keepdims=True)
    return np.hstack([known / np.maximum(total, 1.0), np.maximum(1 - total, 0.0)])


def _called(name: str, task: Task, function: Any, *arguments: object) -> Any:
    try:
        return function(*arguments)
    except (Exception, SystemExit) as error:
        expected = "must run: estimator(task, train) -> predict, predict(inputs) -> mean or (mean, std)"
        raise InputError(name, f"failed on {task.name}", described(error), expected) from error


def _predicted(name: str, task: Task, predict: Predict, inputs: Array) -> Estimated:
    """Mean and standard deviation, checked; also that the first half does not depend on the second."""
    found, half = _checked(name, task, predict, inputs), len(inputs) // 2
    alone = _checked(name, task, predict, inputs[:half])
    for whole, begin in zip((found.mean, found.std), (alone.mean, alone.std), strict=True):
        if whole is not None and begin is not None and not np.allclose(begin, whole[:half], rtol=1e-6, atol=1e-9):
            raise InputError(name, f"estimate on {task.name}", "depends on later inputs", "must use past inputs only")
    return found


def _checked(name: str, task: Task, predict: Predict, inputs: Array) -> Estimated:
    found = _called(name, task, predict, inputs.copy())
    mean, std = found if isinstance(found, tuple) and len(found) == 2 else (found, None)
    return checked(name, task, len(inputs), mean, std)


def checked(name: str, task: Task, samples: int, mean: object, std: object) -> Estimated:
    """Checked statements about a number of samples; `name` is who states them.

    Raises:
        InputError: if it has another shape, is not finite, or a standard deviation is negative.
    """
    shape = samples, len(task.outputs)
    found = _array(name, task, "mean", mean, shape)
    if std is None:
        return Estimated(found, None)
    band = _array(name, task, "std", std, shape)
    if (band < 0).any():
        raise InputError(name, f"std on {task.name}", float(band.min()), "must not be negative")
    return Estimated(found, band)


def _array(name: str, task: Task, what: str, value: object, shape: tuple[int, int]) -> Array:
    try:
        array = np.asarray(value, dtype=float)
    except (TypeError, ValueError, OverflowError):
        raise InputError(name, f"{what} on {task.name}", type(value).__name__, f"must be numbers {shape}") from None
    if array.shape != shape:
        raise InputError(name, f"shape of {what} on {task.name}", array.shape, f"must be {shape}")
    if not np.isfinite(array).all():
        raise InputError(name, f"{what} on {task.name}", "NaN or infinite", "must be finite")
    return array
