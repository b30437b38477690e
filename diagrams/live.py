"""One block, `live`, for all blocks made of functions that something reads in a diagram that nobody sees.

It calls the functions of these blocks (ArrayBlock) in one event at every sample: a Python block costs more by its
events, ports and caches than by its arithmetic. It is as fast as the blocks themselves where a run is open-loop, and up
to 1.5 times as fast in a closed loop.

`live` can stand for a block if that depends on other blocks only through its samples; its outputs then change at
samples only, and are state. Others, and those that are read inside of the same part of the diagram, run by themselves.
"""

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, NamedTuple

import numpy as np
from pydrake.systems.framework import (
    Context,
    Diagram,
    DiagramBuilder,
    DiscreteValues,
    InputPort,
    LeafSystem,
    OutputPort,
    System,
)

from soft_gripper.array_block import (
    TIME,
    ArrayBlock,
    Constant,
    Function,
    Memory,
    Sample,
    Step,
    Value,
    is_leaf,
    sources_of,
)
from soft_gripper.arrays import Array
from soft_gripper.cached import weakly
from soft_gripper.diagrams.wires import Feed, Level
from soft_gripper.signals import export_outputs


class _Node(NamedTuple):
    """A step of one block, or of several alike at once, along a leading axis."""

    of: Callable[..., Any]  # of the values of the sources
    sources: Sequence[int]


class _Taken(NamedTuple):
    """A sample."""

    step: Sample
    source: int | None  # None: the time
    held: slice  # where it is kept in the state
    shape: tuple[int, ...]


class _Remembered(NamedTuple):
    """Values that follow from a memory, and what is remembered of it."""

    step: Memory
    sources: Sequence[int]
    kept: Sequence[int]  # what is remembered of, the step itself first
    begin: int | None  # the node from which it begins
    held: slice
    shape: tuple[int, ...]


@dataclass(eq=False)
class Network:
    """The steps of several blocks, each after those that it follows from.

    The first entry of the state tells whether a sample has been taken.
    """

    nodes: list[Any] = field(default_factory=list)  # an int is the number of an input
    begin: list[Array] = field(default_factory=list)  # of what is held between samples

    def add(self, node: Any) -> int:
        """The number of a new node."""
        self.nodes.append(node)
        return len(self.nodes) - 1

    def hold(self, begin: Array) -> slice:
        """Room for an array in the state."""
        start = 1 + sum(map(len, self.begin))
        self.begin.append(begin.ravel())
        return slice(start, start + begin.size)

    @property
    def initial(self) -> Array:
        """The state before a run."""
        return np.concatenate([np.zeros(1), *self.begin])

    def sample(self, read: Sequence[Any], held: Array, time: float, is_begin: bool) -> tuple[list[Any], Array]:
        """The values of all nodes at a sample, and the state after it.

        Args:
            read: values of the inputs.
            held: state.
            time: s.
            is_begin: the run is initialized; nothing is remembered of that.
        """
        values: list[Any] = []
        for node in self.nodes:
            if isinstance(node, _Node):
                values.append(node.of(*[values[i] for i in node.sources]))
            elif isinstance(node, int):
                values.append(read[node])
            elif isinstance(node, _Taken):
                is_taken = node.step.at_initialization if is_begin else node.step.at_first or held[0] > 0
                present = np.array([time]) if node.source is None else values[node.source]
                values.append(present if is_taken else held[node.held].reshape(node.shape))
            else:
                memory = self._begun(node, values) if is_begin else None
                memory = held[node.held].reshape(node.shape) if memory is None else memory
                values.append(node.step.of(memory, *[values[i] for i in node.sources]))
        return values, self._state(values, held, is_begin)

    def _state(self, values: list[Any], held: Array, is_begin: bool) -> Array:
        after = held.copy()
        after[0] = 0.0 if is_begin else 1.0
        for number, node in enumerate(self.nodes):
            if isinstance(node, _Taken):
                after[node.held] = values[number].ravel()
            elif isinstance(node, _Remembered):
                memory = self._begun(node, values) if is_begin else node.step.keep(*[values[i] for i in node.kept])
                if memory is not None:
                    after[node.held] = memory.ravel()
        return after

    @staticmethod
    def _begun(node: _Remembered, values: list[Any]) -> Array | None:
        """Memory with which a run is initialized; None if that is the initial state."""
        if node.begin is None or node.step.begin_of is None:
            return None
        return node.step.begin_of[0](values[node.begin])


class LiveSignals(LeafSystem):
    """Computes, in one event at every sample, what the loop of a diagram reads of blocks made of functions.

    ::

        {block}.{port} of the plant and its drive ---> +-------------+
                                                       | LiveSignals | ---> {block}.{port} of sensors, estimators ...
                                                       +-------------+
    """

    def __init__(self, network: Network, inputs: Sequence["_Outside"], outputs: Mapping[str, "_Found"], period: float):
        """`outputs` by the names of the ports; sampled every `period` s."""
        super().__init__()
        self._network, self._outputs = network, [(found.node, found.lane) for found in outputs.values()]
        self._ports = [self._declare_input(*each) for each in inputs]
        self._held = int(self.DeclareDiscreteState(network.initial))
        for name, found in outputs.items():
            self.DeclareStateOutputPort(name, self.DeclareDiscreteState(found.size))
        self.DeclareInitializationDiscreteUpdateEvent(weakly(self._begin))
        self.DeclarePeriodicDiscreteUpdateEvent(period, 0.0, weakly(self._sample))

    def _declare_input(self, port: OutputPort | InputPort, step: Step) -> InputPort:
        name = name_of(port)
        if isinstance(step, Value):
            return self.DeclareAbstractInputPort(name, step.model)
        return self.DeclareVectorInputPort(name, port.size())

    def _begin(self, context: Context, values: DiscreteValues) -> None:
        if not context.get_discrete_state(self._held).value()[0]:  # otherwise the run goes on
            self._update(context, values, True)

    def _sample(self, context: Context, values: DiscreteValues) -> None:
        self._update(context, values, False)

    def _update(self, context: Context, values: DiscreteValues, is_begin: bool) -> None:
        held = context.get_discrete_state(self._held).value()
        read = [port.Eval(context) for port in self._ports]
        found, after = self._network.sample(read, held, context.get_time(), is_begin)
        values.set_value(self._held, after)
        for group, (node, lane) in enumerate(self._outputs, self._held + 1):
            values.set_value(group, found[node] if lane is None else found[node][lane])


class _Outside(NamedTuple):
    """A port of a block of another kind, or an input that it feeds already, and a step that it feeds."""

    port: OutputPort | InputPort
    step: Step


class _Found(NamedTuple):
    """Where the value of a port is in a network."""

    node: int
    lane: int | None  # along the leading axis of the node, None if it has none
    size: int


class _OrderError(Exception):
    """A block follows from another that is alike, so that they cannot be computed at once."""


class _Compiler:
    """Finds the steps that ports follow from; of blocks that are alike, such as those of equal fingers, at once."""

    def __init__(self, alike: Mapping[ArrayBlock, Sequence[ArrayBlock]], levels: Mapping[ArrayBlock, Level]):
        """`alike` has for each block those that are computed together with it, `levels` where they are."""
        self.network = Network()
        self.inputs: list[_Outside] = []
        self._alike, self._levels = alike, levels
        self._found: dict[Any, int] = {}
        self._open: set[Any] = set()  # steps that are being added
        self._later: list[tuple[int, ArrayBlock]] = []  # memories, of which the `kept` are still missing

    def output(self, port: OutputPort) -> _Found:
        """A port of an ArrayBlock; its vector is flat."""
        name, lanes = port.get_name(), self._alike[port.get_system()]
        key = lanes[0], "output", name
        if key not in self._found:
            function, sources = lanes[0].outputs[name]
            nodes = [self._step(lanes[0], source) for source in sources]
            shape = (-1,) if len(lanes) == 1 else (len(lanes), -1)
            self._found[key] = self.network.add(_Node(_reshaped(function, shape), nodes))
        return _Found(self._found[key], None if len(lanes) == 1 else lanes.index(port.get_system()), port.size())

    def finish(self) -> None:
        """Adds what is remembered, which may come after what follows from it."""
        while self._later:
            number, block = self._later.pop()
            node = self.network.nodes[number]
            kept = [number, *(self._step(block, name) for name in node.step.kept)]
            self.network.nodes[number] = node._replace(kept=kept)

    def _step(self, block: ArrayBlock, name: str) -> int:
        """The node of a step of a block and of those computed with it; `block` is the first of them."""
        key = block, name
        if key in self._open:
            raise _OrderError
        if key not in self._found:
            self._open.add(key)
            step = block.steps[name]
            self._found[key] = self._input(block, name) if is_leaf(step) else self._add(block, name)
            self._open.remove(key)
        return self._found[key]

    def _add(self, block: ArrayBlock, name: str) -> int:
        step, lanes = block.steps[name], self._alike[block]
        if isinstance(step, Constant):
            constants = [lane.steps[name] for lane in lanes]
            values = [each.value for each in constants if isinstance(each, Constant)]
            value = values[0] if len(lanes) == 1 else np.array(values)
            return self.network.add(_Node(lambda: value, []))
        if isinstance(step, Function):
            return self.network.add(_Node(step.of, [self._step(block, source) for source in step.sources]))
        assert isinstance(step, Sample | Memory)
        begin = step.begin if len(lanes) == 1 else np.broadcast_to(step.begin, (len(lanes), *step.begin.shape))
        if isinstance(step, Sample):
            source = None if step.source == TIME else self._step(block, step.source)
            return self.network.add(_Taken(step, source, self.network.hold(begin), begin.shape))
        sources = [self._step(block, source) for source in step.sources]
        first = None if step.begin_of is None else self._step(block, step.begin_of[1])
        number = self.network.add(_Remembered(step, sources, [], first, self.network.hold(begin), begin.shape))
        self._later.append((number, block))
        return number

    def _input(self, block: ArrayBlock, name: str) -> int:
        lanes = self._alike[block]
        found = [self._fed(lane, name) for lane in lanes]
        nodes, places = [each.node for each in found], [each.lane for each in found]
        if len(found) == 1 and places[0] is None:
            return nodes[0]
        is_whole = len(set(nodes)) == 1 and places == list(range(len(lanes)))
        if is_whole and len(lanes) > 1 and self._lanes_of(lanes[0], name) == len(lanes):
            return nodes[0]
        return self.network.add(_Node(_gathered(places), nodes))

    def _lanes_of(self, block: ArrayBlock, name: str) -> int:
        """How many blocks are computed with the one that feeds an input."""
        feed = self._levels[block].feed(block.GetInputPort(name))
        source = None if feed is None else array_source(feed)
        return 1 if source is None else len(self._alike[source[0].get_system()])

    def _fed(self, block: ArrayBlock, name: str) -> _Found:
        """Feed of an input of a block."""
        feed = self._levels[block].feed(block.GetInputPort(name))
        assert feed is not None
        source = array_source(feed)
        if source is not None:
            return self.output(source[0])
        outside = _outside(feed)
        assert outside is not None
        key = (feed.system, feed.output_index)
        if key not in self._found:
            self.inputs.append(_Outside(outside, block.steps[name]))
            self._found[key] = self.network.add(len(self.inputs) - 1)
        return _Found(self._found[key], None, 0)


def _reshaped(function: Callable[..., Any], shape: tuple[int, ...]) -> Callable[..., Array]:
    return lambda *steps: np.reshape(function(*steps), shape)


def _gathered(places: Sequence[int | None]) -> Callable[..., Array]:
    """From values, or the entry of each at its place along the leading axis, to one array."""

    def gathered(*values: Array) -> Array:
        chosen = [value if place is None else value[place] for value, place in zip(values, places, strict=True)]
        return chosen[0] if len(chosen) == 1 else np.array(chosen)

    return gathered


def array_source(feed: Feed) -> tuple[OutputPort, Level] | None:
    """The port of an ArrayBlock behind a wire, and its level; None if it is a port of another block."""
    if not isinstance(feed.system, ArrayBlock | Diagram):
        return None
    port, level = feed.level.leaf_output(feed.output)
    return (port, level) if isinstance(port.get_system(), ArrayBlock) else None


def _outside(feed: Feed) -> OutputPort | InputPort | None:
    """Port at the root for the one behind a wire: an input that it feeds, or the port that exports it."""
    return feed.input if feed.level.diagram is None else feed.level.exported(feed.output)


class _Reach:
    """Which steps `live` can compute: those that follow from samples of one period and from constants alone.

    What is sampled must itself not be sampled by a block that `live` stands for: it would be that of the sample before.
    """

    def __init__(self, period: float):
        self._period = period
        self.levels: dict[ArrayBlock, Level] = {}  # of the blocks on the way
        self._assumed: set[Any] = set()  # memories; what they remember leads back to them
        self._open: set[Any] = set()  # steps that are being looked at

    def output(self, port: OutputPort, level: Level) -> bool:
        """Whether a port of an ArrayBlock can be computed."""
        block, name = port.get_system(), port.get_name()
        self.levels[block] = level
        return name in block.outputs and all(self._step(block, source, True) for source in block.outputs[name][1])

    def _step(self, block: ArrayBlock, name: str, is_steady: bool) -> bool:
        """Whether a step can be computed; if `is_steady`, from samples and constants alone, otherwise without any."""
        step, key = block.steps[name], (block, name, is_steady)
        if key in self._assumed or isinstance(step, Constant):
            return True
        if key in self._open:
            return False
        if isinstance(step, Sample | Memory) and not (is_steady and block.period == self._period):
            return False
        if isinstance(step, Memory):
            self._assumed.add(key)
        self._open.add(key)
        found = self._looked_at(block, name, is_steady)
        self._open.remove(key)
        return found

    def _looked_at(self, block: ArrayBlock, name: str, is_steady: bool) -> bool:
        step = block.steps[name]
        if is_leaf(step):
            return self._fed(block, name, is_steady)
        if isinstance(step, Sample):
            return step.source == TIME or self._step(block, step.source, False)
        others = step.kept if isinstance(step, Memory) else ()
        return all(self._step(block, each, is_steady) for each in (*sources_of(step), *others))

    def _fed(self, block: ArrayBlock, name: str, is_steady: bool) -> bool:
        feed = self.levels[block].feed(block.GetInputPort(name)) if block.HasInputPort(name) else None
        if feed is None:
            return False
        source = array_source(feed)
        if source is None:
            return not is_steady and _outside(feed) is not None
        port, self.levels[source[0].get_system()] = source
        names = port.get_system().outputs
        return port.get_name() in names and all(
            self._step(port.get_system(), step, is_steady) for step in names[port.get_name()][1]
        )


def _alike(blocks: Iterable[ArrayBlock]) -> dict[ArrayBlock, list[ArrayBlock]]:
    """The blocks that can be computed together with each: of the same class, made of equal things."""
    groups: dict[Any, list[ArrayBlock]] = {}
    for block in blocks:
        key = (type(block), block.made_of) if block.takes_axes else block
        groups.setdefault(key, []).append(block)
    return {block: group for group in groups.values() for block in group}


class LiveReads:
    """Signals that `live` is to compute, sampled every `period` s."""

    def __init__(self, period: float):
        self._period = period
        self._reads: dict[tuple[System, int], tuple[OutputPort, Feed]] = {}  # ports and wires, by the inputs that read
        self._levels: dict[ArrayBlock, Level] = {}

    def take(self, port: OutputPort, level: Level, wire: Feed) -> bool:
        """Takes the place of a port of an ArrayBlock, at a level, where a wire leads it; returns whether it can."""
        reach = _Reach(self._period)
        if wire.level.diagram is not None or not reach.output(port, level):
            return False
        self._reads[wire.input.get_system(), wire.input.get_index()] = port, wire
        self._levels |= reach.levels
        return True

    def add_to(self, builder: DiagramBuilder) -> Mapping[tuple[System, int], OutputPort]:
        """Adds `live`, if it has something to compute; returns its outputs by those that they replace."""
        if not self._reads:
            return {}
        block, inputs = self._compiled()
        builder.AddNamedSystem("live", block)
        for i, (port, _) in enumerate(inputs):
            connect = builder.ConnectToSame if isinstance(port, InputPort) else builder.Connect
            connect(port, block.get_input_port(i))
        replaced = {}
        for _, wire in self._reads.values():
            export_outputs(block, {name_of(wire.output): wire.output})
            output = replaced[wire.system, wire.output_index] = block.GetOutputPort(name_of(wire.output))
            builder.Disconnect(wire.output, wire.input)
            builder.Connect(output, wire.input)
        return replaced

    def _compiled(self) -> tuple[LiveSignals, Sequence[_Outside]]:
        for alike in (_alike(self._levels), {block: [block] for block in self._levels}):
            compiler = _Compiler(alike, self._levels)
            try:
                outputs = {name_of(wire.output): compiler.output(port) for port, wire in self._reads.values()}
                compiler.finish()
            except _OrderError:
                continue
            return LiveSignals(compiler.network, compiler.inputs, outputs, self._period), compiler.inputs
        raise AssertionError("a block follows from itself")


def name_of(port: OutputPort | InputPort) -> str:
    """The name of a port in the block `live`."""
    return f"{port.get_system().get_name()}.{port.get_name()}"
