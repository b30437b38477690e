"""Which object is held: the features of a grasp, the discriminant of object shapes, its training and its file.

The model is regularised quadratic discriminant analysis on principal components; its file is JSON.
"""

import json
from collections.abc import Sequence
from dataclasses import asdict, dataclass, fields
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from soft_gripper.arrays import Array
from soft_gripper.errors import InputError
from soft_gripper.files.output import atomic_file
from soft_gripper.files.text import read_text
from soft_gripper.scenario.model_files import model_path


def grasp_features(angles: Array, torques: Array) -> Array:
    """The features of grasps, (..., 4 L N): means over the fingers, and standard deviations between them.

    Args:
        angles: estimated joint angles at every level of pressure, rad, (..., L, F, N).
        torques: estimated external torques, N m, (..., L, F, N).
    """
    both = np.concatenate([angles, torques], axis=-1)  # (..., L, F, 2N)
    found = np.concatenate([both.mean(axis=-2), both.std(axis=-2)], axis=-1)
    return found.reshape(*found.shape[:-2], -1)


@dataclass(frozen=True)
class ObjectClassifier:
    """A quadratic discriminant of grasp features: the most likely shape of the object, if all are equally common.

    The features are projected onto D components; in those the grasps of each shape are normally distributed. An object
    of no known shape has the same density everywhere, that of the most compact shape where its squared distance from
    the mean is `limit`.

    Raises:
        InputError: if sizes do not fit, or a number is not finite.
    """

    shapes: tuple[str, ...]  # of the objects, names, (C)
    fingers: int
    joints: int  # of each finger, N
    sections: int  # of the sensors that it was trained with
    pressures: Array  # at which it takes samples, Pa, (L)
    center: Array  # of the features, (K) with K = 4 L N
    components: Array  # (D, K)
    means: Array  # of the shapes, (C, D)
    covariances: Array  # of the shapes, (C, D, D)
    limit: float  # squared Mahalanobis distance; see above

    @property
    def answers(self) -> tuple[str, ...]:
        """Answers that are possible: the shapes, and then `UNKNOWN`."""
        return (*self.shapes, UNKNOWN)

    def __post_init__(self) -> None:
        levels, shapes, size = self.pressures.size, len(self.shapes), len(self.components)
        features = 4 * levels * self.joints
        expected = {
            "pressures": (levels,),
            "center": (features,),
            "components": (size, features),
            "means": (shapes, size),
            "covariances": (shapes, size, size),
        }
        for name, shape in expected.items():
            found = getattr(self, name)
            if found.shape != shape:
                raise InputError("object classifier", name, f"an array {found.shape}", f"give one of {shape}")
            if not np.isfinite(found).all():
                raise InputError("object classifier", name, "NaN or infinite", "give finite numbers")
        if not (self.pressures > 0).all():
            raise InputError("object classifier", "pressures", self.pressures.tolist(), "give pressures above 0, Pa")
        if not (np.isfinite(self.limit) and self.limit > 0):
            raise InputError("object classifier", "limit", self.limit, "give a number above 0")
        if not (np.linalg.eigvalsh(self.covariances) > 0).all():
            raise InputError("object classifier", "covariances", "...", "give matrices that are positive definite")

    def probabilities(self, angles: Array, torques: Array) -> Array:
        """Probabilities of the `answers`, (..., C + 1), from the arguments of `grasp_features`; NaN if one is."""
        scores = self.scores(angles, torques)
        outside = np.full((*scores.shape[:-1], 1), -0.5 * (self.limit + self._volumes.min()))
        scores = np.concatenate([scores, outside], axis=-1)
        likelihoods = np.exp(scores - scores.max(axis=-1, keepdims=True))
        found: Array = likelihoods / likelihoods.sum(axis=-1, keepdims=True)
        return np.where(np.isnan(scores).any(axis=-1, keepdims=True), np.nan, found)

    def scores(self, angles: Array, torques: Array) -> Array:
        """Logarithms of the densities of the shapes, up to a constant, (..., C)."""
        parts = (grasp_features(angles, torques) - self.center) @ self.components.T
        from_means = parts[..., None, :] - self.means
        distances = ((from_means[..., None, :] @ self._precisions)[..., 0, :] * from_means).sum(axis=-1)
        return np.asarray(-0.5 * (distances + self._volumes))

    def outside(self, angles: Array, torques: Array) -> Array:
        """The least limit with which a grasp is of a known shape, (...)."""
        return np.asarray(-2 * self.scores(angles, torques).max(axis=-1) - self._volumes.min())

    @cached_property
    def _volumes(self) -> Array:
        return np.asarray(np.linalg.slogdet(self.covariances).logabsdet)

    @cached_property
    def _precisions(self) -> Array:
        return np.linalg.inv(self.covariances)


UNKNOWN = "unknown"  # the answer for an object of another shape
LOST = 0.05  # of grasps of known shapes that are taken for unknown
_UNTESTED = 1e3  # limit if there are too few grasps to leave any out
_FOLDS = 5  # of the training grasps, each left out once to find the limit
COMPONENTS = 24  # principal ones of the standardised features, at most
SHRINKAGE = 0.1  # of the covariance of a shape, toward that of all
_LEAST = 1e-6  # variance within a shape, of the whole along a component


def train_object_classifier(
    labels: Sequence[str],
    angles: Array,
    torques: Array,
    pressures: Sequence[float],
    sections: int,
    grasps: Sequence[int] | None = None,
) -> ObjectClassifier:
    """The quadratic discriminant of M samples of grasps.

    The limit is such that `LOST` of the samples would be unknown to a discriminant trained without their grasps.

    Args:
        labels: the shape of each sample, (M).
        angles: estimated joint angles at every level of pressure, rad, (M, L, F, N).
        torques: estimated external torques, N m, (M, L, F, N).
        pressures: of the levels, Pa, (L).
        sections: of the sensors behind the estimates.
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
    folds = np.asarray(range(len(angles)) if grasps is None else grasps) % _FOLDS
    levels = np.array(pressures, dtype=float)

    def trained(chosen: NDArray[np.bool_], limit: float) -> ObjectClassifier:
        discriminant = _discriminant(features[chosen], names[chosen], shapes)
        fingers, joints = angles.shape[-2:]
        return ObjectClassifier(shapes, fingers, joints, sections, levels, *discriminant, limit)

    outside = np.full(len(angles), np.nan)
    for fold in range(_FOLDS):
        left_out = folds == fold
        if all((names[~left_out] == shape).sum() > 1 for shape in shapes):
            outside[left_out] = trained(~left_out, 1.0).outside(angles[left_out], torques[left_out])
    limit = np.nanquantile(outside, 1 - LOST) if np.isfinite(outside).any() else _UNTESTED
    return trained(np.ones(len(angles), dtype=bool), max(float(limit), 1.0))


def _discriminant(features: Array, names: Array, shapes: Sequence[str]) -> tuple[Array, Array, Array, Array]:
    """Centre and components of the features, and the means and covariances of the shapes."""
    center, components = principal_components(features)
    parts = (features - center) @ components.T
    means = np.array([parts[names == shape].mean(axis=0) for shape in shapes])
    residuals = parts - means[[list(shapes).index(name) for name in names]]
    covariances = np.array([_covariance(residuals[names == shape]) for shape in shapes])
    shrunk = (1 - SHRINKAGE) * covariances + SHRINKAGE * _covariance(residuals) + _LEAST * np.eye(len(components))
    return center, components, means, shrunk


def principal_components(features: Array) -> tuple[Array, Array]:
    """Centre (K) and components (D, K) of features (M, K): projections onto them have variance 1.

    The features are standardised first, so that radians and newton metres count alike; one that does not vary does not
    count.
    """
    center, scale = features.mean(axis=0), features.std(axis=0)
    scale[scale < 1e-12 * np.abs(features).max()] = np.inf
    _, sizes, directions = np.linalg.svd((features - center) / scale, full_matrices=False)
    number = min(COMPONENTS, int((sizes > 1e-9 * sizes[0]).sum()))
    deviations = sizes[:number, None] / np.sqrt(len(features))
    return center, directions[:number] / deviations / scale


def _covariance(residuals: Array) -> Array:
    """Covariance of residuals (M, D) about a mean, (D, D)."""
    found: Array = residuals.T @ residuals / len(residuals)
    return found


_DIGITS = 9  # of a weight


def save_object_classifier(model: ObjectClassifier, path: Path) -> None:
    """Writes a model, one line per field."""
    content = {
        name: value.tolist() if isinstance(value, np.ndarray) else value for name, value in asdict(model).items()
    }
    lines = (f"  {json.dumps(name)}: {json.dumps(_rounded(value))}" for name, value in content.items())
    with atomic_file(path) as partial:
        partial.write_text("{\n" + ",\n".join(lines) + "\n}\n", encoding="utf-8")


def load_object_classifier(file: Path | str) -> ObjectClassifier:
    """Reads what `save_object_classifier` wrote.

    Args:
        file: a path or package://soft_gripper/... URI.

    Raises:
        InputError: if the file is missing, is not an object classifier, or its contents do not fit.
    """
    path = model_path(str(file))
    text = read_text(path)
    try:
        content = json.loads(text)
    except (ValueError, RecursionError):
        raise InputError(path, "file", path.name, "is not JSON") from None
    names = [field.name for field in fields(ObjectClassifier)]
    if not isinstance(content, dict) or sorted(content) != sorted(names):
        found = list(content) if isinstance(content, dict) else type(content).__name__
        raise InputError(path, "fields", found, f"an object classifier has: {', '.join(names)}")
    try:
        return ObjectClassifier(**{name: _value(name, content[name]) for name in names})
    except InputError as error:
        raise error.inside(path) from None


def _value(name: str, value: Any) -> Any:
    """A field from its JSON value."""
    try:
        if name in ("fingers", "joints", "sections"):
            return int(value)
        if name == "limit":
            return float(value)
        return tuple(map(str, value)) if name == "shapes" else np.array(value, dtype=float)
    except (TypeError, ValueError):
        whole = "give a whole number" if name in ("fingers", "joints", "sections") else "give a list, as it was saved"
        expected = "give a number" if name == "limit" else whole
        raise InputError("object classifier", name, value, expected) from None


def _rounded(value: Any) -> Any:
    if isinstance(value, list):
        return [_rounded(entry) for entry in value]
    return float(f"{value:.{_DIGITS}g}") if isinstance(value, float) else value
