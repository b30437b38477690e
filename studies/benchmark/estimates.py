"""Estimates of an estimator: of what is tested, the inputs are all that it is given."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from soft_gripper.arrays import Array
from soft_gripper.errors import InputError
from studies.benchmark.benchmark_task import Estimator, Inputs, Predict, Question, Recorded

_LARGEST = 1e9  # of what is stated: squares of it do not overflow, and would drop out of the errors


@dataclass(frozen=True)
class Estimated:
    """Statements of an estimator about the samples of a test recording."""

    mean: Array  # (T, m)
    std: Array | None  # (T, m); None: it states no band


Answers = Mapping[str, Sequence[Estimated]]  # of the recordings of every region


def answers(task: Question, name: str, estimator: Estimator, train: Sequence[Recorded], inputs: Inputs) -> Answers:
    """Statements about every region; raises an `InputError` for an estimator that breaks the protocol."""
    predict = estimator(task, train)
    parts = [part for recordings in inputs.values() for part in recordings]
    if task.period is None:
        found = _mixed(name, task, predict, parts)
    else:
        found = [_predicted(name, task, predict, part) for part in parts]
    if len({each.std is None for each in found}) > 1:
        raise InputError(name, f"std on {task.name}", "missing in some recordings", "must be in all of them or none")
    rest = iter(found)
    return {region: [next(rest) for _ in recordings] for region, recordings in inputs.items()}


def _mixed(name: str, task: Question, predict: Predict, parts: Sequence[Array]) -> list[Estimated]:
    """Statements about parts with samples that stand alone: neither order nor region, which tell answers, are given."""
    whole = np.vstack(parts)
    order = np.lexsort(whole.T)
    found = _predicted(name, task, predict, whole[order])
    back, ends = np.argsort(order), np.cumsum([len(part) for part in parts])[:-1]
    means = np.split(found.mean[back], ends)
    stds = [None] * len(parts) if found.std is None else np.split(found.std[back], ends)
    return [Estimated(mean, std) for mean, std in zip(means, stds, strict=True)]


def _predicted(name: str, task: Question, predict: Predict, inputs: Array) -> Estimated:
    """Mean and standard deviation, checked; also that the first half, asked first, does not depend on the second."""
    half = len(inputs) // 2
    alone, found = (_asked(name, task, predict, values) for values in (inputs[:half], inputs))
    for whole, begin in zip((found.mean, found.std), (alone.mean, alone.std), strict=True):
        if whole is not None and begin is not None and not np.allclose(begin, whole[:half], rtol=1e-6, atol=1e-9):
            raise InputError(name, f"estimate on {task.name}", "depends on later inputs", "must use past inputs only")
    return found


def _asked(name: str, task: Question, predict: Predict, inputs: Array) -> Estimated:
    return checked(name, task, len(inputs), *mean_and_std(predict(inputs.copy())))


def mean_and_std(found: object) -> tuple[object, object]:
    """What a prediction states; None: no standard deviation."""
    return found if isinstance(found, tuple) and len(found) == 2 else (found, None)


def checked(name: str, task: Question, samples: int, mean: object, std: object) -> Estimated:
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


def _array(name: str, task: Question, what: str, value: object, shape: tuple[int, int]) -> Array:
    try:
        array = np.asarray(value, dtype=float)
    except (TypeError, ValueError, OverflowError):
        raise InputError(name, f"{what} on {task.name}", type(value).__name__, f"must be numbers {shape}") from None
    if array.shape != shape:
        raise InputError(name, f"shape of {what} on {task.name}", array.shape, f"must be {shape}")
    if not (np.abs(array) < _LARGEST).all():
        expected = f"must be finite, and below {_LARGEST:g}"
        raise InputError(name, f"{what} on {task.name}", float(array[~(np.abs(array) < _LARGEST)][0]), expected)
    return array
