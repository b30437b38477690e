"""Cached: what a block computes once for its inputs and state. weakly: methods that do not keep their block alive.
get_or_make: a store of values that later runs use again.

Drake holds the function behind a cache entry or an abstract output port where Python's garbage collector cannot see it.
A function that refers to its block, and a cache entry that the block keeps, would therefore keep the block and the
whole diagram alive until the process ends. So would anything that belongs to a plant (ports, bodies, ids of
geometries).
"""

from collections import OrderedDict
from collections.abc import Callable
from types import MethodType
from typing import Any, TypeVar, cast
from weakref import proxy

from pydrake.common.value import AbstractValue
from pydrake.systems.framework import Context, LeafSystem, ValueProducer

_Key = TypeVar("_Key")
_T = TypeVar("_T")


def weakly(method: Callable[..., Any]) -> Callable[..., Any]:
    """A bound method that does not keep its block alive, and costs no extra call."""
    bound = cast(MethodType, method)
    return MethodType(bound.__func__, proxy(bound.__self__))


class Cached:
    """A value of any kind in the cache of a block's context."""

    def __init__(self, block: LeafSystem, name: str, calc: Callable[[Context, AbstractValue], None], tickets: set[Any]):
        """`calc` sets the value from the quantities of `tickets`; it must not keep the block alive, see `weakly`."""
        producer = ValueProducer(allocate=lambda: AbstractValue.Make(object()), calc=calc)
        self._block = block
        self._index = block.DeclareCacheEntry(name, producer, tickets).cache_index()
        self.ticket = block.cache_entry_ticket(self._index)

    def Eval(self, context: Context) -> Any:  # noqa: N802, named as that of ports
        """The value for the context of the block."""
        return self._block.get_cache_entry(self._index).Eval(context)


def get_or_make(store: OrderedDict[_Key, _T], key: _Key, make: Callable[[], _T], max_count: int) -> _T:
    """Value stored for a key, or else made now; the `max_count` that were used last stay in the store."""
    try:
        value = store.pop(key)
    except KeyError:
        value = make()
    store[key] = value
    while len(store) > max_count:
        store.popitem(last=False)
    return value
