"""The blocks of a station for E environments at once: values of ports are arrays (E, size).

A block whose outputs follow from its inputs and its memory is one graph of steps, computed once for all environments:
an ArrayBlock brings its own, `GRAPHS` makes those of Drake's blocks. A further kind of block is an entry there.
"""

from collections.abc import Callable, Mapping, Sequence
from functools import partial
from itertools import pairwise
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import Context, InputPort, LeafSystem, OutputPort
from pydrake.systems.primitives import (
    Adder,
    AffineSystem,
    BarycentricMeshSystem,
    ConstantVectorSource,
    Demultiplexer,
    MatrixGain,
    Multiplexer,
    PassThrough,
    Saturation,
    TrajectorySource,
)

from soft_gripper.array_block import ArrayBlock, check_finite
from soft_gripper.arrays import Array
from soft_gripper.control.grip import GripForceBound
from soft_gripper.run_begin import RunBegin
from soft_gripper.steps import TIME, Memory, Step, Steps, same

Read = Callable[[int], Any]  # the value of an input, by its number; None: it is open
Rows = NDArray[np.int_]  # numbers of environments


class Block(Protocol):
    """A leaf system for E environments."""

    @property
    def period(self) -> float | None:
        """Time between its updates, s; None: it has no state."""

    def clear(self, rows: Rows) -> None:
        """Sets some environments to the state before they are initialized."""

    def begin(self, read: Read, rows: Rows) -> None:
        """Prepares the first state of some environments, from the inputs when a run is initialized."""

    def output(self, number: int, read: Read, time: float) -> Array:
        """The value of an output, (E, size); or (1, size) if it is the same in all environments."""

    def advance(self, read: Read, time: float, active: Rows) -> None:
        """Prepares the state after an update."""

    def commit(self) -> None:
        """Adopts the prepared state."""

    def forget(self) -> None:
        """Discards values that depend on the inputs, which have changed."""


class Functions:
    """Steps with the environments as leading axis."""

    def __init__(self, block: LeafSystem, steps: Steps, count: int):
        """`steps` of the block for `count` environments, or for one if all have equal values."""
        self.period, self._block, self._steps, self._count = _period(block), block, steps, count
        self._names = [port.get_name() for port in _outputs(block)]
        self._memories = {name: step.memory for name, step in steps.items() if step.memory is not None}
        self._state = {name: memory.begin for name, memory in self._memories.items()}
        self._next, self._is_later = dict(self._state), np.zeros(count, bool)
        self._known = _StepValues({port.get_name(): i for i, port in enumerate(_inputs(block))}, count)

    def takes_time(self, number: int) -> bool:
        """Whether an output changes with the time between samples."""
        return self._steps.takes_time(self._names[number])

    def clear(self, rows: Rows) -> None:
        self.forget()
        for name, state in self._state.items():
            self._state[name] = np.array(state)
            self._state[name][rows] = self._memories[name].begin[rows]
        self._next = {name: state.copy() for name, state in self._state.items()}
        if self.period is not None:
            self._is_later[rows] = False

    def begin(self, read: Read, rows: Rows) -> None:
        self._known.take(read, 0.0)
        for name, memory in self._memories.items():
            if memory.begin_of is not None:
                function, source = memory.begin_of
                self._next[name][rows] = self._value(function, [source])[rows]

    def output(self, number: int, read: Read, time: float) -> Array:
        self._known.take(read, time)
        value = np.asarray(self._value(*self._steps.outputs[self._names[number]]))
        return value if value.ndim == 2 else value.reshape(self._count, -1)

    def advance(self, read: Read, time: float, active: Rows) -> None:
        """See Block; at the first sample there is no memory."""
        self._known.take(read, time)
        for name, memory in self._memories.items():
            if memory.at_first:
                self._next[name] = self._value(memory.keep, memory.sources)
            elif self._is_later.any():
                self._next[name] = self._if_later(name, self._value(memory.keep, memory.sources))
        self._is_later = np.ones_like(self._is_later)

    def _if_later(self, name: str, value: Array) -> Array:
        """New state in the environments after their first sample; the others keep theirs."""
        if self._is_later.all():
            return value
        return np.where(self._is_later.reshape(-1, *[1] * (value.ndim - 1)), value, self._state[name])

    def commit(self) -> None:
        self._state = dict(self._next)
        self.forget()

    def forget(self) -> None:
        self._known.clear()

    def _value(self, function: Callable[..., Any], sources: Sequence[str]) -> Any:
        """Function that returns a value of evaluated steps."""
        try:
            return function(*[self._steps.value(source, self._known, self._state) for source in sources])
        except ValueError:
            check_finite(self._block, {name: self._known[name] for name in self._known.numbers})
            raise


class _StepValues(dict[str, Any]):
    """Values of steps in E environments; inputs are read when a step takes them."""

    def __init__(self, numbers: Mapping[str, int], count: int):
        """`numbers` of the inputs, by name."""
        super().__init__()
        self.numbers, self._count = numbers, count

    def take(self, read: Read, time: float) -> None:
        """Sets the source of inputs and the time, s."""
        self._inputs, self._time = read, time

    def __missing__(self, name: str) -> Array | None:
        if name == TIME:
            return np.full((self._count, 1), self._time)
        value = self._inputs(self.numbers[name])
        if value is None:
            return value
        self[name] = np.broadcast_to(value, (self._count, value.shape[-1])) if len(value) < self._count else value
        return self[name]


class PerDiagram:
    """A block whose counterparts differ between diagrams: one block for the environments of each."""

    def __init__(self, parts: Sequence[tuple[Block, Rows]]):
        """The blocks, and the environments of each."""
        self.period, self._parts = parts[0][0].period, parts
        self._count = sum(len(rows) for _, rows in parts)

    def clear(self, rows: Rows) -> None:
        for block, part_rows in self._parts:
            block.clear(self._part_indices(rows, part_rows))

    def begin(self, read: Read, rows: Rows) -> None:
        for block, part_rows in self._parts:
            block.begin(_select_rows(read, part_rows), self._part_indices(rows, part_rows))

    def output(self, number: int, read: Read, time: float) -> Array:
        outputs = [block.output(number, _select_rows(read, part_rows), time) for block, part_rows in self._parts]
        values = np.empty((self._count, outputs[0].shape[1]))
        for value, (_, part_rows) in zip(outputs, self._parts, strict=True):
            values[part_rows] = value
        return values

    def advance(self, read: Read, time: float, active: Rows) -> None:
        for block, part_rows in self._parts:
            block.advance(_select_rows(read, part_rows), time, self._part_indices(active, part_rows))

    def commit(self) -> None:
        for block, _ in self._parts:
            block.commit()

    def forget(self) -> None:
        for block, _ in self._parts:
            block.forget()

    def _part_indices(self, rows: Rows, part_rows: Rows) -> Rows:
        """Indices of environments among those of a part of the block."""
        is_wanted = np.zeros(self._count, bool)
        is_wanted[rows] = True
        return np.flatnonzero(is_wanted[part_rows])


def _select_rows(read: Read, part_rows: Rows) -> Read:
    """Restricts inputs to some environments."""

    def some(number: int) -> Any:
        value = read(number)
        return value if value is None or len(value) == 1 else value[part_rows]

    return some


class Streams:
    """Block of values known before the run: draws of a random source, or inputs of the whole diagram.

    Sources draw before other blocks take their samples, as in Drake.
    """

    period: float | None = None

    def __init__(self, values: Array):
        """`values` at every sample, (T, E, size); the last ones stay."""
        self._values, self._number = values, np.zeros(values.shape[1], int)

    def give(self, values: Array, rows: Rows) -> None:
        """Restarts some environments with other values, (T, rows, size)."""
        self._values[:, rows], self._number[rows] = values, 0

    def draw(self) -> None:
        """Advances to the next sample."""
        self._number = np.minimum(self._number + 1, len(self._values) - 1)

    def clear(self, rows: Rows) -> None:
        """Does nothing: `give` sets the values."""

    def begin(self, read: Read, rows: Rows) -> None:
        """Does nothing: `give` sets the values."""

    def output(self, number: int, read: Read, time: float) -> Array:
        return self._values[self._number, np.arange(len(self._number))]

    def advance(self, read: Read, time: float, active: Rows) -> None:
        """Does nothing: `draw` advances."""

    def commit(self) -> None:
        """Does nothing: `draw` advances."""

    def forget(self) -> None:
        """Does nothing: there are no inputs."""


class Contexts:
    """Block of any other leaf system with a state: a context for each of E environments, or a shared one (E = 1)."""

    def __init__(self, block: LeafSystem, count: int):
        self._block, self._inputs = block, range(block.num_input_ports())
        self._runs = [Simulator(block) for _ in range(count)]
        self.period = _period(block) or 0.0
        self._updates = [_NO_UPDATE] * count  # made so far

    def clear(self, rows: Rows) -> None:
        for i in rows if len(self._runs) > 1 else ():
            self._runs[i], self._updates[i] = Simulator(self._block), _NO_UPDATE

    def _give(self, read: Read) -> None:
        for number in self._inputs:
            port = self._block.get_input_port(number)
            values = np.broadcast_to(read(number), (len(self._runs), port.size()))
            for run, value in zip(self._runs, values, strict=True):
                port.FixValue(run.get_mutable_context(), value)

    def begin(self, read: Read, rows: Rows) -> None:
        self._give(read)

    def output(self, number: int, read: Read, time: float) -> Array:
        self._give(read)
        port = self._block.get_output_port(number)
        return np.array([port.Eval(run.get_context()) for run in self._runs])

    def advance(self, read: Read, time: float, active: Rows) -> None:
        self._give(read)

    def commit(self) -> None:
        """Advances the contexts, whose inputs are still those of the update; see Block."""
        for i, run in enumerate(self._runs):
            self._updates[i] += 1
            if not self._updates[i]:
                run.Initialize()
            elif self.period:
                run.AdvanceTo(self._updates[i] * self.period)  # a sum of periods would drift away from the updates

    def forget(self) -> None:
        """Does nothing: inputs are read with every output."""


_NO_UPDATE = -1


def _inputs(block: LeafSystem) -> list[InputPort]:
    return [block.get_input_port(i) for i in range(block.num_input_ports())]


def _outputs(block: LeafSystem) -> list[OutputPort]:
    return [block.get_output_port(i) for i in range(block.num_output_ports())]


def _period(block: LeafSystem) -> float | None:
    """Time between the updates of a block, s; None: it makes none."""
    update_timing = block.GetUniquePeriodicDiscreteUpdateAttribute()
    return None if update_timing is None else float(update_timing.period_sec())


def direct(block: LeafSystem, *functions: Callable[..., Array], sources: Sequence[str] = ()) -> Steps:
    """Steps of a block without memory.

    Args:
        block: without a state.
        functions: of `sources` and all inputs, one for each output.
        sources: further ones, such as the time.
    """
    inputs = [port.get_name() for port in _inputs(block)]
    names = [port.get_name() for port in _outputs(block)]
    outputs = {name: (function, [*sources, *inputs]) for name, function in zip(names, functions, strict=True)}
    return Steps({name: Step() for name in inputs}, outputs)


def context_steps(block: LeafSystem) -> Steps:
    """Steps of any block without a state, evaluated in one context, one environment after the other."""
    context = block.CreateDefaultContext()
    functions = [partial(_evaluate, port, _inputs(block), context) for port in _outputs(block)]
    return direct(block, *functions, sources=[TIME])


def _evaluate(port: OutputPort, inputs: Sequence[InputPort], context: Context, times: Array, *signals: Array) -> Array:
    """Output in every environment; NaN where the block fails because the environment has diverged."""
    rows = []
    for time, *values in zip(times[:, 0].tolist(), *signals, strict=True):
        context.SetTime(time)
        for input_port, value in zip(inputs, values, strict=True):
            input_port.FixValue(context, value)
        try:
            rows.append(np.array(port.Eval(context)))
        except (RuntimeError, SystemExit):  # the latter comes from failed conditions of Drake
            if all(np.isfinite(value).all() for value in values):
                raise
            rows.append(np.full(port.size(), np.nan))
    return np.array(rows)


def _affine(block: AffineSystem) -> Steps:
    """Steps of a block in discrete steps, or without a state."""
    A, B, C, D = (np.array(matrix).T for matrix in (block.A(), block.B(), block.C(), block.D()))
    state_offset, output_offset = (np.array(vector, dtype=float) for vector in (block.f0(), block.y0()))
    u, y = block.get_input_port().get_name(), block.get_output_port().get_name()
    memory = Memory(np.zeros(len(A)), lambda x, u: x @ A + u @ B + state_offset, ("x", u), at_first=True)
    steps = {u: Step(), "x": Step(same, (), memory, None)}
    if D.any():
        return Steps(steps, {y: (lambda x, u: x @ C + output_offset + u @ D, ["x", u])})
    return Steps(steps, {y: (lambda x: x @ C + output_offset, ["x"])})


def _saturation(block: Saturation) -> Steps:
    """Steps of a saturation, whose limits are its outputs for the largest floats."""
    size, context = block.get_input_port().size(), block.CreateDefaultContext()

    def limited(value: float) -> Array:
        block.get_input_port().FixValue(context, np.full(size, value))
        return np.array(block.get_output_port().Eval(context))

    largest_float = np.finfo(float).max
    lower_limits, upper_limits = limited(-largest_float), limited(largest_float)
    return direct(block, lambda u: np.minimum(np.maximum(u, lower_limits), upper_limits))


def _constant(block: ConstantVectorSource) -> Steps:
    value = np.array(block.get_output_port().Eval(block.CreateDefaultContext()))[None]
    return direct(block, lambda: value)


def _parts(block: Demultiplexer) -> Steps:
    ends = np.cumsum([0, *(port.size() for port in _outputs(block))])
    return direct(block, *(partial(_columns, slice(begin, end)) for begin, end in pairwise(ends)))


def _columns(columns: slice, values: Array) -> Array:
    return values[:, columns]


def _gain(block: MatrixGain) -> Steps:
    gain = np.array(block.D()).T
    return direct(block, lambda u: u @ gain)


def gains(parts: Mapping[MatrixGain, Rows]) -> Steps:
    """Steps of gains that differ between environments; `parts` has the environments of each."""
    first, count = next(iter(parts)), sum(map(len, parts.values()))
    matrices = np.empty((count, *np.shape(first.D())[::-1]))
    for block, rows in parts.items():
        matrices[rows] = np.transpose(block.D())
    return direct(first, lambda u: (u[:, None] @ matrices)[:, 0])


def side_by_side(*values: Array) -> Array:
    """Concatenates values, (E, size)."""
    return np.concatenate(values, axis=1)


def _add_values(*values: Array) -> Array:
    total_value = values[0]
    for value in values[1:]:
        total_value = total_value + value
    return total_value


def _mean_bound(*signals: Array) -> Array:
    """Mean upper bound of force intervals; `signals` alternate between intervals and contacts."""
    bounds = [
        np.where(touch != 0, interval[:, -1:], 0.0) for interval, touch in zip(signals[::2], signals[1::2], strict=True)
    ]
    return _add_values(*bounds) / len(bounds)


Graphs = Mapping[type[LeafSystem], Callable[[Any], Steps]]
GRAPHS: Graphs = {  # of the steps of a block, by its class
    Adder: lambda block: direct(block, _add_values),
    AffineSystem: _affine,
    ArrayBlock: lambda block: block.steps,
    ConstantVectorSource: _constant,
    Demultiplexer: _parts,
    GripForceBound: lambda block: direct(block, _mean_bound),
    MatrixGain: _gain,
    Multiplexer: lambda block: direct(block, side_by_side),
    PassThrough: lambda block: direct(block, same),
    RunBegin: lambda block: direct(block, lambda: np.zeros((1, 1))),  # runs begin at time 0
    Saturation: _saturation,
}


def contents(block: LeafSystem, times: Array) -> Any:
    """Values that determine a block without steps at some times, s; the block itself if they are unknown."""
    if isinstance(block, BarycentricMeshSystem):
        return np.array(block.get_mesh().get_all_mesh_points()), np.array(block.get_output_values())
    return context_steps(block).output("y0", {TIME: times}) if isinstance(block, TrajectorySource) else block
