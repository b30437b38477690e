"""A picture of a diagram that fits on a page: a box for each block, an arrow for all wires between two."""

from collections import defaultdict
from collections.abc import Container
from typing import Any

from pydrake.systems.framework import Diagram, InputPort, OutputPort, System

from soft_gripper.errors import InputError

_HIDDEN_BLOCKS = "logs", "drake/systems/VectorLogSink", "scene_graph", "meshcat", "illustration", "estimate_visualizer"
_GENERIC_PORTS = ("y0", "y", "delayed_u")  # uninformative names of ports of Drake's primitives
_GRAPH_STYLE = {
    "graph": {"rankdir": "TB", "bgcolor": "white", "nodesep": "0.3", "ranksep": "0.4", "size": "8,12"},  # inches
    "node": {"shape": "box", "style": "rounded,filled", "fontname": "Helvetica", "fontsize": "12", "color": "#888888"},
    "edge": {"fontname": "Helvetica", "fontsize": "9", "color": "#666666", "fontcolor": "#333333"},
}
_DRAKE_COLOR, _PROJECT_COLOR, _OUTSIDE_COLOR = "#fee8c8", "#d9e8f5", "white"
_TRUTH_COLOR = "#eeeeee"  # known in simulation only
Wires = dict[tuple[str, str], list[str]]  # names of ports, by source and target


def block_picture(system: System, without: tuple[str, ...] = ()) -> str:
    """The blocks of a diagram and the wires between them, as SVG; of a block alone, its ports.

    Blocks of this project are blue, those of Drake yellow, those that only a simulation can have grey. Logs and views
    are left out. `graphviz` has every port instead.

    Args:
        system: a diagram, or a block.
        without: beginnings of the names of further blocks to leave out.

    Raises:
        InputError: if pygraphviz is not installed.
    """
    try:
        import pygraphviz
    except ImportError:
        expected = "a picture requires pygraphviz: pip install 'soft-gripper[notebooks]'"
        raise InputError("block_picture", "system", system.get_name(), expected) from None
    blocks = {block.get_name(): block for block in (system.GetSystems() if isinstance(system, Diagram) else [system])}
    blocks = {name: block for name, block in blocks.items() if not name.startswith((*without, *_HIDDEN_BLOCKS))}
    graph = pygraphviz.AGraph(directed=True)
    for kind, style in _GRAPH_STYLE.items():
        getattr(graph, f"{kind}_attr").update(style)
    for name, block in blocks.items():
        graph.add_node(name, label=f"{name}\n{type(block).__name__.rstrip('_')}", fillcolor=_color(block))
    wires = _wires_between(system, blocks)
    if not any(name.endswith("plant") for name in blocks):
        wires |= _wires_outside(system, graph)
    for (source, target), ports in wires.items():
        graph.add_edge(source, target, label="\n".join(port for port in ports if port not in _GENERIC_PORTS))
    picture: bytes = graph.draw(prog="dot", format="svg")
    return picture.decode()


def _wires_between(system: System, blocks: Container[str]) -> Wires:
    """Wires between blocks, each with the names of the ports of the source."""
    wires: Wires = defaultdict(list)
    if isinstance(system, Diagram):
        for (target, _), (source, index) in system.connection_map().items():
            ends = (source.get_name(), target.get_name())
            port = source.get_output_port(index).get_name()
            if ends[0] in blocks and ends[1] in blocks and port not in wires[ends]:
                wires[ends].append(port)
    return wires


def _wires_outside(system: System, graph: Any) -> Wires:
    """Wires from the inputs, a node each, and to the outputs, a node per block."""
    wires: Wires = {}
    for port in map(system.get_input_port, range(system.num_input_ports())):
        graph.add_node(f"in {port.get_name()}", label=port.get_name(), shape="plaintext", fillcolor=_OUTSIDE_COLOR)
        for block in _target_blocks(system, port):
            wires[f"in {port.get_name()}", block.get_name()] = []
    outputs = defaultdict(list)
    for port in map(system.get_output_port, range(system.num_output_ports())):
        outputs[_source_block(system, port).get_name()].append(port.get_name())
    for name, ports in outputs.items():
        graph.add_node(f"out {name}", label="\n".join(ports), shape="plaintext", fillcolor=_OUTSIDE_COLOR)
        wires[name, f"out {name}"] = []
    return wires


def _target_blocks(system: System, port: InputPort) -> list[System]:
    """The blocks fed by an input of a system."""
    if not isinstance(system, Diagram):
        return [system]
    return [block for block, _ in system.GetInputPortLocators(port.get_index())]


def _source_block(system: System, port: OutputPort) -> System:
    """The block that feeds an output of a system."""
    return system.get_output_port_locator(port.get_index())[0] if isinstance(system, Diagram) else system


def _color(block: System) -> str:
    module = type(block).__module__
    if ".truth." in module or module.endswith("scoring"):
        return _TRUTH_COLOR
    return _PROJECT_COLOR if module.startswith("soft_gripper") else _DRAKE_COLOR
