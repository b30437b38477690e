"""Computes functions of many samples a few at a time, so that their arrays fit into a processor's cache.

`map_batches` passes arrays (..., n) to a function as (M, n), and joins its results to (..., m).

For few samples, slow results are computed only when read (`LazyArray`), and once for all readers (`memoized`): several
outputs of a block share them, and none waits for outputs that nobody reads.
"""

from collections import OrderedDict
from collections.abc import Callable
from functools import cached_property
from typing import Any, Generic, TypeVar

import numpy as np

from soft_gripper.arrays import Array
from soft_gripper.cached import get_or_make

_BATCH_SIZE = 60  # samples computed together; strides of a power of two are slow
_MAX_SHARED_SAMPLES = 16  # of a call whose result is cached
_MAX_RESULTS = 8  # latest calls whose results are cached

_T = TypeVar("_T")
_results: OrderedDict[Any, Any] = OrderedDict()


class LazyArray(Generic[_T]):
    """An array, or several, computed when first read."""

    def __init__(self, compute: Callable[[], _T]):
        self._compute = compute

    @cached_property
    def value(self) -> _T:
        """The array, or the tuple of arrays."""
        return self._compute()


def memoized(function: Callable[..., _T], owner: object, *arrays: Array) -> _T:
    """Result of a function of an object and arrays, cached for equal arrays of few samples; do not change it."""
    if arrays[0].size > _MAX_SHARED_SAMPLES * arrays[0].shape[-1]:
        return function(owner, *arrays)
    key = function, id(owner), *((array.shape, array.tobytes()) for array in arrays)
    # The cache holds the owner with its result, so that no other object gets its id.
    cached: tuple[_T, object] = get_or_make(_results, key, lambda: (function(owner, *arrays), owner), _MAX_RESULTS)
    return cached[0]


def map_batches(function: Any, sample: Array, *arrays: Array) -> Any:
    """Calls a function of arrays with a single leading axis for a few samples at a time, and joins the results.

    All arrays have the leading axes of the first one, whose samples are vectors.
    """
    shape = sample.shape[:-1]
    flat_arrays = [values.reshape(-1, *values.shape[len(shape) :]) for values in (sample, *arrays)]
    begins = range(0, max(len(flat_arrays[0]), 1), _BATCH_SIZE)
    results = (function(*(values[begin : begin + _BATCH_SIZE] for values in flat_arrays)) for begin in begins)
    return _join([*results] if len(begins) == 1 else [_force_lazy(result) for result in results], shape)


def _force_lazy(part: Any) -> Any:
    """Computes all arrays of a result: a lazy one would keep its inputs in memory."""
    if isinstance(part, LazyArray):
        value = part.value
        return LazyArray(lambda: value)
    return type(part)(*map(_force_lazy, part)) if isinstance(part, tuple) else part


def _join(parts: list[Any], shape: tuple[int, ...]) -> Any:
    if parts[0] is None:
        return None
    if isinstance(parts[0], LazyArray):
        return LazyArray(lambda: _join([part.value for part in parts], shape))
    if isinstance(parts[0], np.ndarray):
        whole = np.concatenate(parts)
        return whole.reshape((*shape, *whole.shape[1:]))
    return type(parts[0])(*(_join(list(values), shape) for values in zip(*parts, strict=True)))
