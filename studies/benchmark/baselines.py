"""Baselines of the benchmark: functions of a task and its training set that return `predict`; see `baselines`."""

from collections.abc import Callable, Iterable, Sequence

import numpy as np
from scipy.spatial import cKDTree

from soft_gripper.arrays import Array
from soft_gripper.extras.hardware.scoring import Split, predictions
from studies.benchmark.benchmark_task import Estimator, Predict, Question, Recorded

Mean = Callable[[Array], Array]
Fit = Callable[[Sequence[Recorded]], Mean]

_RIDGE_PENALTY = 1e-3  # of scaled features, per sample
_NEIGHBOURS = 8
_FITTED_SHARE = 0.8  # share of each recording that is fitted; the rest gives the error


def ridge(task: Question, train: Sequence[Recorded]) -> Predict:
    """Ridge regression on inputs, their squares and products; one standard deviation per output."""
    return _fit_with_std(_fit_quadratic, train)


def recurrent(task: Question, train: Sequence[Recorded]) -> Predict:
    """A small recurrent network; one standard deviation per output.

    An echo state network: neurons with fixed random weights, of which only the linear readout is trained, by ridge
    regression (Jaeger, GMD report 148, 2001). Their time constants are spread from one sample to a hundred, since soft
    bodies swing and creep (leaky neurons: Lukosevicius, "A practical guide to applying echo state networks", 2012).
    """
    return _fit_with_std(_fit_echo_state, train)


def _fit_with_std(fit: Fit, train: Sequence[Recorded]) -> Predict:
    """Fits the training set; its errors are those of a fit to the begin of every recording in its end."""
    heads, tails = (
        [recorded.part(*ends) for recorded in train] for ends in ((0.0, _FITTED_SHARE), (_FITTED_SHARE, 1.0))
    )
    return add_stds(fit(train), predictions([Split(heads, tails)], lambda fitted: error_function(fit(fitted))))


def error_function(mean: Mean) -> Callable[[Recorded], Array]:
    """Function of a recording that gives the errors of a model, (T, m)."""
    return lambda recorded: mean(recorded.inputs) - recorded.outputs


def add_stds(mean: Mean, errors: Iterable[Array]) -> Predict:
    """Adds the standard deviations of errors (T, m) to the estimates of a model."""
    std = np.sqrt((np.vstack(list(errors)) ** 2).mean(axis=0))

    def predict(inputs: Array) -> tuple[Array, Array]:
        estimate = mean(inputs)
        return estimate, np.broadcast_to(std, estimate.shape)

    return predict


def _fit_quadratic(train: Sequence[Recorded]) -> Mean:
    center, scale = _input_scales(train)
    return _fit_linear(train, lambda inputs: _quadratic((inputs - center) / scale))


_NEURON_COUNT, _SEED = 200, 0
_SPECTRAL_RADIUS, _INPUT_SCALE = 0.9, 0.5  # spectral radius of the weights, and size of the scaled inputs
_MAX_TIME_CONSTANT = 100  # samples: longest time constant, and warm-up with the first inputs


def _fit_echo_state(train: Sequence[Recorded]) -> Mean:
    center, scale = _input_scales(train)
    random = np.random.default_rng(_SEED)
    weights = random.normal(size=(_NEURON_COUNT, _NEURON_COUNT))
    weights *= _SPECTRAL_RADIUS / np.abs(np.linalg.eigvals(weights)).max()
    inward = random.uniform(-_INPUT_SCALE, _INPUT_SCALE, (_NEURON_COUNT, len(center) + 1))
    leak = np.geomspace(1 / _MAX_TIME_CONSTANT, 1.0, _NEURON_COUNT)

    def states(inputs: Array) -> Array:
        scaled = (inputs - center) / scale
        started_inputs = np.vstack([np.repeat(scaled[:1], _MAX_TIME_CONSTANT, axis=0), scaled])
        drives = np.hstack([started_inputs, np.ones((len(started_inputs), 1))]) @ inward.T
        all_states, state = np.zeros(drives.shape), np.zeros(_NEURON_COUNT)
        for row, drive in zip(all_states, drives, strict=True):
            state = state + leak * (np.tanh(drive + weights @ state) - state)
            row[:] = state
        return np.hstack([scaled, all_states[_MAX_TIME_CONSTANT:]])

    return _fit_linear(train, states)


def _fit_linear(train: Sequence[Recorded], features: Mean) -> Mean:
    """Ridge regression on features of single recordings."""
    design, outputs = np.vstack([features(r.inputs) for r in train]), np.vstack([r.outputs for r in train])
    middle, offset = design.mean(axis=0), outputs.mean(axis=0)
    design -= middle  # so that the constant is not penalized
    normal = design.T @ design + _RIDGE_PENALTY * len(design) * np.eye(design.shape[1])
    weights = np.linalg.solve(normal, design.T @ (outputs - offset))
    return lambda inputs: offset + (features(inputs) - middle) @ weights


def _quadratic(inputs: Array) -> Array:
    row, column = np.triu_indices(inputs.shape[1])
    return np.hstack([inputs, inputs[:, row] * inputs[:, column]])


def _input_scales(train: Sequence[Recorded]) -> tuple[Array, Array]:
    """Mean and standard deviation of every input; 1 if it does not vary."""
    inputs = np.vstack([r.inputs for r in train])
    std: Array = inputs.std(axis=0)
    return inputs.mean(axis=0), np.where(std > 0, std, 1.0)


def nearest(task: Question, train: Sequence[Recorded]) -> Predict:
    """Mean and standard deviation of the nearest training samples, inputs scaled to equal spread."""
    inputs, outputs = np.vstack([r.inputs for r in train]), np.vstack([r.outputs for r in train])
    _, scale = _input_scales(train)
    tree = cKDTree(inputs / scale)

    def predict(test_inputs: Array) -> tuple[Array, Array]:
        neighbours = outputs[tree.query(test_inputs / scale, range(1, min(_NEIGHBOURS, len(outputs)) + 1))[1]]
        return neighbours.mean(axis=1), neighbours.std(axis=1)

    return predict


def baselines(task: Question) -> dict[str, Estimator]:
    """Baselines of a task; the recurrent one if samples follow each other."""
    estimators: dict[str, Estimator] = {"ridge": ridge, "nearest": nearest}
    return estimators if task.period is None else estimators | {"recurrent": recurrent}
