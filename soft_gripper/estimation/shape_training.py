"""A shape model from labelled grasps: linear discriminant analysis with a shrunk covariance."""

from collections.abc import Sequence

import numpy as np

from soft_gripper.arrays import Array
from soft_gripper.errors import InputError
from soft_gripper.estimation.shape_model import ShapeModel, grasp_features

SHRINKAGE = 1e-3  # of the covariance of standardised features, toward the identity


def train_shape_model(
    labels: Sequence[str], angles: Array, torques: Array, pressures: Sequence[float], sections: int
) -> ShapeModel:
    """The linear discriminant of M grasps.

    Args:
        labels: the shape of each grasp, (M).
        angles: estimated joint angles at every level of pressure, rad, (M, L, F, N).
        torques: estimated external torques, N m, (M, L, F, N).
        pressures: of the levels, Pa, (L).
        sections: of the sensors that the estimates are from.

    Raises:
        InputError: unless there are two shapes or more, each with two grasps or more, all of them finite.
    """
    features, names = grasp_features(angles, torques), np.array(labels)
    shapes = tuple(dict.fromkeys(labels))
    if len(shapes) < 2 or min(labels.count(shape) for shape in shapes) < 2:
        counts = {shape: labels.count(shape) for shape in shapes}
        raise InputError("shape model", "grasps", counts, "give two shapes or more, and two grasps or more of each")
    if not np.isfinite(features).all():
        bad = int(np.argmin(np.isfinite(features).all(axis=-1)))
        raise InputError("shape model", f"grasps[{bad}]", "NaN or infinite", "give finite angles and torques")
    means = np.array([features[names == shape].mean(axis=0) for shape in shapes])
    weights, biases = discriminant(means, features - means[[shapes.index(label) for label in labels]])
    fingers, joints = angles.shape[-2:]
    return ShapeModel(shapes, fingers, joints, sections, np.array(pressures, dtype=float), weights, biases)


def discriminant(means: Array, residuals: Array) -> tuple[Array, Array]:
    """Weights (C, K) and biases (C) from the means of the classes, (C, K), and the distances from them, (M, K).

    Features are standardised by their scatter within the classes; one that does not vary gets no weight.
    """
    scale = residuals.std(axis=0)
    scale[scale < 1e-12 * np.abs(means).max()] = np.inf
    spread = residuals / scale
    covariance = spread.T @ spread / (len(residuals) - len(means))
    shrunk = (1 - SHRINKAGE) * covariance + SHRINKAGE * np.eye(len(scale))
    weights = np.linalg.solve(shrunk, (means / scale).T).T / scale
    return weights, -0.5 * (weights * means).sum(axis=-1)
