"""Meaning of a port: its unit and its axes, declared beside the port and read by all that log it."""

import math
from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

from pydrake.systems.framework import OutputPort, System

_SIGNALS_ATTRIBUTE = "_signals"  # attribute of a system: what its output ports carry, by their names
XYZ = ("x", "y", "z")
XZ = ("x", "z")
POSE = ("x", "z", "heading")  # of a point of the bending plane, with ("m", "m", "rad")


class Signal(NamedTuple):
    """The unit of a port's vector, or one unit for each entry of its last axis, and the axes that it is folded into.

    `axes` holds the labels along every axis, by its name. `meanings` names the values 0, 1, 2 ... of a signal that
    counts states.
    """

    unit: str | tuple[str, ...] = "1"
    axes: Mapping[str, Sequence[Any]] = {}
    meanings: tuple[str, ...] = ()


def describe(
    port: OutputPort, unit: str | Sequence[str] = "1", meanings: Sequence[str] = (), **axes: Sequence[Any]
) -> OutputPort:
    """Declares the signal of a vector port; returns the port.

    Args:
        port: an output port of any system.
        unit: of all entries, or of each along the last axis; "1" for none.
        meanings: names of the values 0, 1, 2 ..., if it counts states.
        axes: labels along each axis, by its name, from the slowest; their product is the size of the port.

    Raises:
        ValueError: if the axes do not fill the port, or the units do not fill the last axis.
    """
    name, size = port.get_name(), math.prod(map(len, axes.values()))
    if not axes and port.size() > 1:
        raise ValueError(f"port '{name}': give axes for its entries, such as joint=range({port.size()})")
    if "time" in axes:
        raise ValueError(f"port '{name}': 'time' is the axis of the samples; give another name")
    if size != port.size():
        raise ValueError(f"port '{name}': axes of {size} entries for {port.size()} in the port")
    units = unit if isinstance(unit, str) else tuple(unit)
    if isinstance(units, tuple) and (not axes or len(units) != len(list(axes.values())[-1])):
        raise ValueError(f"port '{name}': {len(units)} units do not fit its last axis")
    if isinstance(units, tuple) and len(set(units)) == 1:
        units = units[0]
    return _declare(port, Signal(units, dict(axes), tuple(meanings)))


def signal_of(port: OutputPort) -> Signal:
    """Signal of a vector port; if nothing is declared, no unit, and entries numbered from 0."""
    signals: dict[str, Signal] = getattr(port.get_system(), _SIGNALS_ATTRIBUTE, {})
    entry_labels = {"entry": range(port.size())} if port.size() > 1 else {}
    return signals.get(port.get_name(), Signal(axes=entry_labels))


def export_outputs(system: System, sources: Mapping[str, OutputPort]) -> None:
    """Declares that ports of a system, such as a built diagram, carry the signals of others, by names of its ports."""
    for name, source in sources.items():
        _declare(system.GetOutputPort(name), signal_of(source))


def _declare(port: OutputPort, signal: Signal) -> OutputPort:
    system = port.get_system()
    if not hasattr(system, _SIGNALS_ATTRIBUTE):
        setattr(system, _SIGNALS_ATTRIBUTE, {})
    getattr(system, _SIGNALS_ATTRIBUTE)[port.get_name()] = signal
    return port
