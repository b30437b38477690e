"""The blocks of a station for E environments at once: values of ports are arrays (E, size).

A block made of functions (ArrayBlock) calls them once for all environments, and so do Drake's blocks of linear algebra.
A block that is one Python object per run, such as the state machine of a task, is asked once for each environment.
"""

from collections.abc import Callable, Mapping, Sequence
from types import MappingProxyType
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import LeafSystem, OutputPort
from pydrake.systems.primitives import (
    Adder,
    AffineSystem,
    ConstantVectorSource,
    Demultiplexer,
    MatrixGain,
    Multiplexer,
    PassThrough,
    Saturation,
)

from soft_gripper.array_block import ArrayBlock, check_finite
from soft_gripper.arrays import Array
from soft_gripper.control.grip import GripForceBound
from soft_gripper.control.task import GripObservation, Progress, TaskMachine
from soft_gripper.fingers.pressure_drive import Leak
from soft_gripper.steps import TIME, Step

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
        """Takes on the state that was prepared."""


class Stateless:
    """A block whose outputs follow from its inputs at once."""

    period: float | None = None

    def __init__(self, function: Callable[..., Array], inputs: int):
        """`function` takes the inputs, and returns its only output."""
        self._function, self._inputs = function, inputs

    def clear(self, rows: Rows) -> None:
        """It has no state."""

    def begin(self, read: Read, rows: Rows) -> None:
        """It has no state."""

    def output(self, number: int, read: Read, time: float) -> Array:
        """See Block."""
        return self._function(*map(read, range(self._inputs)))

    def advance(self, read: Read, time: float, active: Rows) -> None:
        """It has no state."""

    def commit(self) -> None:
        """It has no state."""


class Given(Stateless):
    """An input of the whole diagram."""

    def __init__(self, value: Array):
        """`value`, (E, size)."""
        self._value = value

    def output(self, number: int, read: Read, time: float) -> Array:
        """See Block."""
        return self._value


class Parts(Stateless):
    """A Demultiplexer."""

    def __init__(self, block: Demultiplexer):
        sizes = [block.get_output_port(i).size() for i in range(block.num_output_ports())]
        self._ends = np.cumsum([0, *sizes])

    def output(self, number: int, read: Read, time: float) -> Array:
        """See Block."""
        return read(0)[:, self._ends[number] : self._ends[number + 1]]


class Affine:
    """An AffineSystem in discrete steps, or one without a state."""

    def __init__(self, block: AffineSystem, count: int):
        self.period = block.time_period() or None
        matrices = block.A(), block.B(), block.C(), block.D()
        self._A, self._B, self._C, self._D = (np.array(matrix).T for matrix in matrices)
        self._f0, self._y0 = (np.array(each, dtype=float) for each in (block.f0(), block.y0()))
        self._x: Array = np.zeros((count, len(self._A)))
        self._through = bool(self._D.any())
        self._next: Array = self._x

    def clear(self, rows: Rows) -> None:
        """It begins at zero."""
        self._x = self._x.copy()
        self._x[rows] = 0.0
        self._next = self._x

    def begin(self, read: Read, rows: Rows) -> None:
        """It begins at zero."""

    def output(self, number: int, read: Read, time: float) -> Array:
        """See Block."""
        found: Array = self._x @ self._C + self._y0
        return found + read(0) @ self._D if self._through else found

    def advance(self, read: Read, time: float, active: Rows) -> None:
        """See Block."""
        self._next = self._x @ self._A + read(0) @ self._B + self._f0

    def commit(self) -> None:
        """See Block."""
        self._x = self._next


class Functions:
    """An ArrayBlock, whose steps have the environments as leading axis."""

    def __init__(self, block: ArrayBlock, count: int, given: Mapping[str, Callable[[], Array]] = MappingProxyType({})):
        """`given` computes steps otherwise than the block does."""
        self.period, self._block = block.period, block
        numbers = {block.get_input_port(i).get_name(): i for i in range(block.num_input_ports())}
        self._names = [block.get_output_port(i).get_name() for i in range(block.num_output_ports())]
        self._steps = block.steps.stacked(count) if block.takes_axes else block.steps.row_by_row(count)
        self._steps |= {name: Step(function) for name, function in given.items()}
        self._memories = {name: step.memory for name, step in self._steps.items() if step.memory is not None}
        self._state = {name: memory.begin for name, memory in self._memories.items()}
        self._next, self._is_later = dict(self._state), np.zeros(count, bool)
        self._known = _Known(numbers, count)

    def forget(self) -> None:
        """Forgets what followed from the inputs."""
        self._known.clear()

    def clear(self, rows: Rows) -> None:
        """See Block."""
        for name, state in self._state.items():
            self._state[name] = np.array(state)
            self._state[name][rows] = self._memories[name].begin[rows]
        self._next = {name: state.copy() for name, state in self._state.items()}
        self._is_later[rows] = False
        self.forget()

    def begin(self, read: Read, rows: Rows) -> None:
        """See Block."""
        self._known.take(read, 0.0)
        for name, memory in self._memories.items():
            if memory.begin_of is not None:
                function, source = memory.begin_of
                self._next[name][rows] = self._value(function, [source])[rows]

    def output(self, number: int, read: Read, time: float) -> Array:
        """See Block."""
        self._known.take(read, time)
        return np.reshape(self._value(*self._steps.outputs[self._names[number]]), (len(self._is_later), -1))

    def advance(self, read: Read, time: float, active: Rows) -> None:
        """See Block; at the first sample nothing is remembered."""
        self._known.take(read, time)
        for name, memory in self._memories.items():
            if memory.at_first:
                self._next[name] = self._value(memory.keep, memory.sources)
            elif self._is_later.any():
                self._next[name] = self._if_later(name, self._value(memory.keep, memory.sources))
        self._is_later = np.ones_like(self._is_later)

    def _if_later(self, name: str, value: Array) -> Array:
        """A state, in those environments of which it is not the first sample."""
        if self._is_later.all():
            return value
        return np.where(self._is_later.reshape(-1, *[1] * (value.ndim - 1)), value, self._state[name])

    def commit(self) -> None:
        """See Block."""
        self._state = dict(self._next)
        self.forget()

    def _value(self, function: Callable[..., Any], sources: Sequence[str]) -> Any:
        """A function of steps."""
        try:
            return function(*[self._steps.value(source, self._known, self._state) for source in sources])
        except ValueError:
            check_finite(self._block, {name: self._known[name] for name in self._known.numbers})
            raise


class _Known(dict[str, Any]):
    """Steps that are known in E environments; inputs are read when a step takes them."""

    def __init__(self, numbers: Mapping[str, int], count: int):
        """`numbers` of the inputs, by name."""
        super().__init__()
        self.numbers, self._count = numbers, count

    def take(self, read: Read, time: float) -> None:
        """Takes the inputs and the time, s, from now on."""
        self._inputs, self._time = read, time

    def __missing__(self, name: str) -> Array | None:
        if name == TIME:
            return np.full((self._count, 1), self._time)
        value = self._inputs(self.numbers[name])
        if value is None:
            return value
        self[name] = np.broadcast_to(value, (self._count, value.shape[-1])) if len(value) < self._count else value
        found: Array = self[name]
        return found


class Several:
    """A block that differs between diagrams: one for all environments of each."""

    def __init__(self, parts: Sequence[tuple[Block, Rows]]):
        """The blocks, and the environments of each."""
        self.period, self._parts = parts[0][0].period, parts
        self._count = sum(len(own) for _, own in parts)

    def forget(self) -> None:
        """Forgets what followed from the inputs."""
        for block, _ in self._parts:
            if isinstance(block, Functions):
                block.forget()

    def clear(self, rows: Rows) -> None:
        """See Block."""
        for block, own in self._parts:
            block.clear(self._places(rows, own))

    def begin(self, read: Read, rows: Rows) -> None:
        """See Block."""
        for block, own in self._parts:
            block.begin(_among(read, own), self._places(rows, own))

    def output(self, number: int, read: Read, time: float) -> Array:
        """See Block."""
        found = [block.output(number, _among(read, own), time) for block, own in self._parts]
        values = np.empty((self._count, found[0].shape[1]))
        for value, (_, own) in zip(found, self._parts, strict=True):
            values[own] = value
        return values

    def advance(self, read: Read, time: float, active: Rows) -> None:
        """See Block."""
        for block, own in self._parts:
            block.advance(_among(read, own), time, self._places(active, own))

    def commit(self) -> None:
        """See Block."""
        for block, _ in self._parts:
            block.commit()

    def _places(self, rows: Rows, own: Rows) -> Rows:
        """The places of some environments among those of a part."""
        wanted = np.zeros(self._count, bool)
        wanted[rows] = True
        return np.flatnonzero(wanted[own])


def _among(read: Read, own: Rows) -> Read:
    """The inputs of some environments."""

    def some(number: int) -> Any:
        value = read(number)
        return value if value is None or len(value) == 1 else value[own]

    return some


class Tasks:
    """A TaskMachine for each environment, each with the phases of its own station."""

    def __init__(self, blocks: Sequence[TaskMachine], observes: bool):
        """`observes`: the task commands the gripper, and its inputs are connected."""
        self.period, self._blocks, self._observes = blocks[0].period, blocks, observes
        self._progress = [Progress()] * len(blocks)
        self._put_out = [block.first_outputs for block in blocks]
        self._next = list(zip(self._progress, self._put_out, strict=True))

    @property
    def phases(self) -> list[int]:
        """The number of the phase of each environment."""
        return [progress.phase for progress in self._progress]

    @property
    def over(self) -> NDArray[np.bool_]:
        """The environments whose task is over, (E,)."""
        ends = zip(self._progress, self._blocks, strict=True)
        return np.array([progress.phase == len(block.phases) for progress, block in ends])

    def clear(self, rows: Rows) -> None:
        """It begins with the first phase."""
        for i in rows:
            self._next[i] = Progress(), self._blocks[i].first_outputs
        self.commit()

    def begin(self, read: Read, rows: Rows) -> None:
        """It begins with the first phase."""

    def output(self, number: int, read: Read, time: float) -> Array:
        """See Block."""
        return np.array([outputs[number] for outputs in self._put_out])

    def advance(self, read: Read, time: float, active: Rows) -> None:
        """See Block."""
        seen = [read(i)[:, 0] if self._observes else np.full(len(self._blocks), np.nan) for i in range(2)]
        for i in active:
            observed = GripObservation(time, float(seen[0][i]), float(seen[1][i]))
            progress = self._blocks[i].rules.step(self._progress[i], observed)
            self._next[i] = progress, self._blocks[i].outputs(progress, time, self._put_out[i])

    def commit(self) -> None:
        """See Block."""
        self._progress, self._put_out = ([*each] for each in zip(*self._next, strict=True))


class Streams(Stateless):
    """Draws of random sources, known before the run.

    Sources draw before other blocks take their samples, as in Drake.
    """

    def __init__(self, drawn: Array):
        """`drawn` at every sample, (T, E, size)."""
        self._drawn, self._number = drawn, np.zeros(drawn.shape[1], int)

    def give(self, drawn: Array, rows: Rows) -> None:
        """Lets some environments begin anew, with other draws, (T, rows, size)."""
        self._drawn[:, rows], self._number[rows] = drawn, 0

    def draw(self) -> None:
        """Draws for the next sample."""
        self._number = np.minimum(self._number + 1, len(self._drawn) - 1)

    def output(self, number: int, read: Read, time: float) -> Array:
        """See Block."""
        found: Array = self._drawn[self._number, np.arange(len(self._number))]
        return found


class Leaking(Stateless):
    """A Leak."""

    def __init__(self, block: Leak):
        self._block = block

    def output(self, number: int, read: Read, time: float) -> Array:
        """See Block."""
        return self._block.left(read(0), time)


class InTurn(Stateless):
    """Any other leaf system without a state: one context, in which environments take turns."""

    def __init__(self, block: LeafSystem):
        self._context, self._outputs = block.CreateDefaultContext(), block.get_output_port
        self._ports = [block.get_input_port(i) for i in range(block.num_input_ports())]

    def output(self, number: int, read: Read, time: float) -> Array:
        """See Block."""
        port, context = self._outputs(number), self._context
        context.SetTime(time)
        given = [read(i) for i in range(len(self._ports))]
        found = []
        for environment in range(max(map(len, given), default=1)):
            for each, values in zip(self._ports, given, strict=True):
                each.FixValue(context, values[min(environment, len(values) - 1)])
            found.append(self._evaluated(port))
        return np.array(found)

    def _evaluated(self, port: OutputPort) -> Array:
        """The value of an output; unknown if it cannot be found since an environment has diverged."""
        try:
            found: Array = port.Eval(self._context)
        except (RuntimeError, SystemExit):  # the latter comes from failed conditions of Drake
            if all(np.isfinite(each.Eval(self._context)).all() for each in self._ports):
                raise
            found = np.full(port.size(), np.nan)
        return found


class Contexts:
    """Any other leaf system with a state: a context for each of E environments, or one that they share (E = 1)."""

    def __init__(self, block: LeafSystem, count: int):
        self._block, self._inputs = block, range(block.num_input_ports())
        self._runs = [Simulator(block) for _ in range(count)]
        self.period = _period(block)
        self._updates = [_UNBEGUN] * count  # made so far

    def clear(self, rows: Rows) -> None:
        """See Block."""
        for i in rows if len(self._runs) > 1 else ():
            self._runs[i], self._updates[i] = Simulator(self._block), _UNBEGUN

    def _give(self, read: Read) -> None:
        for number in self._inputs:
            port = self._block.get_input_port(number)
            given = np.broadcast_to(read(number), (len(self._runs), port.size()))
            for run, value in zip(self._runs, given, strict=True):
                port.FixValue(run.get_mutable_context(), value)

    def begin(self, read: Read, rows: Rows) -> None:
        """See Block."""
        self._give(read)

    def output(self, number: int, read: Read, time: float) -> Array:
        """See Block."""
        self._give(read)
        port = self._block.get_output_port(number)
        return np.array([port.Eval(run.get_context()) for run in self._runs])

    def advance(self, read: Read, time: float, active: Rows) -> None:
        """See Block."""
        self._give(read)

    def commit(self) -> None:
        """See Block; inputs are still those of the update."""
        for i, run in enumerate(self._runs):
            self._updates[i] += 1
            if not self._updates[i]:
                run.Initialize()
            elif self.period:
                run.AdvanceTo(self._updates[i] * self.period)  # a sum of periods would drift off the updates


_UNBEGUN = -1


def _period(block: LeafSystem) -> float:
    timing = block.GetUniquePeriodicDiscreteUpdateAttribute()
    return float(timing.period_sec()) if timing is not None else 0.0


def _limits(block: Saturation) -> Callable[[Array], Array]:
    """A Saturation as a function; its limits are what it makes of the largest numbers."""
    size, context = block.get_input_port().size(), block.CreateDefaultContext()

    def of(value: float) -> Array:
        block.get_input_port().FixValue(context, np.full(size, value))
        return np.array(block.get_output_port().Eval(context))

    huge = np.finfo(float).max
    least, most = of(-huge), of(huge)
    return lambda u: np.minimum(np.maximum(u, least), most)


def _constant(block: ConstantVectorSource) -> Callable[[], Array]:
    value = np.array(block.get_output_port().Eval(block.CreateDefaultContext()))[None]
    return lambda: value


def _gain(block: MatrixGain) -> Callable[[Array], Array]:
    gain = np.array(block.D()).T
    return lambda u: np.asarray(u @ gain)


def gains(parts: Mapping[MatrixGain, Rows]) -> Callable[[Array], Array]:
    """Gains of environments that differ, of which each has those given."""
    first, count = next(iter(parts)), sum(map(len, parts.values()))
    if all(np.array_equal(first.D(), each.D()) for each in parts):
        return _gain(first)
    of_each = np.empty((count, *np.shape(first.D())[::-1]))
    for each, own in parts.items():
        of_each[own] = np.transpose(each.D())
    return lambda u: np.asarray((u[:, None] @ of_each)[:, 0])


def together(*values: Array) -> Array:
    """Values side by side, (E, size), of which some may be the same in all environments, (1, size)."""
    count = max(map(len, values))
    return np.concatenate([np.broadcast_to(value, (count, value.shape[1])) for value in values], axis=1)


def _added(*values: Array) -> Array:
    total = values[0]
    for value in values[1:]:
        total = total + value
    return total


def _mean_bound(*given: Array) -> Array:
    """Intervals and contacts take turns."""
    bounds = [
        np.where(touch != 0, interval[:, -1:], 0.0) for interval, touch in zip(given[::2], given[1::2], strict=True)
    ]
    return _added(*bounds) / len(bounds)


Functional = Mapping[type[LeafSystem], Callable[[Any], Callable[..., Array]]]
FUNCTIONS: Functional = {
    Adder: lambda block: _added,
    ConstantVectorSource: _constant,
    GripForceBound: lambda block: _mean_bound,
    MatrixGain: _gain,
    Multiplexer: lambda block: together,
    PassThrough: lambda block: lambda value: value,
    Saturation: _limits,
}
