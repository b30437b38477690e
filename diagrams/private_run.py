"""Diagrams that nobody sees: they have the blocks that their loop and their logs read, and no others.

In a diagram that a user gets, every port can be read at any time, so every block runs. In a run whose diagram nobody
sees, such as `simulate` or a sweep, a block made of functions (ArrayBlock) is needed only if a block of another kind
reads it, be it a controller, a visualizer or a log. The others leave the diagram before it is built, and the recording
computes their signals afterwards (`SignalSources`). This is 1 to 4 times as fast.
"""

from collections.abc import Iterator, Mapping
from typing import NamedTuple

from pydrake.systems.framework import DiagramBuilder, LeafSystem, OutputPort, System

from soft_gripper.array_block import ArrayBlock
from soft_gripper.diagrams.live import LiveReads, array_source
from soft_gripper.diagrams.wires import Feed, Level, leaf_systems


class Kept(NamedTuple):
    """Blocks and connections that are left of a diagram."""

    signals: dict[str, OutputPort]  # those that are still computed
    removed: dict[str, System]  # by name


def keep_what_is_read(builder: DiagramBuilder, period: float, signals: Mapping[str, OutputPort]) -> Kept:
    """Removes what nothing reads from a diagram that is otherwise complete, logs included.

    Args:
        builder: of a diagram that nobody reads from outside.
        period: of its samples, s.
        signals: ports of the diagram.
    """
    root = Level.root(builder)
    parts = {system: [*leaf_systems(system, root)] for system in builder.GetSystems()}
    part_of = {leaf: part for part, leaves in parts.items() for leaf, _ in leaves}
    running = [part for part, leaves in parts.items() if not all(isinstance(leaf, ArrayBlock) for leaf, _ in leaves)]
    live = LiveReads(period)
    for reader in running:  # which grows
        for wire, port, inside in (read for leaf, level in parts[reader] for read in _reads(leaf, level)):
            part = part_of[port.get_system()]
            if part not in running and not live.take(port, inside, wire):
                running.append(part)
    replaced, left = live.add_to(builder), {}
    for name, port in signals.items():
        found = port if port.get_system() in running else replaced.get((port.get_system(), port.get_index()))
        if found is not None:
            left[name] = found
    removed = {part.get_name(): part for part in parts if part not in running}
    for part in removed.values():
        builder.RemoveSystem(part)
    return Kept(left, removed)


def _reads(leaf: LeafSystem, level: Level) -> Iterator[tuple[Feed, OutputPort, Level]]:
    """The wires by which a block reads blocks made of functions, with their ports and levels."""
    for wire in map(level.feed, map(leaf.get_input_port, range(leaf.num_input_ports()))):
        source = None if wire is None else array_source(wire)
        if wire is not None and source is not None:
            yield wire, *source
