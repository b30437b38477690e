"""A shape model from labelled grasps: regularised quadratic discriminant analysis on principal components."""

from collections.abc import Sequence

import numpy as np

from soft_gripper.arrays import Array
from soft_gripper.errors import InputError
from soft_gripper.recognition.model import ShapeModel, grasp_features

COMPONENTS = 24  # principal ones of the standardised features, at most
SHRINKAGE = 0.1  # of the covariance of a shape, toward that of all
_LEAST = 1e-6  # variance within a shape, of the whole along a component


def train_shape_model(
    labels: Sequence[str], angles: Array, torques: Array, pressures: Sequence[float], sections: int
) -> ShapeModel:
    """The quadratic discriminant of M grasps.

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
    center, components = principal_components(features)
    parts = (features - center) @ components.T
    means = np.array([parts[names == shape].mean(axis=0) for shape in shapes])
    residuals = parts - means[[shapes.index(label) for label in labels]]
    covariances = np.array([_covariance(residuals[names == shape]) for shape in shapes])
    shrunk = (1 - SHRINKAGE) * covariances + SHRINKAGE * _covariance(residuals) + _LEAST * np.eye(len(components))
    fingers, joints = angles.shape[-2:]
    levels = np.array(pressures, dtype=float)
    return ShapeModel(shapes, fingers, joints, sections, levels, center, components, means, shrunk)


def principal_components(features: Array) -> tuple[Array, Array]:
    """Centre (K) and components (D, K) of features (M, K): their products with what is off the centre vary by 1.

    The features are standardised first, so that radians and newton metres count alike; one that does not vary counts
    for nothing.
    """
    center, scale = features.mean(axis=0), features.std(axis=0)
    scale[scale < 1e-12 * np.abs(features).max()] = np.inf
    _, sizes, directions = np.linalg.svd((features - center) / scale, full_matrices=False)
    number = min(COMPONENTS, int((sizes > 1e-9 * sizes[0]).sum()))
    deviations = sizes[:number, None] / np.sqrt(len(features))
    return center, directions[:number] / deviations / scale


def _covariance(residuals: Array) -> Array:
    """Of residuals (M, D) about a mean, (D, D)."""
    found: Array = residuals.T @ residuals / len(residuals)
    return found
