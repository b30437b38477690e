"""Removes from a diagram that nobody sees the blocks that neither its loop nor its logs read.

In a diagram that a user gets, every port can be read at any time, so every block runs. In a run whose diagram nobody
sees, such as `simulate` or a sweep, a block made of functions (ArrayBlock) is needed only if a block of another kind
reads it, be it a controller, a visualizer or a log. The others leave the diagram before it is built, and the recording
computes their signals afterwards (`SignalSources`); sensors and estimation are composed, for those that stay
(`wiring.composed`). If nothing is read afterwards, this is 1 to 4 times as fast.
"""

from collections.abc import Iterator, Mapping
from typing import NamedTuple

from pydrake.systems.framework import Diagram, DiagramBuilder, LeafSystem, OutputPort, System

from soft_gripper.array_block import ArrayBlock
from soft_gripper.diagrams.wires import Level, leaf_systems


class Pruning(NamedTuple):
    """Signals and removed blocks after pruning."""

    signals: dict[str, OutputPort]  # those that are still computed
    removed: dict[str, System]  # by name


def remove_unread_blocks(builder: DiagramBuilder, signals: Mapping[str, OutputPort]) -> Pruning:
    """Removes unread blocks from a complete diagram, logs included.

    Args:
        builder: of a diagram that nobody reads from outside.
        signals: ports of the diagram.
    """
    root = Level.root(builder)
    parts = {system: [*leaf_systems(system, root)] for system in builder.GetSystems()}
    part_of = {leaf: part for part, leaves in parts.items() for leaf, _ in leaves}
    running = [part for part, leaves in parts.items() if not all(isinstance(leaf, ArrayBlock) for leaf, _ in leaves)]
    for reader in running:  # which grows
        read = {part_of[block] for leaf, level in parts[reader] for block in _input_blocks(leaf, level)}
        running += [part for part in parts if part in read and part not in running]
    computed = {name: port for name, port in signals.items() if port.get_system() in running}
    removed = {part.get_name(): part for part in parts if part not in running}
    for part in removed.values():
        builder.RemoveSystem(part)
    return Pruning(computed, removed)


def _input_blocks(leaf: LeafSystem, level: Level) -> Iterator[LeafSystem]:
    """The blocks that a block reads."""
    for fed in map(level.feed, map(leaf.get_input_port, range(leaf.num_input_ports()))):
        if fed is not None and isinstance(fed.system, ArrayBlock | Diagram):
            yield fed.level.leaf_output(fed.output)[0].get_system()
