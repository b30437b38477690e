"""What a grasp shows of the shape that is held, and the discriminant by which shapes are told apart."""

from dataclasses import dataclass

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
    """A linear discriminant of grasp features; which shape is likeliest, if all are equally common.

    The score of a shape is the product of its weights with the features, and its bias; the probabilities are the
    softmax of the scores.

    Raises:
        InputError: if something does not fit, or is not finite.
    """

    shapes: tuple[str, ...]  # names, (C)
    fingers: int
    joints: int  # of each finger, N
    sections: int  # of the sensors that it was trained with
    pressures: Array  # at which it takes samples, Pa, (L)
    weights: Array  # (C, K)
    biases: Array  # (C)

    def __post_init__(self) -> None:
        levels, shapes = self.pressures.size, len(self.shapes)
        sizes = {"pressures": (levels,), "weights": (shapes, 4 * levels * self.joints), "biases": (shapes,)}
        for name, shape in sizes.items():
            found = getattr(self, name)
            if found.shape != shape:
                raise InputError("shape model", name, f"an array {found.shape}", f"give one of {shape}")
            if not np.isfinite(found).all():
                raise InputError("shape model", name, "NaN or infinite", "give finite numbers")

    def probabilities(self, angles: Array, torques: Array) -> Array:
        """Of the shapes, (..., C), from what `grasp_features` takes; NaN if something in it is."""
        scores = grasp_features(angles, torques) @ self.weights.T + self.biases
        likelihoods = np.exp(scores - scores.max(axis=-1, keepdims=True))
        found: Array = likelihoods / likelihoods.sum(axis=-1, keepdims=True)
        return found
