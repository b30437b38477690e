"""Removes from a diagram that nobody sees the blocks that neither its loop nor its logs read.

In a diagram that a user gets, every port can be read at any time, so every block runs. In a run whose diagram nobody
sees, such as `simulate` or a sweep, a block made of functions (ArrayBlock), or a MatrixGain, is needed only if a block
of another kind reads it, be it a controller, a visualizer or a log. The others leave the diagram before it is built,
and the recording computes their signals afterwards (`SignalSources`); sensors and estimation are composed, for those
that stay (`wiring.composed`), and fused with the grip control into one block, that of the loop. If nothing is read
afterwards, this is 1 to 4 times as fast.
"""

from collections.abc import Iterator, Mapping
from typing import NamedTuple

from pydrake.systems.framework import Diagram, DiagramBuilder, InputPort, LeafSystem, OutputPort, System
from pydrake.systems.primitives import MatrixGain

from soft_gripper.array_block import ArrayBlock
from soft_gripper.diagrams.wires import Feed, Level, leaf_systems
from soft_gripper.diagrams.wiring.composed import BatchedBlock, FusedBlock, wire
from soft_gripper.diagrams.wiring.grip_control import GripControl
from soft_gripper.diagrams.wiring.named_wires import inputs
from soft_gripper.sensors.base_pose import BasePoseSensor

_FUSED = FusedBlock | BatchedBlock | BasePoseSensor | GripControl


class Pruning(NamedTuple):
    """Signals and removed blocks after pruning."""

    signals: dict[str, OutputPort]  # those that are still computed
    removed: dict[str, System]  # by name


def remove_unread_blocks(builder: DiagramBuilder, signals: Mapping[str, OutputPort]) -> Pruning:
    """Removes unread blocks from a complete diagram, logs included, which nobody reads from outside."""
    root = Level.root(builder)
    parts = {system: [*leaf_systems(system, root)] for system in builder.GetSystems()}
    leaf_parts = {leaf: part for part, leaves in parts.items() for leaf, _ in leaves}
    running = [part for part, leaves in parts.items() if any(_runs_alone(leaf) for leaf, _ in leaves)]
    for reader in running:  # which grows
        sources = {leaf_parts[block] for leaf, level in parts[reader] for block in _input_blocks(leaf, level)}
        running += [part for part in parts if part in sources and part not in running]
    kept_signals = {name: port for name, port in signals.items() if port.get_system() in running}
    removed_parts = {part.get_name(): part for part in parts if part not in running}
    for part in removed_parts.values():
        builder.RemoveSystem(part)
    return Pruning(kept_signals, removed_parts)


LOOP = "loop"  # name of the fused block


def fuse_loop(builder: DiagramBuilder, signals: Mapping[str, OutputPort]) -> dict[str, OutputPort]:
    """Fuses composed parts and the grip control into one block, with the outputs that others read.

    Returns the signals that are still computed. Nobody reads the diagram from outside.
    """
    root = Level.root(builder)
    leaves = {part: [*leaf_systems(part, root)] for part in builder.GetSystems() if isinstance(part, _FUSED)}
    parts = [part for part in leaves if all(isinstance(leaf, ArrayBlock) for leaf, _ in leaves[part])]
    if not parts:
        return dict(signals)
    own_feeds = [(leaf, _open_feeds(leaf, level)) for part in parts for leaf, level in leaves[part]]
    wire_names: dict[tuple[System, str], str] = {}
    sources: dict[str, InputPort] = {}  # inputs of parts that are fed from outside, by the names of the outputs
    for leaf, feeds in own_feeds:
        for name, feed in feeds.items():
            if feed.level.diagram is not None or feed.system in parts:
                wire_names[leaf, name] = wire(feed.level.leaf_output(feed.output)[0])
            else:
                wire_names[leaf, name] = f"{feed.system.get_name()}/{int(feed.output_index)}"
                sources[wire_names[leaf, name]] = feed.input
    ports: dict[str, OutputPort] = {}  # outputs of parts that others read
    readers: list[tuple[InputPort, str]] = []
    for (target, i), (source, output_index) in root.wires.items():
        if source in parts and target not in parts:
            port = source.get_output_port(output_index)
            ports[wire(port)] = port
            readers.append((target.get_input_port(i), wire(port)))
    block = FusedBlock([leaf for leaf, _ in own_feeds], sources, wire_names, ports)
    builder.AddNamedSystem(LOOP, block)
    for name, port in sources.items():
        builder.ConnectToSame(port, block.GetInputPort(name))
    kept_ports = {name: port for name, port in signals.items() if port.get_system() not in parts or wire(port) in ports}
    fused = {name: wire(port) for name, port in kept_ports.items() if port.get_system() in parts}
    for part in parts:
        builder.RemoveSystem(part)
    for reader, output in readers:
        builder.Connect(block.GetOutputPort(output), reader)
    return kept_ports | {name: block.GetOutputPort(output) for name, output in fused.items()}


def _runs_alone(leaf: LeafSystem) -> bool:
    """Whether a block runs even if nothing reads it: it is no function of its inputs, or logs values."""
    return bool(leaf.logs) if isinstance(leaf, ArrayBlock) else not isinstance(leaf, MatrixGain)


def _open_feeds(leaf: LeafSystem, level: Level) -> dict[str, Feed]:
    """Feeds of the inputs of a block, by name."""
    feeds = {name: level.feed(port) for name, port in inputs(leaf).items()}
    return {name: feed for name, feed in feeds.items() if feed is not None}


def _input_blocks(leaf: LeafSystem, level: Level) -> Iterator[LeafSystem]:
    """The functions of their inputs that a block reads."""
    for feed in map(level.feed, map(leaf.get_input_port, range(leaf.num_input_ports()))):
        if feed is not None and isinstance(feed.system, ArrayBlock | MatrixGain | Diagram):
            yield feed.level.leaf_output(feed.output)[0].get_system()
