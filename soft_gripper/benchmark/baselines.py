"""Baselines of the benchmark. An estimator is a function of a task and its training set that returns `predict`."""

from collections.abc import Callable, Sequence

import numpy as np
from scipy.spatial import cKDTree

from soft_gripper.arrays import Array
from soft_gripper.benchmark.tasks import Recorded, Task

Predict = Callable[[Array], Array | tuple[Array, Array]]  # (T, n) -> mean (T, m), or mean and std
Estimator = Callable[[Task, Sequence[Recorded]], Predict]

_PENALTY = 1e-3  # of scaled inputs, a sample
_NEIGHBOURS = 8
_FITTED = 0.8  # share of each recording; the rest measures the error


def ridge(task: Task, train: Sequence[Recorded]) -> Predict:
    """Ridge regression on inputs, their squares and products; one standard deviation per output."""
    begin = [_until(recorded, _FITTED) for recorded in train]
    rest = [recorded.inputs[len(first.inputs) :] for recorded, first in zip(train, begin, strict=True)]
    truth = [recorded.outputs[len(first.outputs) :] for recorded, first in zip(train, begin, strict=True)]
    errors = _ridge(begin)(np.vstack(rest)) - np.vstack(truth)
    std, fitted = np.sqrt((errors**2).mean(axis=0)), _ridge(train)

    def predict(inputs: Array) -> tuple[Array, Array]:
        mean = fitted(inputs)
        return mean, np.broadcast_to(std, mean.shape)

    return predict


def _until(recorded: Recorded, share: float) -> Recorded:
    end = round(share * len(recorded.inputs))
    return Recorded(recorded.inputs[:end], recorded.outputs[:end])


def _ridge(train: Sequence[Recorded]) -> Callable[[Array], Array]:
    inputs, outputs = np.vstack([r.inputs for r in train]), np.vstack([r.outputs for r in train])
    center, scale, offset = inputs.mean(axis=0), _scale(inputs), outputs.mean(axis=0)
    features = _quadratic((inputs - center) / scale)
    middle = features.mean(axis=0)
    features -= middle  # so that the constant is not penalized
    normal = features.T @ features + _PENALTY * len(inputs) * np.eye(features.shape[1])
    weights = np.linalg.solve(normal, features.T @ (outputs - offset))
    return lambda new: offset + (_quadratic((new - center) / scale) - middle) @ weights


def _quadratic(inputs: Array) -> Array:
    row, column = np.triu_indices(inputs.shape[1])
    return np.hstack([inputs, inputs[:, row] * inputs[:, column]])


def _scale(inputs: Array) -> Array:
    std: Array = inputs.std(axis=0)
    return np.where(std > 0, std, 1.0)


def nearest(task: Task, train: Sequence[Recorded]) -> Predict:
    """Mean and standard deviation of the nearest training samples, inputs scaled to equal spread."""
    inputs, outputs = np.vstack([r.inputs for r in train]), np.vstack([r.outputs for r in train])
    scale = _scale(inputs)
    tree = cKDTree(inputs / scale)

    def predict(new: Array) -> tuple[Array, Array]:
        near = outputs[tree.query(new / scale, _NEIGHBOURS)[1]]
        return near.mean(axis=1), near.std(axis=1)

    return predict


BASELINES: dict[str, Estimator] = {"ridge": ridge, "nearest": nearest}
