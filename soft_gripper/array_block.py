"""ArrayBlock: a block made of functions over arrays whose leading axes are free.

Its ports call the functions for one sample, and a recording calls them once for all samples. Where nobody reads a
diagram, several blocks are composed into one, for equal fingers at once (`diagrams.wiring.composed`): all call the same
functions.
"""

from collections.abc import Callable, Iterable, Mapping, Sequence
from functools import cached_property, partial
from inspect import signature
from typing import Any

import numpy as np
from pydrake.common import RandomDistribution
from pydrake.common.value import AbstractValue
from pydrake.systems.framework import BasicVector, Context, DiscreteValues, InputPort, LeafSystem

from soft_gripper.arrays import Array
from soft_gripper.cached import Cached, weakly
from soft_gripper.errors import InputError, suggestion
from soft_gripper.signals import describe
from soft_gripper.steps import TIME, Memory, Output, Step, Steps, constant, same, sampled

_MAX_INPUT_SIZE = 1e150  # the square of a larger number is infinite


def check_finite(block: LeafSystem, inputs: Mapping[str, Any]) -> None:
    """Raises an InputError that names a block and the first of its inputs in which a number is not finite.

    A number whose square overflows counts as not finite; inputs that are no arrays are left out.
    """
    for name, values in inputs.items():
        numbers = np.asarray(values).ravel()
        bad = numbers[~(np.abs(numbers) < _MAX_INPUT_SIZE)] if numbers.dtype.kind == "f" else numbers[:0]
        if len(bad):
            raise InputError(block.GetSystemPathname(), name, float(bad[0]), "must be finite, and no larger than 1e150")


class ArrayBlock(LeafSystem):
    """A block with outputs that follow from its inputs by functions, given in its constructor step by step.

    A step has a name and follows from those before it. Functions take the steps that they name, of shape
    (..., size) if they are inputs, and return an array, or anything else that keeps the leading axes. Caches and
    prerequisites are as narrow as the steps say.

    Which sample is the first of a run is known from the state, not from the clock: a run may begin at any time, and one
    that goes on with the context of another, at a later time, goes on with its samples and memories.

    Where a function fails on an input that is not finite, as linear algebra does, an InputError names block and input.
    Nothing of the sample is remembered then: the block goes on when its inputs are finite again.
    """

    takes_axes = True  # functions for one sample take leading axes too, as those for a recording do

    def __init_subclass__(cls) -> None:
        init = signature(cls.__init__)  # that of `__new__` says nothing
        cls.__signature__ = init.replace(parameters=[*init.parameters.values()][1:])

    def __init__(self, period: float | None = None):
        """`period` of its samples, s; None if it neither samples nor remembers anything."""
        super().__init__()
        self.steps, self.period = Steps(), period
        # What reads each step, and its tickets.
        self._read: dict[str, Callable[[Context], Any]] = {TIME: lambda context: np.array([context.get_time()])}
        self._tickets: dict[str, set[Any]] = {TIME: {self.time_ticket()}}
        self._calcs: dict[str, Callable[[Context], Any]] = {}  # of the steps that are shown
        self._kept: dict[frozenset[int], Cached] = {}  # values of steps by name, by their tickets
        self._groups: dict[str, int] = {}  # of the discrete state, by the steps that remember
        self.logs: list[tuple[Cached, Callable[[Context], Any]]] = []  # lists of values, and what computes the next one
        if period is not None:
            self._last = int(self.DeclareDiscreteState([np.inf]))  # time of the last sample, s; infinite before any
            self.DeclareInitializationDiscreteUpdateEvent(weakly(self._begin))
            self.DeclarePeriodicDiscreteUpdateEvent(period, 0.0, weakly(self._advance))

    @property
    def outputs(self) -> dict[str, Output]:
        """Functions of the vector outputs and the steps that these take, by name."""
        return self.steps.outputs

    def take(
        self, name: str, size: int, random: RandomDistribution | None = None, *, optional: bool = False
    ) -> InputPort:
        """Declares a vector input, which may be random, and the step of its name; None if it is `optional` and open."""
        port = self.DeclareVectorInputPort(name, size, random)

        def read(context: Context) -> Array | None:
            return port.Eval(context) if port.HasValue(context) else None

        self._add_leaf(name, Step(), read if optional else port.Eval, {port.ticket()})
        return port

    def take_value(self, name: str, model: AbstractValue) -> InputPort:
        """Declares an abstract input, known only during a run, and the step of its name; `model` is of its type."""
        port = self.DeclareAbstractInputPort(name, model)
        self._add_leaf(name, Step(over_time=None), port.Eval, {port.ticket()})
        return port

    def constant(self, name: str, value: Array) -> None:
        """Declares a step that never changes."""
        self.add(name, constant(value), kept=False)

    def derive(
        self, name: str, function: Callable[..., Any], *sources: str, over_time: Callable[..., Any] | None = None
    ) -> None:
        """Declares a step that several others use, computed once per sample.

        `over_time` replaces the function for a whole recording, if the function handles a single sample only.
        """
        self.add(name, Step(function, sources, None, over_time or function, sources))

    def show(self, name: str, function: Callable[[Context], Any], tickets: set[Any]) -> None:
        """Declares a step that is not an array, and an output that holds it; over all samples it is a list."""
        self._calcs[name] = function
        calc = partial(weakly(self._calc_step), name)
        port = self.DeclareAbstractOutputPort(name, lambda: AbstractValue.Make(object()), calc, tickets)
        self._add_leaf(name, Step(), port.Eval, tickets)

    def log(self, name: str, period: float) -> Cached:
        """Logs a step of `show` every `period` s from the beginning of a run; returns the list of its values.

        It is computed for the log alone: in most runs nothing else reads it.
        """
        values = Cached(self, "log", lambda _, value: value.set_value([]), {self.nothing_ticket()})
        self.logs.append((values, self._calcs[name]))
        keep = partial(weakly(self._log_value), len(self.logs) - 1)
        self.DeclarePeriodicPublishEvent(period, 0.0, keep)
        self.DeclareForcedPublishEvent(keep)
        return values

    def sample(
        self,
        name: str,
        source: str,
        begin: Array | float = 0.0,
        *,
        at_initialization: bool = True,
        at_first: bool = True,
    ) -> None:
        """Declares a step that is an earlier step, or the time, at the last sample; see `steps.sampled`.

        `begin` has the size of the step, unless that is a vector input.
        """
        shape = (self.GetInputPort(source).size(),) if self.HasInputPort(source) else np.atleast_1d(begin).shape
        self.add(name, sampled(source, np.broadcast_to(begin, shape).astype(float), at_initialization, at_first))

    def remember(
        self,
        name: str,
        function: Callable[..., Any],
        *sources: str,
        begin: Array,
        keep: Callable[..., Array],
        kept: Sequence[str] = (),
        at_first: bool = False,
        begin_of: tuple[Callable[[Array], Array], str] | None = None,
        over_time: Callable[..., Any] | None = None,
        loops: bool = False,
    ) -> None:
        """Declares a step that also depends on values remembered from the sample before.

        Args:
            name: of the step.
            function: of what is remembered and the sources.
            sources: steps.
            begin: remembered before the first sample.
            keep: what is remembered at the next sample, from this step and those named in `kept`.
            kept: further steps, which may be declared later.
            at_first: it is also kept at the first sample, of the inputs before, as where a run begins.
            begin_of: a function and the input from which it finds `begin` when a run is initialized.
            over_time: computes the step at all samples of a recording from the sources, at whose first sample nothing
                is remembered; None: the memory is known only during a run.
            loops: this function is a loop over the samples, (T, ..., size), which several fingers may share.
        """
        memory = Memory(np.asarray(begin, dtype=float), keep, (name, *kept), at_first, begin_of)
        self.add(name, Step(function, sources, memory, over_time, sources, loops))

    def add(self, name: str, step: Step, kept: bool = True) -> None:
        """Adds any step but an input; where it has one reader, it need not be `kept` for others."""
        self.steps[name] = step
        reads = self._reads_of(step.sources)
        tickets = self._tickets_of(step.sources)
        if step.memory is not None:
            reads = [self._declare_state(name, step.memory.begin), *reads]
            tickets = tickets | {self.xd_ticket()}
        assert step.function is not None
        if step.function is same:
            (self._read[name],), self._tickets[name] = reads, tickets
        elif kept:
            self._keep(name, _apply_to_context(step.function, reads), tickets)
        else:
            self._read[name] = _apply_to_context(step.function, reads)
            self._tickets[name] = tickets or {self.nothing_ticket()}

    def put_out(
        self,
        name: str,
        function: Callable[..., Any],
        *sources: str,
        unit: str | Sequence[str] = "1",
        meanings: Sequence[str] = (),
        **axes: Sequence[Any],
    ) -> None:
        """Declares a vector output, ``function(*sources)``, folded into axes; see `describe`."""
        size = int(np.prod([len(labels) for labels in axes.values()]))
        value = _apply_to_context(function, self._reads_of(sources))
        check_inputs = weakly(self._check_inputs)

        def calc(context: Context, output: BasicVector) -> None:
            try:
                output.SetFromVector(np.asarray(value(context)).reshape(-1))
            except ValueError:
                check_inputs(context)
                raise

        port = self.DeclareVectorOutputPort(name, size, calc, self._tickets_of(sources))
        describe(port, unit, meanings, **axes)
        self.steps.outputs[name] = function, sources

    def follows(self, output: str, period: float) -> bool:
        """Whether `leaves` determine an output at all samples of a recording with a period, s."""
        return self.steps.follows(output, remembers=self.period == period)

    def leaves(self, output: str) -> list[str]:
        """Names of the inputs, and of the outputs declared by `show`, that determine an output."""
        return self.steps.leaves(output)

    def over_time(self, time: Array, leaves: Mapping[str, Any], outputs: Iterable[str]) -> dict[str, Array]:
        """Outputs at all T samples, (T, size) each.

        Args:
            time: of the samples, s, (T,).
            leaves: values at these times, (T, size) each, or a list of T, by port name.
            outputs: names of ports.
        """
        values: dict[str, Any] = {TIME: np.reshape(time, (-1, 1)), **leaves}
        return {name: self.output_over_time(name, values) for name in outputs}

    def output_over_time(self, output: str, step_values: dict[str, Any]) -> Array:
        """An output at all T samples, (T, size).

        Args:
            output: name of the port.
            step_values: time, (T, 1) s, and leaves as of `over_time`; computed steps with several readers are
                added.
        """
        try:
            values = self.steps.recorded.output(output, step_values)
        except ValueError:
            check_finite(self, {name: step_values[name] for name in self.leaves(output)})
            raise
        return np.reshape(values, (len(step_values[TIME]), -1))

    def _add_leaf(self, name: str, step: Step, read: Callable[[Context], Any], tickets: set[Any]) -> None:
        self.steps[name], self._read[name], self._tickets[name] = step, read, tickets

    def _declare_state(self, name: str, begin: Array) -> Callable[[Context], Array]:
        """Declares the state of a step; returns a function that reads it."""
        if self.period is None:
            raise ValueError(f"step '{name}' samples or remembers: give the block a period")
        group = self._groups[name] = int(self.DeclareDiscreteState(begin.ravel()))

        def flat(context: Context) -> Array:
            return context.get_discrete_state(group).value()

        return flat if begin.ndim == 1 else lambda context: flat(context).reshape(begin.shape)

    @cached_property
    def _memories(self) -> list[tuple[int, Memory, list[Callable[[Context], Any]]]]:
        """Groups of the discrete state, their memories, and functions that read the sources of these."""
        memories = ((group, self.steps[name].memory) for name, group in self._groups.items())
        return [(g, memory, [self._read[name] for name in memory.sources]) for g, memory in memories if memory]

    def _begin(self, context: Context, values: DiscreteValues) -> None:
        """Prepares the memories at the initialization of a run, unless it goes on with the context of another."""
        if self._last_sample(context) <= context.get_time():
            return
        values.set_value(self._last, [np.inf])
        for group, memory, _ in self._memories:
            begin = memory.begin
            if memory.begin_of is not None:
                function, source = memory.begin_of
                begin = function(self._read[source](context))
            values.set_value(group, begin.ravel())

    def _advance(self, context: Context, values: DiscreteValues) -> None:
        """Takes samples, and remembers values of the sample before; at the first there is none.

        An event that began at `period` instead would drift off those at multiples of it by rounding.
        """
        is_later = self._last_sample(context) < context.get_time()
        values.set_value(self._last, [context.get_time()])
        for group, memory, reads in self._memories:
            if is_later or memory.at_first:
                values.set_value(group, memory.keep(*[read(context) for read in reads]).ravel())

    def _last_sample(self, context: Context) -> float:
        return float(context.get_discrete_state(self._last).value()[0])

    def _keep(self, name: str, read: Callable[[Context], Any], tickets: set[Any]) -> None:
        """Keeps the values of a step in a cache entry, which steps of equal tickets share: each entry costs time."""
        tickets = tickets or {self.nothing_ticket()}
        key = frozenset(map(int, tickets))
        if key not in self._kept:
            self._kept[key] = Cached(self, name, _set_empty, tickets)
        kept = self._kept[key]
        check_inputs = weakly(self._check_inputs)

        def read_kept(context: Context) -> Any:
            values = kept.Eval(context)
            if name not in values:
                try:
                    values[name] = read(context)
                except ValueError:
                    check_inputs(context)
                    raise
            return values[name]

        self._read[name], self._tickets[name] = read_kept, tickets

    def _log_value(self, i: int, context: Context) -> None:
        values, calc = self.logs[i]
        values.Eval(context).append(calc(context))

    def _calc_step(self, name: str, context: Context, value: AbstractValue) -> None:
        value.set_value(self._calcs[name](context))

    def _check_inputs(self, context: Context) -> None:
        ports = [self.get_input_port(i) for i in range(self.num_input_ports())]
        check_finite(self, {port.get_name(): port.Eval(context) for port in ports if port.HasValue(context)})

    def _reads_of(self, sources: Sequence[str]) -> list[Callable[[Context], Any]]:
        """Functions that read steps in a context; an InputError if there is no such step yet."""
        for source in sources:
            if source not in self._read:
                raise InputError(type(self).__name__, "step", source, suggestion(source, self._read))
        return [self._read[source] for source in sources]

    def _tickets_of(self, sources: Sequence[str]) -> set[Any]:
        return {ticket for source in sources for ticket in self._tickets[source]}


def _set_empty(_: Context, value: AbstractValue) -> None:
    value.set_value({})


def _apply_to_context(
    function: Callable[..., Any], reads: Sequence[Callable[[Context], Any]]
) -> Callable[[Context], Any]:
    return lambda context: function(*[read(context) for read in reads])
