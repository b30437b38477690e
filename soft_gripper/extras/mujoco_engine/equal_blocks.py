"""Compares blocks and structures of diagrams, so that equal blocks are computed once.

Blocks are equal if their steps are the same functions of the same values: those in closures, in partial functions, and
in the objects of bound methods. Objects with state in C++, such as a plant, equal only themselves.
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
_BLOCK_ATTRIBUTES = frozenset(vars(ArrayBlock(1.0)))  # of any block: they add nothing to the steps


class _Plain:
    """Object whose state is all in its attributes."""


def is_equal(first: Any, second: Any, known_pairs: _Pairs = frozenset()) -> bool:
    """Whether two values, functions or objects are bitwise equal; False in doubt."""
    if first is second or (id(first), id(second)) in known_pairs:
        return True
    if type(first) is not type(second):
        return False
    if isinstance(first, np.ndarray):
        return first.shape == second.shape and first.dtype == second.dtype and first.tobytes() == second.tobytes()
    if isinstance(first, str | int | float | complex | bytes | slice | np.generic):
        return repr(first) == repr(second)
    if hasattr(first, "__index__"):  # of a body of a plant
        return index(first) == index(second)
    known_pairs |= {(id(first), id(second))}
    if isinstance(first, Mapping):
        return list(first) == list(second) and all(is_equal(first[key], second[key], known_pairs) for key in first)
    if isinstance(first, tuple | list):
        return len(first) == len(second) and all(map(partial(is_equal, known_pairs=known_pairs), first, second))
    if isinstance(first, FunctionType) and first.__code__ is not second.__code__:
        return False
    contents = _contents(first)
    return contents is not None and is_equal(contents, _contents(second), known_pairs)


def _contents(value: Any) -> Any:
    """Values on which an object depends; None if they cannot be found."""
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
    derived_names = {
        name
        for kind in type(value).__mro__
        for name, attribute in vars(kind).items()
        if isinstance(attribute, cached_property)
    }
    return {name: part for name, part in vars(value).items() if name not in derived_names | left_out}


def structure(system: System) -> Hashable:
    """Blocks, ports, steps and wires of a system: equal for diagrams that differ in values alone."""
    if not isinstance(system, Diagram):
        return _leaf_structure(system)
    connections = system.connection_map().items()
    wires = ((reader.get_name(), i, source.get_name(), j) for (reader, i), (source, j) in connections)
    inputs = map(system.get_input_port, range(system.num_input_ports()))
    input_names = (
        sorted((part.get_name(), i) for part, i in system.GetInputPortLocators(port.get_index())) for port in inputs
    )
    outputs = map(system.get_output_port, range(system.num_output_ports()))
    begins = (system.get_output_port_locator(port.get_index()) for port in outputs)
    output_names = ((part.get_name(), int(i)) for part, i in begins)
    subsystems = [(part.get_name(), structure(part)) for part in system.GetSystems()]
    return repr((subsystems, sorted(wires), [*input_names], [*output_names]))


def _leaf_structure(leaf: LeafSystem) -> Hashable:
    inputs = map(leaf.get_input_port, range(leaf.num_input_ports()))
    outputs = map(leaf.get_output_port, range(leaf.num_output_ports()))
    ports = [(p.get_name(), p.get_data_type() == PortDataType.kVectorValued, p.size()) for p in (*inputs, *outputs)]
    update_timing = leaf.GetUniquePeriodicDiscreteUpdateAttribute()
    steps = leaf.steps if isinstance(leaf, ArrayBlock) else {}
    memories = {name: step.memory for name, step in steps.items()}
    shapes = [None if memory is None else (memory.begin.shape, memory.sources) for memory in memories.values()]
    sources = [(name, step.sources) for name, step in steps.items()]
    return type(leaf).__name__, ports, None if update_timing is None else update_timing.period_sec(), sources, shapes
