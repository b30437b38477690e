"""Functions of many samples, computed a few at a time so that their arrays fit into a processor's cache.

Of few samples, what takes long is computed only if it is asked for (`Later`), and once for all who ask for it
(`shared`): a block has its answers from several functions, and a reading cannot wait for what nobody reads.
"""

from collections import OrderedDict
from collections.abc import Callable
from functools import cached_property
from typing import Any, Generic, TypeVar

import numpy as np

from soft_gripper.arrays import Array
from soft_gripper.cached import get_or_make

_BATCH_SIZE = 16  # samples that are computed together
_SHARED_RESULTS = 8  # of the latest calls

_T = TypeVar("_T")
_shared: OrderedDict[Any, Any] = OrderedDict()


class Later(Generic[_T]):
    """An array, or several, computed when they are first asked for."""

    def __init__(self, compute: Callable[[], _T]):
        self._compute = compute

    @cached_property
    def value(self) -> _T:
        """The array, or what holds them."""
        return self._compute()


def shared(function: Callable[..., _T], owner: object, *arrays: Array) -> _T:
    """A function of an object and arrays, computed once for equal arrays of few samples; nobody may change it."""
    if arrays[0].size > _BATCH_SIZE * arrays[0].shape[-1]:
        return function(owner, *arrays)
    key = function, id(owner), *((each.shape, each.tobytes()) for each in arrays)
    # The owner is kept with its result, so that nothing else gets its id.
    found: tuple[_T, object] = get_or_make(_shared, key, lambda: (function(owner, *arrays), owner), _SHARED_RESULTS)
    return found[0]


def in_parts(function: Any, sample: Array, *others: Array) -> Any:
    """The results of a function of arrays with a single leading axis, a few samples after the other.

    The leading axes of all arrays are those of the first one, of which a sample is a vector.
    """
    shape = sample.shape[:-1]
    flat = [each.reshape(-1, *each.shape[len(shape) :]) for each in (sample, *others)]
    begins = range(0, max(len(flat[0]), 1), _BATCH_SIZE)
    parts = (function(*(each[begin : begin + _BATCH_SIZE] for each in flat)) for begin in begins)
    return _put_together([*parts] if len(begins) == 1 else [_computed(part) for part in parts], shape)


def _computed(part: Any) -> Any:
    """A part whose arrays are all computed: one that is left for later keeps what it follows from."""
    if isinstance(part, Later):
        value = part.value
        return Later(lambda: value)
    return type(part)(*map(_computed, part)) if isinstance(part, tuple) else part


def _put_together(parts: list[Any], shape: tuple[int, ...]) -> Any:
    if parts[0] is None:
        return None
    if isinstance(parts[0], Later):
        return Later(lambda: _put_together([part.value for part in parts], shape))
    if isinstance(parts[0], np.ndarray):
        joined = np.concatenate(parts)
        return joined.reshape((*shape, *joined.shape[1:]))
    return type(parts[0])(*(_put_together(list(each), shape) for each in zip(*parts, strict=True)))
