"""Asks estimators for their estimates of test samples, (T, m), by the inputs alone, and checks these."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from soft_gripper.arrays import Array
from soft_gripper.errors import InputError
from studies.benchmark.benchmark_task import Estimator, Inputs, Predict, Question, Recorded

_MAX_NUMBER = 1e9  # of an estimate: its square does not overflow


@dataclass(frozen=True)
class Estimated:
    """Estimates of the samples of a test recording."""

    mean: Array  # (T, m)
    std: Array | None  # (T, m); None: no band


Answers = Mapping[str, Sequence[Estimated]]  # of the recordings of every region


def answers(task: Question, name: str, estimator: Estimator, train: Sequence[Recorded], inputs: Inputs) -> Answers:
    """Estimates for every region; raises an `InputError` for an estimator that breaks the protocol."""
    predict = estimator(task, train)
    parts = [part for recordings in inputs.values() for part in recordings]
    if task.period is None:
        estimates = _estimate_shuffled(name, task, predict, parts)
    else:
        estimates = [_estimate(name, task, predict, part) for part in parts]
    if len({estimate.std is None for estimate in estimates}) > 1:
        raise InputError(name, f"std on {task.name}", "missing in some recordings", "must be in all of them or none")
    next_estimates = iter(estimates)
    return {region: [next(next_estimates) for _ in recordings] for region, recordings in inputs.items()}


def _estimate_shuffled(name: str, task: Question, predict: Predict, parts: Sequence[Array]) -> list[Estimated]:
    """Estimates for parts with independent samples, in an order that hides their order and region."""
    all_inputs = np.vstack(parts)
    order = np.lexsort(all_inputs.T)
    estimate = _estimate(name, task, predict, all_inputs[order])
    positions, ends = np.argsort(order), np.cumsum([len(part) for part in parts])[:-1]
    means = np.split(estimate.mean[positions], ends)
    stds = [None] * len(parts) if estimate.std is None else np.split(estimate.std[positions], ends)
    return [Estimated(mean, std) for mean, std in zip(means, stds, strict=True)]


def _estimate(name: str, task: Question, predict: Predict, inputs: Array) -> Estimated:
    """Asks for mean and standard deviation, and checks that the first half does not depend on the second."""
    half = len(inputs) // 2
    first_half, estimate = (
        check_estimate(name, task, len(values), *mean_and_std(predict(values.copy())))
        for values in (inputs[:half], inputs)
    )
    for full, begin in zip((estimate.mean, estimate.std), (first_half.mean, first_half.std), strict=True):
        if full is not None and begin is not None and not np.allclose(begin, full[:half], rtol=1e-6, atol=1e-9):
            raise InputError(name, f"estimate on {task.name}", "depends on later inputs", "must use past inputs only")
    return estimate


def mean_and_std(prediction: object) -> tuple[object, object]:
    """Mean and standard deviation of a prediction; None: no standard deviation."""
    return prediction if isinstance(prediction, tuple) and len(prediction) == 2 else (prediction, None)


def check_estimate(name: str, task: Question, samples: int, mean: object, std: object) -> Estimated:
    """Checks the estimates of a number of samples by the estimator `name`.

    Raises:
        InputError: if it has another shape, is not finite, or a standard deviation is negative.
    """
    shape = samples, len(task.outputs)
    means = _array(name, task, "mean", mean, shape)
    if std is None:
        return Estimated(means, None)
    stds = _array(name, task, "std", std, shape)
    if (stds < 0).any():
        raise InputError(name, f"std on {task.name}", float(stds.min()), "must not be negative")
    return Estimated(means, stds)


def _array(name: str, task: Question, quantity: str, value: object, shape: tuple[int, int]) -> Array:
    try:
        array = np.asarray(value, dtype=float)
    except (TypeError, ValueError, OverflowError):
        raise InputError(name, f"{quantity} on {task.name}", type(value).__name__, f"must be numbers {shape}") from None
    if array.shape != shape:
        raise InputError(name, f"shape of {quantity} on {task.name}", array.shape, f"must be {shape}")
    if not (np.abs(array) < _MAX_NUMBER).all():
        expected = f"must be finite, and below {_MAX_NUMBER:g}"
        raise InputError(name, f"{quantity} on {task.name}", float(array[~(np.abs(array) < _MAX_NUMBER)][0]), expected)
    return array
