"""Pictures of the block diagrams, from the diagrams themselves: a box per block, an arrow for all wires between two."""

from collections import defaultdict
from collections.abc import Iterator
from pathlib import Path

import pygraphviz
from example_blocks import station
from pydrake.systems.framework import Diagram, System

import soft_gripper as sg

_LEFT_OUT = ("logs", "scene_graph", "meshcat", "illustration", "estimate_visualizer")
_NAMELESS = ("y0", "y", "delayed_u")
_OTHER_FINGER = ("right_finger",)
_BESIDE_THE_ARM = (
    "left_finger.scoring",
    "left_finger.contact_torque",
    "true_contact",
    "object_width",
    "box",
    "arm.joint_",
)
_STYLE = {
    "graph": {"rankdir": "TB", "bgcolor": "white", "nodesep": "0.3", "ranksep": "0.4", "fontname": "Helvetica"},
    "node": {"shape": "box", "style": "rounded,filled", "fontname": "Helvetica", "fontsize": "12", "color": "#888888"},
    "edge": {"fontname": "Helvetica", "fontsize": "9", "color": "#666666", "fontcolor": "#333333"},
}
_PRIMITIVE, _OWN, _OUTSIDE = "#fee8c8", "#d9e8f5", "white"
_TRUTH = "#eeeeee"  # known in simulation only
Wires = dict[tuple[str, str], list[str]]


def save_diagrams(folder: Path) -> None:
    """Writes the pictures of the concepts page, SVG, and one that has every port."""
    grasp = station("tip_distance_steps").diagram
    draw(grasp, folder / "station.svg", _OTHER_FINGER)
    for part in ("sensors", "estimation", "scoring"):
        draw(grasp.GetSubsystemByName(f"left_finger.{part}"), folder / f"{part}.svg")
    draw(grasp.GetSubsystemByName("gripper.pressure_drive"), folder / "pressure_drive.svg")
    draw(grasp.GetSubsystemByName("grip_control"), folder / "grip_control.svg")
    draw(station("pick_and_place_box").diagram, folder / "arm.svg", (*_OTHER_FINGER, *_BESIDE_THE_ARM))
    sg.save_block_diagram(grasp, folder / "every_port.svg")


def draw(diagram: Diagram, path: Path, but: tuple[str, ...] = ()) -> None:
    """Draws the contents of a diagram, without logs and without names that begin with one of `but`."""
    blocks = {system.get_name(): system for system in diagram.GetSystems()}
    blocks = {name: system for name, system in blocks.items() if not name.startswith((*but, *_LEFT_OUT))}
    graph = pygraphviz.AGraph(directed=True)
    for kind, style in _STYLE.items():
        getattr(graph, f"{kind}_attr").update(style)
    for name, system in blocks.items():
        graph.add_node(name, label=_label(name, system), fillcolor=_color(system))
    wires = defaultdict(list)
    for source, target, port in _wires(diagram):
        if {source, target} <= blocks.keys() and port not in wires[source, target]:
            wires[source, target].append(port)
    if not any(name.endswith("plant") for name in blocks):
        wires |= _outside(diagram, graph)
    for (source, target), ports in wires.items():
        graph.add_edge(source, target, label=_names(ports))
    path.write_bytes(graph.draw(prog="dot", format="svg"))


def _wires(diagram: Diagram) -> Iterator[tuple[str, str, str]]:
    """Source, target and name of the source's port."""
    for (target, _), (source, index) in diagram.connection_map().items():
        yield source.get_name(), target.get_name(), source.get_output_port(index).get_name()


def _outside(diagram: Diagram, graph: pygraphviz.AGraph) -> Wires:
    """Wires from the inputs of a diagram, a node each, and to its outputs, a node for all of a block."""
    wires: Wires = {}
    for port in map(diagram.get_input_port, range(diagram.num_input_ports())):
        graph.add_node(f"in {port.get_name()}", label=port.get_name(), shape="plaintext", fillcolor=_OUTSIDE)
        for system, _ in diagram.GetInputPortLocators(port.get_index()):
            wires[f"in {port.get_name()}", system.get_name()] = []
    outputs = defaultdict(list)
    for port in map(diagram.get_output_port, range(diagram.num_output_ports())):
        system, _ = diagram.get_output_port_locator(port.get_index())
        outputs[system.get_name()].append(port.get_name())
    for block, names in outputs.items():
        graph.add_node(f"out {block}", label="\n".join(names), shape="plaintext", fillcolor=_OUTSIDE)
        wires[block, f"out {block}"] = []
    return wires


def _label(name: str, system: System) -> str:
    return f"{name}\n{type(system).__name__.rstrip('_')}"


def _color(system: System) -> str:
    module = type(system).__module__
    if ".truth." in module or module.endswith("scoring"):
        return _TRUTH
    return _OWN if module.startswith("soft_gripper") else _PRIMITIVE


def _names(ports: list[str]) -> str:
    """The label of an arrow, without the uninformative names of Drake's primitives."""
    return "\n".join(name for name in ports if name not in _NAMELESS)
