"""Recognizes a grasped object by regularised quadratic discriminant analysis on principal components of a grasp.

Joint angles, rad, and external torques, N m, of N joints of F fingers at L pressures, (..., L, F, N) each, give the
probabilities of C shapes and of none of them, (..., C + 1).
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from soft_gripper.arrays import Array
from soft_gripper.errors import InputError
from soft_gripper.extras.hardware.scoring import leave_groups_out


def grasp_features(angles: Array, torques: Array) -> Array:
    """Features of grasps, (..., 4 L N): means over the fingers, and standard deviations between them.

    Args:
        angles: estimated joint angles at every level of pressure, rad, (..., L, F, N).
        torques: estimated external torques, N m, (..., L, F, N).
    """
    signals = np.concatenate([angles, torques], axis=-1)  # (..., L, F, 2N)
    features = np.concatenate([signals.mean(axis=-2), signals.std(axis=-2)], axis=-1)
    return features.reshape(*features.shape[:-2], -1)


@dataclass(frozen=True)
class ObjectClassifier:
    """A quadratic discriminant of grasp features: the most likely shape of the object, if all are equally common.

    The features are projected onto D components; in those the grasps of each shape are normally distributed. An object
    of no known shape has the same density everywhere, that of the most compact shape where its squared distance from
    the mean is `limit`.
    """

    shapes: tuple[str, ...]  # of the objects, names, (C)
    center: Array  # of the features, (K)
    components: Array  # (D, K)
    means: Array  # of the shapes, (C, D)
    covariances: Array  # of the shapes, (C, D, D)
    limit: float  # squared Mahalanobis distance; see above

    @property
    def answers(self) -> tuple[str, ...]:
        """Possible answers: the shapes, and then `NO_SHAPE`."""
        return (*self.shapes, NO_SHAPE)

    def probabilities(self, angles: Array, torques: Array) -> Array:
        """Probabilities of the `answers`, (..., C + 1), from the arguments of `grasp_features`; NaN if one is."""
        scores = self.scores(angles, torques)
        outside = np.full((*scores.shape[:-1], 1), -0.5 * (self.limit + self._volumes.min()))
        scores = np.concatenate([scores, outside], axis=-1)
        likelihoods = np.exp(scores - scores.max(axis=-1, keepdims=True))
        probabilities_: Array = likelihoods / likelihoods.sum(axis=-1, keepdims=True)
        return np.where(np.isnan(scores).any(axis=-1, keepdims=True), np.nan, probabilities_)

    def scores(self, angles: Array, torques: Array) -> Array:
        """Logarithms of the densities of the shapes, up to a constant, (..., C)."""
        projections = (grasp_features(angles, torques) - self.center) @ self.components.T
        differences = projections[..., None, :] - self.means
        distances = ((differences[..., None, :] @ self._precisions)[..., 0, :] * differences).sum(axis=-1)
        return np.asarray(-0.5 * (distances + self._volumes))

    def least_limit(self, angles: Array, torques: Array) -> Array:
        """Least limit with which a grasp has a known shape, (...)."""
        return np.asarray(-2 * self.scores(angles, torques).max(axis=-1) - self._volumes.min())

    @cached_property
    def _volumes(self) -> Array:
        return np.asarray(np.linalg.slogdet(self.covariances).logabsdet)

    @cached_property
    def _precisions(self) -> Array:
        return np.linalg.inv(self.covariances)


NO_SHAPE = "unknown"  # the answer for an object of another shape
LOST_SHARE = 0.05  # of grasps of known shapes that are taken for unknown
_UNTESTED_LIMIT = 1e3  # limit if there are too few grasps to leave any out
_FOLD_COUNT = 5  # of the training grasps, each left out once to find the limit
MAX_COMPONENTS = 24  # principal ones of the standardised features, at most
SHRINKAGE = 0.1  # of the covariance of a shape, toward that of all
_MIN_VARIANCE = 1e-6  # variance within a shape, of the whole along a component


def train_object_classifier(
    labels: Sequence[str],
    angles: Array,
    torques: Array,
    grasps: Sequence[int] | None = None,
) -> ObjectClassifier:
    """Trains the quadratic discriminant on M samples of grasps.

    The limit is such that `LOST_SHARE` of the samples would be unknown to a discriminant trained without their grasps.

    Args:
        labels: the shape of each sample, (M).
        angles: estimated joint angles at every level of pressure, rad, (M, L, F, N).
        torques: estimated external torques, N m, (M, L, F, N).
        grasps: number of the grasp of each sample, (M); None: each is another one.

    Raises:
        InputError: unless there are two shapes or more, each with two samples or more, all of them finite.
    """
    features, names = grasp_features(angles, torques), np.array(labels)
    shapes = tuple(dict.fromkeys(labels))
    if len(shapes) < 2 or min(labels.count(shape) for shape in shapes) < 2:
        counts = {shape: labels.count(shape) for shape in shapes}
        raise InputError(
            "object classifier", "grasps", counts, "give two shapes or more, and two grasps or more of each"
        )
    if not np.isfinite(features).all():
        bad = int(np.argmin(np.isfinite(features).all(axis=-1)))
        raise InputError("object classifier", f"grasps[{bad}]", "NaN or infinite", "give finite angles and torques")
    fold_numbers = np.asarray(range(len(angles)) if grasps is None else grasps) % _FOLD_COUNT

    def train(mask: NDArray[np.bool_], limit: float) -> ObjectClassifier:
        discriminant = _discriminant(features[mask], names[mask], shapes)
        return ObjectClassifier(shapes, *discriminant, limit)

    limits = np.full(len(angles), np.nan)
    for (fitted_rows,) in leave_groups_out([fold_numbers.astype(str)]):
        if all((names[fitted_rows] == shape).sum() > 1 for shape in shapes):
            limits[~fitted_rows] = train(fitted_rows, 1.0).least_limit(angles[~fitted_rows], torques[~fitted_rows])
    limit = np.nanquantile(limits, 1 - LOST_SHARE) if np.isfinite(limits).any() else _UNTESTED_LIMIT
    return train(np.ones(len(angles), dtype=bool), max(float(limit), 1.0))


def _discriminant(features: Array, names: Array, shapes: Sequence[str]) -> tuple[Array, Array, Array, Array]:
    """Centre and components of the features, and the means and covariances of the shapes."""
    center, components = principal_components(features)
    projections = (features - center) @ components.T
    means = np.array([projections[names == shape].mean(axis=0) for shape in shapes])
    residuals = projections - means[[list(shapes).index(name) for name in names]]
    covariances = np.array([_covariance(residuals[names == shape]) for shape in shapes])
    shrunk_covariances = (
        (1 - SHRINKAGE) * covariances + SHRINKAGE * _covariance(residuals) + _MIN_VARIANCE * np.eye(len(components))
    )
    return center, components, means, shrunk_covariances


def principal_components(features: Array) -> tuple[Array, Array]:
    """Centre (K) and components (D, K) of features (M, K): projections onto them have variance 1.

    The features are standardised first, so that radians and newton metres count alike; one that does not vary does not
    count.
    """
    center, scale = features.mean(axis=0), features.std(axis=0)
    scale[scale < 1e-12 * np.abs(features).max()] = np.inf
    _, sizes, directions = np.linalg.svd((features - center) / scale, full_matrices=False)
    number = min(MAX_COMPONENTS, int((sizes > 1e-9 * sizes[0]).sum()))
    deviations = sizes[:number, None] / np.sqrt(len(features))
    return center, directions[:number] / deviations / scale


def _covariance(residuals: Array) -> Array:
    """Covariance of residuals (M, D) about a mean, (D, D)."""
    return residuals.T @ residuals / len(residuals)
