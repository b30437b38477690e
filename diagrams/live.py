"""What runs while a diagram is simulated: only what its loop reads.

The rule: a block made of functions (ArrayBlock) is computed during a run if a block of another kind reads it, be it a
controller, a visualizer, a log or a user's block. All others rest, and the recording computes their signals afterwards.
What is read is computed by one block for the whole diagram, `live`, which calls the functions of all these blocks in
one event at every sample: a Python block costs more by its events, ports and caches than by its arithmetic.

`live` can stand for a block if that depends on other blocks only through its samples; its outputs then change at
samples only, and are state. Others, and those that are read inside of the same part of the diagram, run by themselves.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import Any, NamedTuple

import numpy as np
from pydrake.systems.framework import (
    Context,
    DiagramBuilder,
    DiscreteValues,
    InputPort,
    LeafSystem,
    OutputPort,
)

from soft_gripper.array_block import TIME, ArrayBlock, Constant, Function, Memory, Sample, Step, Value, is_leaf
from soft_gripper.arrays import Array
from soft_gripper.cached import weakly
from soft_gripper.diagrams.wires import Feed, Level, leaf_systems

Values = list[Any]  # of all nodes of a network


class _Taken(NamedTuple):
    """A sample: the node that is sampled, None for the time."""

    step: Sample
    source: int | None
    held: slice  # where it is kept in the state


class _Remembered(NamedTuple):
    step: Memory
    sources: list[int]
    kept: list[int]  # what it is kept of, the step itself first
    begin: int | None  # node from which it begins
    held: slice


class _Computed(NamedTuple):
    of: Callable[..., Any]
    sources: list[int]


@dataclass(eq=False)
class Network:
    """The steps of several blocks, each after those that it follows from."""

    inputs: list[tuple[OutputPort, Step]] = field(default_factory=list)  # ports outside, and the steps that they feed
    nodes: list[Any] = field(default_factory=list)
    begin: list[Array] = field(default_factory=list)  # of what is held between samples

    def hold(self, begin: Array) -> slice:
        """Room for an array in the state."""
        start = sum(map(len, self.begin))
        self.begin.append(begin.ravel())
        return slice(start, start + begin.size)

    def values(self, read: Values, held: Array, time: float, is_first: bool) -> Values:
        """All nodes at a sample.

        Args:
            read: values of the inputs.
            held: state.
            time: s.
            is_first: the run is initialized.
        """
        values: Values = []
        for node in self.nodes:
            if isinstance(node, _Computed):
                values.append(node.of(*[values[i] for i in node.sources]))
            elif isinstance(node, int):
                values.append(read[node])
            elif isinstance(node, _Taken):
                step = node.step
                is_taken = step.at_initialization if is_first else step.at_zero or time > 0
                present = np.array([time]) if node.source is None else values[node.source]
                values.append(present if is_taken else held[node.held])
            else:
                step = node.step
                is_begun = is_first and node.begin is not None
                memory = step.begin_of[0](values[node.begin]) if is_begun else held[node.held].reshape(step.begin.shape)
                values.append(step.of(memory, *[values[i] for i in node.sources]))
        return values

    def state(self, values: Values, held: Array, time: float, is_first: bool) -> Array:
        """What is held after a sample; at the initialization of a run at time 0 nothing is remembered yet."""
        after = held.copy()
        for i, node in enumerate(self.nodes):
            if isinstance(node, _Taken):
                after[node.held] = values[i]
            elif isinstance(node, _Remembered):
                if not is_first or time > 0:
                    after[node.held] = node.step.keep(*[values[j] for j in node.kept]).ravel()
                elif node.begin is not None:
                    after[node.held] = node.step.begin_of[0](values[node.begin]).ravel()
        return after


class LiveSignals(LeafSystem):
    """Computes, in one event at every sample, what the loop of a diagram reads of blocks made of functions.

    ::

        {block}.{port} of the plant and its drive ---> +-------------+
                                                       | LiveSignals | ---> {block}.{port} of sensors, estimators ...
                                                       +-------------+
    """

    def __init__(self, network: Network, outputs: dict[str, tuple[int, int]], period: float):
        """`outputs` are nodes and sizes by the names of the ports; sampled every `period` s."""
        super().__init__()
        self._network, self._nodes = network, [node for node, _ in outputs.values()]
        self._ports = [self._declare_input(port, step) for port, step in network.inputs]
        self._held = int(self.DeclareDiscreteState(np.concatenate([np.zeros(0), *network.begin])))
        for name, (_, size) in outputs.items():
            self.DeclareStateOutputPort(name, self.DeclareDiscreteState(size))
        self.DeclareInitializationDiscreteUpdateEvent(weakly(self._begin))
        self.DeclarePeriodicDiscreteUpdateEvent(period, 0.0, weakly(self._sample))

    def _declare_input(self, port: OutputPort, step: Step) -> InputPort:
        name = _name(port)
        if isinstance(step, Value):
            return self.DeclareAbstractInputPort(name, step.model)
        return self.DeclareVectorInputPort(name, port.size())

    def _begin(self, context: Context, values: DiscreteValues) -> None:
        self._update(context, values, True)

    def _sample(self, context: Context, values: DiscreteValues) -> None:
        self._update(context, values, False)

    def _update(self, context: Context, values: DiscreteValues, is_first: bool) -> None:
        time, held = context.get_time(), context.get_discrete_state(self._held).value()
        found = self._network.values([port.Eval(context) for port in self._ports], held, time, is_first)
        values.set_value(self._held, self._network.state(found, held, time, is_first))
        for group, node in enumerate(self._nodes, self._held + 1):
            values.set_value(group, found[node])


class _Compiler:
    """Finds the steps that ports follow from."""

    def __init__(self) -> None:
        self.network = Network()
        self._found: dict[Any, int] = {}
        self._later: list[tuple[int, ArrayBlock, Level]] = []  # memories, whose `kept` may come later

    def output(self, port: OutputPort, level: Level) -> int:
        """The node of a port of an ArrayBlock, its vector flat.

        Raises:
            LookupError: if it depends on a port that cannot be reached.
        """
        block = port.get_system()
        function, sources = block.outputs[port.get_name()]
        key = block, "output", port.get_name()
        if key not in self._found:
            nodes = [self._step(block, source, level) for source in sources]
            self._add(key, _Computed(_flat(function), nodes))
        return self._found[key]

    def finish(self) -> None:
        """Adds what memories are kept of."""
        while self._later:
            number, block, level = self._later.pop()
            node = self.network.nodes[number]
            kept = [number, *(self._step(block, name, level) for name in node.step.kept)]
            self.network.nodes[number] = node._replace(kept=kept)

    def _step(self, block: ArrayBlock, name: str, level: Level) -> int:
        key = block, name
        if key not in self._found:
            step = block.steps[name]
            if is_leaf(step):
                self._found[key] = self._input(block, name, level)
            else:
                self._add(key, self._node(block, step, level))
            if isinstance(step, Memory):
                self._later.append((self._found[key], block, level))
        return self._found[key]

    def _node(self, block: ArrayBlock, step: Step, level: Level) -> Any:
        if isinstance(step, Constant):
            return _Computed(lambda value=step.value: value, [])
        if isinstance(step, Sample):
            source = None if step.source == TIME else self._step(block, step.source, level)
            return _Taken(step, source, self.network.hold(step.begin))
        sources = [self._step(block, source, level) for source in step.sources]
        if isinstance(step, Function):
            return _Computed(step.of, sources)
        begin = None if step.begin_of is None else self._step(block, step.begin_of[1], level)
        return _Remembered(step, sources, [], begin, self.network.hold(step.begin))

    def _input(self, block: ArrayBlock, name: str, level: Level) -> int:
        feed = level.feed(block.GetInputPort(name)) if block.HasInputPort(name) else None
        if feed is None:
            raise LookupError(name)
        port, inside = feed.level.leaf_output(feed.output)
        if isinstance(port.get_system(), ArrayBlock):
            return self.output(port, inside)
        shown = inside.exported(port)
        if shown is None:
            raise LookupError(name)
        key = shown.get_system(), shown.get_index()
        if key not in self._found:
            self.network.inputs.append((shown, block.steps[name]))
            self._add(key, len(self.network.inputs) - 1)
        return self._found[key]

    def _add(self, key: Any, node: Any) -> None:
        self.network.nodes.append(node)
        self._found[key] = len(self.network.nodes) - 1


def _flat(function: Callable[..., Any]) -> Callable[..., Array]:
    return lambda *steps: np.reshape(function(*steps), -1)


def _is_sampled(port: OutputPort, level: Level, period: float, path: Sequence[Any] = ()) -> bool:
    """Whether an output of an ArrayBlock follows from samples, all of that period, and from constants alone."""
    block, name = port.get_system(), port.get_name()
    return name in block.outputs and all(
        _is_step_sampled(block, source, level, period, path) for source in block.outputs[name][1]
    )


def _is_step_sampled(block: ArrayBlock, name: str, level: Level, period: float, path: Sequence[Any]) -> bool:
    step = block.steps[name]
    if isinstance(step, Constant) or (block, name) in path:
        return True
    if isinstance(step, Sample):
        return block.period == period
    path = [*path, (block, name)]
    if is_leaf(step):
        feed = level.feed(block.GetInputPort(name)) if block.HasInputPort(name) else None
        if feed is None:
            return False
        port, inside = feed.level.leaf_output(feed.output)
        return isinstance(port.get_system(), ArrayBlock) and _is_sampled(port, inside, period, path)
    kept = step.kept if isinstance(step, Memory) else ()
    if isinstance(step, Memory) and block.period != period:
        return False
    return all(_is_step_sampled(block, each, level, period, path) for each in (*step.sources, *kept))


class _Read(NamedTuple):
    """A port of an ArrayBlock, and the wire at the root by which something reads it during a run."""

    port: OutputPort
    level: Level
    wire: Feed


def add_live(builder: DiagramBuilder, period: float) -> None:
    """Adds `live` to a diagram that is otherwise complete, if anything in it reads blocks made of functions.

    It takes the place of these blocks wherever they are read, and they rest.

    Args:
        builder: of the diagram.
        period: of the samples, s.
    """
    reads, running = _find_reads(builder, period)
    if reads:
        _replace(builder, reads, period)
    for system, _ in leaf_systems(builder):
        if isinstance(system, ArrayBlock):
            system.wake() if system in running else system.rest()


def wake_all(builder: DiagramBuilder) -> None:
    """Lets every block of a diagram run by itself, so that every port can be read at any time."""
    for system, _ in leaf_systems(builder):
        if isinstance(system, ArrayBlock):
            system.wake()


def _find_reads(builder: DiagramBuilder, period: float) -> tuple[list[_Read], set[ArrayBlock]]:
    """What `live` can compute for the blocks that read it, and the blocks that must run by themselves."""
    reads: list[_Read] = []
    running: set[ArrayBlock] = set()
    pending = [(system, level) for system, level in leaf_systems(builder) if not isinstance(system, ArrayBlock)]
    while pending:
        system, level = pending.pop()
        for port in map(system.get_input_port, range(system.num_input_ports())):
            wire = level.feed(port)
            if wire is None:
                continue
            read, inside = wire.level.leaf_output(wire.output)
            block = read.get_system()
            if not isinstance(block, ArrayBlock):
                continue
            if wire.level.diagram is None and _is_sampled(read, inside, period):
                reads.append(_Read(read, inside, wire))
            elif block not in running:
                running.add(block)
                pending.append((block, inside))
    return reads, running


def _replace(builder: DiagramBuilder, reads: Sequence[_Read], period: float) -> None:
    compiler = _Compiler()
    outputs = {_name(read.wire.output): (compiler.output(read.port, read.level), read.port.size()) for read in reads}
    compiler.finish()
    live = builder.AddNamedSystem("live", LiveSignals(compiler.network, outputs, period))
    for i, (port, _) in enumerate(compiler.network.inputs):
        builder.Connect(port, live.get_input_port(i))
    for wire in {(read.wire.input.get_system(), read.wire.input.get_index()): read.wire for read in reads}.values():
        builder.Disconnect(wire.output, wire.input)
        builder.Connect(live.GetOutputPort(_name(wire.output)), wire.input)


def _name(port: OutputPort) -> str:
    return f"{port.get_system().get_name()}.{port.get_name()}"
