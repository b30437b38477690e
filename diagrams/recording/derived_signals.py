"""Which ports need a log, and how signals follow from the logged ones.

An ArrayBlock gives its outputs at all samples of a recording from its inputs at all of them. So a port of such a block
needs no log, and is not computed while the diagram runs, as long as its inputs lead back to ports that are logged.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, NamedTuple

from pydrake.systems.framework import Diagram, DiagramBuilder, InputPort, OutputPort, System

from soft_gripper.array_block import ArrayBlock
from soft_gripper.arrays import Array


class Logged(NamedTuple):
    """A port that has a log, by its place among `SignalSources.ports`.

    Logs keep it after the diagram is built; a port that was kept would keep the diagram alive.
    """

    number: int


@dataclass(eq=False)
class Derived:
    """Outputs of a block that follow from the same outputs of others."""

    block: ArrayBlock
    leaves: dict[str, "Source"]  # by the names of the block's ports
    outputs: list[str] = field(default_factory=list)  # names of the requested ones


class Output(NamedTuple):
    """One output of such a block."""

    of: Derived
    name: str


Source = Logged | Output


class _Level(NamedTuple):
    """The wires around a system."""

    wires: Mapping[tuple[System, int], tuple[System, int]]  # outputs by the inputs that they feed
    diagram: Diagram | None = None  # None: the builder of the whole
    above: "_Level | None" = None

    def source(self, port: InputPort) -> "tuple[OutputPort, _Level] | None":
        """The output that feeds an input, and where it is; None if there is none yet."""
        key = port.get_system(), port.get_index()
        if key in self.wires:
            system, index = self.wires[key]
            return system.get_output_port(index), self
        if self.diagram is None or self.above is None:
            return None
        outer = map(self.diagram.get_input_port, range(self.diagram.num_input_ports()))
        fed = (each for each in outer if key in map(tuple, self.diagram.GetInputPortLocators(each.get_index())))
        port_above = next(fed, None)
        return None if port_above is None else self.above.source(port_above)

    def exported(self, port: OutputPort) -> OutputPort | None:
        """The port of the whole that shows an output; None if none does."""
        if self.diagram is None or self.above is None:
            return port
        key = port.get_system(), port.get_index()
        outer = map(self.diagram.get_output_port, range(self.diagram.num_output_ports()))
        shown = (each for each in outer if tuple(self.diagram.get_output_port_locator(each.get_index())) == key)
        port_above = next(shown, None)
        return None if port_above is None else self.above.exported(port_above)


class SignalSources:
    """Finds what signals of a diagram follow from, at samples `period` s apart. Use it before the diagram is built.

    `ports` are those that may need a log.
    """

    def __init__(self, builder: DiagramBuilder, period: float):
        self.ports: list[OutputPort] = []
        self._root, self._period = _Level(builder.connection_map()), period
        self._blocks: dict[tuple[System, frozenset[str]], Derived] = {}
        self._outputs: dict[tuple[System, str], Output | None] = {}

    def find(self, port: OutputPort) -> Source:
        """What gives a port of the builder's systems."""
        return self._trace(port, self._root) or self._logged(port)

    def _logged(self, port: OutputPort) -> Logged:
        if port not in self.ports:
            self.ports.append(port)
        return Logged(self.ports.index(port))

    def _trace(self, port: OutputPort, level: _Level) -> Source | None:
        """The same anywhere; None if it follows from what no port of the whole shows."""
        system = port.get_system()
        if isinstance(system, Diagram):
            inner, index = system.get_output_port_locator(port.get_index())
            return self._trace(inner.get_output_port(index), _Level(system.connection_map(), system, level))
        if isinstance(system, ArrayBlock) and system.follows(port.get_name(), self._period):
            output = self._follow(system, port.get_name(), level)
            if output is not None:
                return output
        shown = level.exported(port)
        return None if shown is None else self._logged(shown)

    def _follow(self, system: ArrayBlock, name: str, level: _Level) -> Output | None:
        """An output of a block, if all that it follows from is known; None too while that is looked for, in a loop."""
        key = system, name
        if key not in self._outputs:
            self._outputs[key] = None
            leaves = {leaf: self._leaf(system, leaf, level) for leaf in system.leaves(name)}
            found = {leaf: source for leaf, source in leaves.items() if source is not None}
            if len(found) == len(leaves):
                block = self._blocks.setdefault((system, frozenset(found)), Derived(system, found))
                block.outputs.append(name)
                self._outputs[key] = Output(block, name)
        return self._outputs[key]

    def _leaf(self, system: ArrayBlock, name: str, level: _Level) -> Source | None:
        if system.HasInputPort(name):
            fed = level.source(system.GetInputPort(name))
            return None if fed is None else self._trace(*fed)
        shown = level.exported(system.GetOutputPort(name))
        return None if shown is None else self._logged(shown)


def derive(sources: Mapping[str, Source], time: Array, logged: Mapping[int, Any]) -> dict[str, Array]:
    """Signals at all samples, (T, size) each, by their names.

    Args:
        sources: of the signals.
        time: of the samples, s, (T,).
        logged: what the logs hold, (T, size) each or lists of T, by the numbers of their ports.
    """
    known: dict[Derived, dict[str, Array]] = {}

    def values(source: Source) -> Any:
        if isinstance(source, Logged):
            return logged[source.number]
        block = source.of
        if block not in known:
            leaves = {name: values(each) for name, each in block.leaves.items()}
            known[block] = block.block.over_time(time, leaves, block.outputs)
        return known[block][source.name]

    return {name: values(source) for name, source in sources.items()}
