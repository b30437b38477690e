"""A delay of whole samples."""

import numpy as np

from soft_gripper.arrays import Array


def pass_delay_line(line: Array, present: Array) -> tuple[Array, Array]:
    """What is on its way after this sample, and what arrives with it.

    Args:
        line: what is on its way, (..., delay, R), from the oldest; NaN before the first sample, which is then what
            arrives until it has passed itself.
        present: what sets out, (..., R).

    Returns:
        the line after this sample, and (..., R) that arrives.
    """
    present = present[..., None, :]
    queue = np.concatenate([np.where(np.isnan(line), present, line), present], axis=-2)
    return queue[..., 1:, :], queue[..., 0, :]
