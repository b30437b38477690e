"""The wires of a diagram that is being built, followed through all its levels."""

from collections.abc import Iterator, Mapping
from typing import NamedTuple

from pydrake.systems.framework import Diagram, DiagramBuilder, InputPort, LeafSystem, OutputPort, System


class Level(NamedTuple):
    """The wires around a system."""

    wires: Mapping[tuple[System, int], tuple[System, int]]  # outputs by the inputs they feed
    diagram: Diagram | None = None  # None: the builder of the root diagram
    above: "Level | None" = None

    @classmethod
    def root(cls, builder: DiagramBuilder) -> "Level":
        """The level of a builder's systems."""
        return cls(builder.connection_map())

    def inner_level(self, diagram: Diagram) -> "Level":
        """The level of the systems in a diagram of this level."""
        return Level(diagram.connection_map(), diagram, self)

    def feed(self, port: InputPort) -> "Feed | None":
        """Feed of an input; None if nothing feeds it yet."""
        key = port.get_system(), port.get_index()
        if key in self.wires:
            return Feed(*self.wires[key], port, self)
        if self.diagram is None or self.above is None:
            return None
        outer = map(self.diagram.get_input_port, range(self.diagram.num_input_ports()))
        fed = (port for port in outer if key in map(tuple, self.diagram.GetInputPortLocators(port.get_index())))
        port_above = next(fed, None)
        return None if port_above is None else self.above.feed(port_above)

    def root_port(self, port: OutputPort) -> OutputPort | None:
        """The port of the root diagram that exports an output; None if there is none."""
        if self.diagram is None or self.above is None:
            return port
        key = port.get_system(), port.get_index()
        outer = map(self.diagram.get_output_port, range(self.diagram.num_output_ports()))
        matches = (port for port in outer if tuple(self.diagram.get_output_port_locator(port.get_index())) == key)
        port_above = next(matches, None)
        return None if port_above is None else self.above.root_port(port_above)

    def leaf_output(self, port: OutputPort) -> "tuple[OutputPort, Level]":
        """The port of a leaf system that is behind an output, and its level."""
        system = port.get_system()
        if not isinstance(system, Diagram):
            return port, self
        inner, index = system.get_output_port_locator(port.get_index())
        return self.inner_level(system).leaf_output(inner.get_output_port(index))


class Feed(NamedTuple):
    """A wire: an output of one system, by its index, to an input of another at the same level."""

    system: System
    output_index: int
    input: InputPort
    level: Level

    @property
    def output(self) -> OutputPort:
        """The output; of a plant, a port obtained like this would keep its diagram alive for ever."""
        return self.system.get_output_port(self.output_index)


def leaf_systems(system: System, level: Level) -> Iterator[tuple[LeafSystem, Level]]:
    """Yields the leaf systems of a system at a level, with their levels; the system may be a leaf itself."""
    if isinstance(system, Diagram):
        for inner in system.GetSystems():
            yield from leaf_systems(inner, level.inner_level(system))
    else:
        yield system, level
