"""What a grasp shows of the shape that is held, and the discriminant by which shapes are distinguished."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from soft_gripper.arrays import Array
from soft_gripper.errors import InputError


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
class ShapeModel:
    """A quadratic discriminant of grasp features; which shape is likeliest, if all are equally common.

    The features are projected onto D components; in those the grasps of each shape are normally distributed.

    Raises:
        InputError: if something does not fit, or is not finite.
    """

    shapes: tuple[str, ...]  # names, (C)
    fingers: int
    joints: int  # of each finger, N
    sections: int  # of the sensors that it was trained with
    pressures: Array  # at which it takes samples, Pa, (L)
    center: Array  # of the features, (K) with K = 4 L N
    components: Array  # (D, K)
    means: Array  # of the shapes, (C, D)
    covariances: Array  # of the shapes, (C, D, D)

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
                raise InputError("shape model", name, f"an array {found.shape}", f"give one of {shape}")
            if not np.isfinite(found).all():
                raise InputError("shape model", name, "NaN or infinite", "give finite numbers")
        if not (self.pressures > 0).all():
            raise InputError("shape model", "pressures", self.pressures.tolist(), "give pressures above 0, Pa")
        if not (np.linalg.eigvalsh(self.covariances) > 0).all():
            raise InputError("shape model", "covariances", "...", "give matrices that are positive definite")

    def probabilities(self, angles: Array, torques: Array) -> Array:
        """Of the shapes, (..., C), from what `grasp_features` takes; NaN if something in it is."""
        parts = (grasp_features(angles, torques) - self.center) @ self.components.T
        from_means = parts[..., None, :] - self.means
        distances = ((from_means[..., None, :] @ self._precisions)[..., 0, :] * from_means).sum(axis=-1)
        scores = -0.5 * (distances + np.linalg.slogdet(self.covariances).logabsdet)
        likelihoods = np.exp(scores - scores.max(axis=-1, keepdims=True))
        found: Array = likelihoods / likelihoods.sum(axis=-1, keepdims=True)
        return found

    @cached_property
    def _precisions(self) -> Array:
        return np.linalg.inv(self.covariances)
