"""What the contact forces on the links of a finger say: where it touches something, and over what length."""

import numpy as np
from numpy.typing import NDArray

from soft_gripper.arrays import Array
from soft_gripper.fingers.finger import Finger

TOUCH = 1e-3  # N; a link touches something where it is pressed harder
STRAIGHT = 0.1  # 1/m; a joint bent less, to a radius above 10 m, is straight


def touches(force: Array) -> NDArray[np.bool_]:
    """Which links touch something, by the forces on them, (...) N."""
    return force > TOUCH


def contact_length(finger: Finger, touching: NDArray[np.bool_]) -> Array:
    """Length of finger that touches something, (..., N + 1) -> (...) m: the sum of the lengths of touching links."""
    length: Array = touching @ np.diff(finger.link_ends)
    return length


def changes_sign(finger: Finger, q: Array) -> NDArray[np.bool_]:
    """Whether the curvature of a finger changes its sign along it, joint angles (..., N) rad -> (...)."""
    curvature = q / finger.segment_length
    changes: NDArray[np.bool_] = (curvature.min(axis=-1) < -STRAIGHT) & (curvature.max(axis=-1) > STRAIGHT)
    return changes
