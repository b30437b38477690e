"""Which blocks of several diagrams do the same, and which diagrams have one structure.

Blocks do the same if their steps are the same functions of the same values: those in closures, in partial functions,
and in the objects to which methods are bound. What Drake alone knows, such as a plant, is equal to itself alone.
"""

from collections.abc import Hashable, Mapping
from dataclasses import fields, is_dataclass
from functools import cached_property, partial
from operator import index
from types import FunctionType, MethodType
from typing import Any

import numpy as np
from pydrake.systems.framework import Diagram, LeafSystem, PortDataType, System

from soft_gripper.array_block import ArrayBlock

_Pairs = frozenset[tuple[int, int]]  # ids of objects that are being compared
_BLOCK_ATTRIBUTES = frozenset(vars(ArrayBlock(1.0)))  # of any block: they say nothing beyond the steps


class _Plain:
    """An object all of whose state is in its attributes."""


def is_equal(one: Any, other: Any, compared: _Pairs = frozenset()) -> bool:
    """Whether two values, functions or objects that hold them are equal to the bit; in doubt they are not."""
    if one is other or (id(one), id(other)) in compared:
        return True
    if type(one) is not type(other):
        return False
    if isinstance(one, np.ndarray):
        return one.shape == other.shape and one.dtype == other.dtype and one.tobytes() == other.tobytes()
    if isinstance(one, str | int | float | complex | bytes | slice | np.generic):
        return repr(one) == repr(other)
    if hasattr(one, "__index__"):  # of a body of a plant
        return index(one) == index(other)
    compared |= {(id(one), id(other))}
    if isinstance(one, Mapping):
        return list(one) == list(other) and all(is_equal(one[key], other[key], compared) for key in one)
    if isinstance(one, tuple | list):
        return len(one) == len(other) and all(map(partial(is_equal, compared=compared), one, other))
    if isinstance(one, FunctionType) and one.__code__ is not other.__code__:
        return False
    contents = _contents(one)
    return contents is not None and is_equal(contents, _contents(other), compared)


def _contents(value: Any) -> Any:
    """The values on which an object depends; None if they are not known."""
    if isinstance(value, partial):
        return value.func, value.args, value.keywords
    if isinstance(value, MethodType):
        return value.__func__, value.__self__
    if isinstance(value, FunctionType):
        return value.__defaults__, value.__kwdefaults__, [cell.cell_contents for cell in value.__closure__ or ()]
    if is_dataclass(value) and not hasattr(value, "__dict__"):
        return {field.name: getattr(value, field.name) for field in fields(value)}
    if not isinstance(value, ArrayBlock) and type(value).__basicsize__ != _Plain.__basicsize__:
        return None  # its state, or a part of it, is in C or in slots
    left_out = _BLOCK_ATTRIBUTES if isinstance(value, ArrayBlock) else frozenset[str]()
    derived = {
        name
        for kind in type(value).__mro__
        for name, attribute in vars(kind).items()
        if isinstance(attribute, cached_property)
    }
    return {name: part for name, part in vars(value).items() if name not in derived | left_out}


def structure(system: System) -> Hashable:
    """What diagrams have in common whose blocks differ in values alone: blocks, ports, steps and wires."""
    if not isinstance(system, Diagram):
        return _leaf_structure(system)
    wires = ((to.get_name(), i, of.get_name(), j) for (to, i), (of, j) in system.connection_map().items())
    inputs = map(system.get_input_port, range(system.num_input_ports()))
    ends = (
        sorted((each.get_name(), i) for each, i in system.GetInputPortLocators(port.get_index())) for port in inputs
    )
    outputs = map(system.get_output_port, range(system.num_output_ports()))
    begins = (system.get_output_port_locator(port.get_index()) for port in outputs)
    shown = ((each.get_name(), int(i)) for each, i in begins)
    return repr(
        ([(each.get_name(), structure(each)) for each in system.GetSystems()], sorted(wires), [*ends], [*shown])
    )


def _leaf_structure(leaf: LeafSystem) -> Hashable:
    inputs = map(leaf.get_input_port, range(leaf.num_input_ports()))
    outputs = map(leaf.get_output_port, range(leaf.num_output_ports()))
    ports = [(p.get_name(), p.get_data_type() == PortDataType.kVectorValued, p.size()) for p in (*inputs, *outputs)]
    timing = leaf.GetUniquePeriodicDiscreteUpdateAttribute()
    steps = leaf.steps if isinstance(leaf, ArrayBlock) else {}
    memories = {name: step.memory for name, step in steps.items()}
    shapes = [None if memory is None else (memory.begin.shape, memory.sources) for memory in memories.values()]
    sources = [(name, step.sources) for name, step in steps.items()]
    return type(leaf).__name__, ports, None if timing is None else timing.period_sec(), sources, shapes
