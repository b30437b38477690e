"""Functions of many samples, computed a few at a time so that their arrays fit into a processor's cache."""

from typing import Any

import numpy as np

from soft_gripper.arrays import Array

_AT_ONCE = 16  # samples that are computed together


def in_parts(function: Any, sample: Array, *others: Array) -> Any:
    """The results of a function of arrays with a single leading axis, a few samples after the other.

    The leading axes of all arrays are those of the first one, of which a sample is a vector.
    """
    shape = sample.shape[:-1]
    flat = [each.reshape(-1, *each.shape[len(shape) :]) for each in (sample, *others)]
    parts = [function(*(each[at : at + _AT_ONCE] for each in flat)) for at in range(0, max(len(flat[0]), 1), _AT_ONCE)]
    return _put_together(parts, shape)


def _put_together(parts: list[Any], shape: tuple[int, ...]) -> Any:
    if parts[0] is None:
        return None
    if isinstance(parts[0], np.ndarray):
        joined = np.concatenate(parts)
        return joined.reshape((*shape, *joined.shape[1:]))
    return type(parts[0])(*(_put_together(list(each), shape) for each in zip(*parts, strict=True)))
