"""The ports of the blocks, read off systems: name, size, unit and axes."""

import inspect
from collections.abc import Iterator, Sequence
from itertools import groupby

from example_blocks import Placed, example_blocks, station
from public_names import public, public_names
from pydrake.systems.framework import Diagram, InputPort, OutputPort, PortDataType, System
from tables import code, prose, table

from soft_gripper.signals import Signal, signal_of

_MOST_LABELS = 7
COLUMNS = ("port", "", "size", "unit", "axes")
_BLOCKS = """\
# Blocks and their ports

Every block of the project, and what goes in and comes out: read off systems in the diagrams of shipped scenarios, so
that sizes are those of fingers of 12 segments, and names those of shipped fingers. What an input carries is what is
wired to it there. Blocks with a link are public names.
"""
_SIGNALS = """\
# Signals of a recording

What a recording of `{scenario}` holds, `recording["left_finger.strain"]` and so on: signals of the fingers, the grip,
the arm, the task and the objects. All fingers have the same; those of the first are listed. Other scenarios have more
or fewer: estimators add what they know (`position_std`, `contact_force`), sensors with errors `ideal_*`.
"""


def blocks_page() -> str:
    """Markdown, with a section for each block."""
    found = sorted(example_blocks().items(), key=lambda item: (item[0].__module__, item[0].__name__))
    return "\n".join([_BLOCKS, *(_section(of, placed) for of, placed in found if _ports(placed.system))])


def signals_page(scenario: str = "pick_and_place_box") -> str:
    """Markdown, with a table of all signals of a scenario."""
    return f"{_SIGNALS.format(scenario=scenario)}\n{signals_table(scenario)}"


def signals_table(scenario: str) -> str:
    """The signals of a recording of a scenario; of several fingers, those of the first."""
    built = station(scenario)
    other = tuple(f"{finger.name}." for finger in built.fingers[1:])
    ports = {name: port for name, port in built.parts.signals.items() if not name.startswith(other)}
    rows = [(code(name), *_cells(port.size(), signal_of(port))) for name, port in sorted(ports.items())]
    return table(("signal", "size", "unit", "axes"), rows)


def ports_table(placed: Placed) -> str:
    """Of one block, its inputs first."""
    return table(COLUMNS, [_row(port, placed.diagrams) for port in _ports(placed.system)])


def _section(of: type, placed: Placed) -> str:
    name = of.__name__
    page = next(
        (public_name for names in public_names().values() for public_name in names if public(public_name) is of), ""
    )
    title = f"[{name}](../api/{page}.md)" if page else name
    summary = (inspect.getdoc(of) or "").split("\n\n")[0]
    return f"## {title}\n\n{code(of.__module__)}: {prose(summary)}\n\n{ports_table(placed)}"


def _ports(system: System) -> list[InputPort | OutputPort]:
    incoming = [system.get_input_port(i) for i in range(system.num_input_ports())]
    return [*incoming, *(system.get_output_port(i) for i in range(system.num_output_ports()))]


def _row(port: InputPort | OutputPort, diagrams: tuple[Diagram, ...]) -> tuple[str, ...]:
    direction = "in" if isinstance(port, InputPort) else "out"
    if port.get_data_type() != PortDataType.kVectorValued:
        return code(port.get_name()), direction, "abstract", "", ""
    source = _source(port, diagrams) if isinstance(port, InputPort) else port
    signal = Signal() if source is None else signal_of(source)
    return code(port.get_name()), direction, *_cells(port.size(), signal)


def _cells(size: int, signal: Signal) -> tuple[str, str, str]:
    """Size, unit and axes of what a port carries, or the names of its values."""
    units = [signal.unit] if isinstance(signal.unit, str) else signal.unit
    counted = ((unit, len(list(same))) for unit, same in groupby(units))
    unit = ", ".join(unit if count == 1 else f"{count} × {unit}" for unit, count in counted)
    axes = " × ".join(f"{name} ({_labels(labels)})" for name, labels in signal.axes.items())
    return str(size), unit, axes or ", ".join(dict.fromkeys(signal.meanings))


def _labels(labels: Sequence[object]) -> str:
    """What an axis has, or how many of them where they are numbered or many."""
    numbered = isinstance(labels, range) or len(labels) > _MOST_LABELS
    return str(len(labels)) if numbered else ", ".join(str(label) for label in labels)


def _source(port: InputPort, diagrams: tuple[Diagram, ...]) -> OutputPort | None:
    """The output that feeds an input in the innermost diagram or, from outside, in those around it; None: nothing."""
    if not diagrams:
        return None
    inner = diagrams[-1]
    place = (port.get_system(), port.get_index())
    if place in inner.connection_map():
        system, index = inner.connection_map()[place]
        return system.get_output_port(index)
    exported = [outside for outside in _inputs(inner) if place in inner.GetInputPortLocators(outside.get_index())]
    return _source(exported[0], diagrams[:-1]) if exported else None


def _inputs(diagram: Diagram) -> Iterator[InputPort]:
    return (diagram.get_input_port(i) for i in range(diagram.num_input_ports()))
