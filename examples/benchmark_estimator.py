"""Estimators for the benchmark: `python -m studies benchmark benchmark_estimator:linear`, in this folder."""

import numpy as np


def linear(task, train, features=lambda inputs: inputs):
    """Linear regression on the training samples; its stated deviations are those of the residuals.

    In recognition its outputs are the probabilities of the shapes, and what is missing to 1 is that of another one.
    """
    inputs = np.vstack([features(recorded.inputs) for recorded in train])  # (T, n), in the units of task.inputs
    outputs = np.vstack([recorded.outputs for recorded in train])  # (T, m), in the units of task.outputs

    def with_constant(inputs):
        return np.hstack([inputs, np.ones((len(inputs), 1))])

    weights = np.linalg.lstsq(with_constant(inputs), outputs, rcond=None)[0]
    std = (outputs - with_constant(inputs) @ weights).std(axis=0)

    def predict(inputs):
        mean = with_constant(features(inputs)) @ weights
        return mean, np.broadcast_to(std, mean.shape)

    return predict


def with_memory(task, train, time=0.3):
    """Linear regression on inputs and their means over some past time, s, where samples follow each other."""
    weight = 1.0 if task.period is None else min(task.period / time, 1.0)

    def add_means(inputs):
        means = [inputs[0]]
        for sample in inputs[1:]:
            means.append(means[-1] + weight * (sample - means[-1]))
        return np.hstack([inputs, means])

    return linear(task, train, add_means)
