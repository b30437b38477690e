"""Baselines of the benchmark. An estimator is a function of a task and its training set that returns `predict`."""

from collections.abc import Callable, Iterable, Sequence

import numpy as np
from scipy.spatial import cKDTree

from soft_gripper.arrays import Array
from soft_gripper.extras.hardware.scoring import Split, predictions
from studies.benchmark.benchmark_task import Estimator, Predict, Question, Recorded

Mean = Callable[[Array], Array]
Fit = Callable[[Sequence[Recorded]], Mean]

_PENALTY = 1e-3  # of scaled features, a sample
_NEIGHBOURS = 8
_FITTED = 0.8  # share of each recording; the rest measures the error


def ridge(task: Question, train: Sequence[Recorded]) -> Predict:
    """Ridge regression on inputs, their squares and products; one standard deviation per output."""
    return _with_std(_fit_quadratic, train)


def recurrent(task: Question, train: Sequence[Recorded]) -> Predict:
    """A small recurrent network; one standard deviation per output.

    An echo state network: neurons with fixed random weights, of which only the linear readout is trained, by ridge
    regression (Jaeger, GMD report 148, 2001). Their time constants are spread from one sample to a hundred, since soft
    bodies swing and creep (leaky neurons: Lukosevicius, "A practical guide to applying echo state networks", 2012).
    """
    return _with_std(_fit_echo_state, train)


def _with_std(fit: Fit, train: Sequence[Recorded]) -> Predict:
    """A fit to the training set; its errors are those of a fit to the begin of every recording in the rest of it."""
    begin, rest = ([recorded.part(*ends) for recorded in train] for ends in ((0.0, _FITTED), (_FITTED, 1.0)))
    return with_errors(fit(train), predictions([Split(begin, rest)], lambda fitted: errors_of(fit(fitted))))


def errors_of(mean: Mean) -> Callable[[Recorded], Array]:
    """Errors of a model in a recording, (T, m), as a function of the recording."""
    return lambda recorded: mean(recorded.inputs) - recorded.outputs


def with_errors(mean: Mean, errors: Iterable[Array]) -> Predict:
    """A model with the standard deviations of errors (T, m) in recordings of which the outputs are known."""
    std = np.sqrt((np.vstack(list(errors)) ** 2).mean(axis=0))

    def predict(inputs: Array) -> tuple[Array, Array]:
        found = mean(inputs)
        return found, np.broadcast_to(std, found.shape)

    return predict


def _fit_quadratic(train: Sequence[Recorded]) -> Mean:
    center, scale = _spread(train)
    return _fit_linear(train, lambda inputs: _quadratic((inputs - center) / scale))


_NEURONS, _SEED = 200, 0
_RADIUS, _DRIVE = 0.9, 0.5  # spectral radius of the weights, and size of the scaled inputs
_SLOWEST = 100  # samples: the longest time constant, and how long the first inputs are held before they count


def _fit_echo_state(train: Sequence[Recorded]) -> Mean:
    center, scale = _spread(train)
    random = np.random.default_rng(_SEED)
    weights = random.normal(size=(_NEURONS, _NEURONS))
    weights *= _RADIUS / np.abs(np.linalg.eigvals(weights)).max()
    inward = random.uniform(-_DRIVE, _DRIVE, (_NEURONS, len(center) + 1))
    leak = np.geomspace(1 / _SLOWEST, 1.0, _NEURONS)

    def states(inputs: Array) -> Array:
        scaled = (inputs - center) / scale
        held = np.vstack([np.repeat(scaled[:1], _SLOWEST, axis=0), scaled])
        driven = np.hstack([held, np.ones((len(held), 1))]) @ inward.T
        found, state = np.zeros(driven.shape), np.zeros(_NEURONS)
        for row, drive in zip(found, driven, strict=True):
            state = state + leak * (np.tanh(drive + weights @ state) - state)
            row[:] = state
        return np.hstack([scaled, found[_SLOWEST:]])

    return _fit_linear(train, states)


def _fit_linear(train: Sequence[Recorded], features: Mean) -> Mean:
    """Ridge regression on features of single recordings."""
    known, outputs = np.vstack([features(r.inputs) for r in train]), np.vstack([r.outputs for r in train])
    middle, offset = known.mean(axis=0), outputs.mean(axis=0)
    known -= middle  # so that the constant is not penalized
    normal = known.T @ known + _PENALTY * len(known) * np.eye(known.shape[1])
    weights = np.linalg.solve(normal, known.T @ (outputs - offset))
    return lambda inputs: offset + (features(inputs) - middle) @ weights


def _quadratic(inputs: Array) -> Array:
    row, column = np.triu_indices(inputs.shape[1])
    return np.hstack([inputs, inputs[:, row] * inputs[:, column]])


def _spread(train: Sequence[Recorded]) -> tuple[Array, Array]:
    """Mean and standard deviation of every input; 1 if it does not vary."""
    inputs = np.vstack([r.inputs for r in train])
    std: Array = inputs.std(axis=0)
    return inputs.mean(axis=0), np.where(std > 0, std, 1.0)


def nearest(task: Question, train: Sequence[Recorded]) -> Predict:
    """Mean and standard deviation of the nearest training samples, inputs scaled to equal spread."""
    inputs, outputs = np.vstack([r.inputs for r in train]), np.vstack([r.outputs for r in train])
    _, scale = _spread(train)
    tree = cKDTree(inputs / scale)

    def predict(new: Array) -> tuple[Array, Array]:
        near = outputs[tree.query(new / scale, range(1, min(_NEIGHBOURS, len(outputs)) + 1))[1]]
        return near.mean(axis=1), near.std(axis=1)

    return predict


def baselines(task: Question) -> dict[str, Estimator]:
    """Baselines of a task; the recurrent one where samples follow each other."""
    found: dict[str, Estimator] = {"ridge": ridge, "nearest": nearest}
    return found if task.period is None else found | {"recurrent": recurrent}
