"""ArrayBlock: a block made of functions over arrays whose leading axes are free.

Its ports call the functions for one sample, and a recording calls them once for all samples. Where nobody reads a
diagram, several blocks are composed into one, for equal fingers at once (`diagrams.wiring.composed`): all call the same
functions.
"""

from collections import Counter
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property, partial
from inspect import signature
from typing import Any

import numpy as np
from pydrake.common import RandomDistribution
from pydrake.common.value import AbstractValue
from pydrake.systems.framework import BasicVector, Context, DiscreteValues, InputPort, LeafSystem

from soft_gripper.arrays import Array
from soft_gripper.cached import Cached, weakly
from soft_gripper.errors import InputError
from soft_gripper.signals import describe

TIME = "time"  # source of a `sample` that takes the time, s
_OVERFLOWS = 1e150  # the square of a larger number is infinite


@dataclass(frozen=True, eq=False)
class Step:
    """A quantity that is known at every sample; a plain one is an input, or passed to a log of its own by `show`."""


@dataclass(frozen=True, eq=False)
class Value(Step):
    """An abstract input, known only during a run."""

    model: AbstractValue


@dataclass(frozen=True, eq=False)
class Constant(Step):
    """Never changes."""

    value: Array


@dataclass(frozen=True, eq=False)
class Function(Step):
    """Follows from other steps of the same sample."""

    of: Callable[..., Any]
    sources: tuple[str, ...]
    over_time: Callable[..., Any]  # the same, from the sources at all samples of a recording


@dataclass(frozen=True, eq=False)
class Sample(Step):
    """An earlier step, or the time, at the last sample; all samples are taken together, before any update.

    A random source draws once when a run is initialized and again at the first sample, where the other inputs are
    unchanged.
    """

    source: str
    begin: Array  # before the first sample
    at_initialization: bool = True
    at_first: bool = True  # again at the first sample, which is at the same time if a run begins at a sample

    def over_time(self, values: Array) -> Array:
        """Values of a port at all samples of a recording, from the source at these times: that of the sample before.

        Raises:
            ValueError: if nothing is taken at the first sample: what is taken before is not in the recording.
        """
        if not self.at_first:
            raise ValueError("known only during a run")
        first = values[:1] if self.at_initialization else np.broadcast_to(self.begin, (1, *np.shape(values)[1:]))
        return np.concatenate([first, values[:-1]])


@dataclass(frozen=True, eq=False)
class Memory(Step):
    """Follows from other steps, and from what is remembered of the sample before."""

    of: Callable[..., Any]  # of what is remembered and the sources
    sources: tuple[str, ...]
    begin: Array  # what is remembered before the first sample
    keep: Callable[..., Array]  # from this step and others to what is remembered at the next sample
    kept: tuple[str, ...]  # the other steps
    begin_of: tuple[Callable[[Array], Array], str] | None = None  # instead of `begin`, from an input at initialization
    over_time: Callable[..., Any] | None = None  # from the sources at all samples; None: known only during a run


def check_finite(block: LeafSystem, inputs: Mapping[str, Any]) -> None:
    """Raises an InputError that names a block and the first of its inputs in which a number is not finite.

    A number whose square overflows counts as not finite; inputs that are no arrays are left out.
    """
    for name, values in inputs.items():
        numbers = np.asarray(values).ravel()
        bad = numbers[~(np.abs(numbers) < _OVERFLOWS)] if numbers.dtype.kind == "f" else numbers[:0]
        if len(bad):
            raise InputError(block.GetSystemPathname(), name, float(bad[0]), "must be finite, and no larger than 1e150")


class ArrayBlock(LeafSystem):
    """A block whose outputs follow from its inputs by functions, given in its constructor step by step.

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
        self.steps: dict[str, Step] = {}
        self.outputs: dict[str, tuple[Callable[..., Any], tuple[str, ...]]] = {}  # functions and their steps
        self.period = period
        self._read: dict[str, Callable[[Context], Any]] = {}  # the steps
        self._tickets: dict[str, set[Any]] = {}  # of each step
        self._calcs: dict[str, Callable[[Context], Any]] = {}  # of the steps that are cached
        # Samples and memories, by name, with their discrete state.
        self._samples: dict[str, tuple[Sample, int]] = {}
        self._memories: dict[str, tuple[Memory, int]] = {}
        if period is not None:
            self._last = int(self.DeclareDiscreteState([np.inf]))  # time of the last sample, s; infinite before any
            self.DeclareInitializationDiscreteUpdateEvent(weakly(self._begin))
            self.DeclarePeriodicDiscreteUpdateEvent(period, 0.0, weakly(self._advance))

    def take(self, name: str, size: int, random: RandomDistribution | None = None) -> InputPort:
        """Declares a vector input, which may be random, and the step of its name."""
        port = self.DeclareVectorInputPort(name, size, random)
        self.steps[name], self._read[name], self._tickets[name] = Step(), port.Eval, {port.ticket()}
        return port

    def take_value(self, name: str, model: AbstractValue) -> InputPort:
        """Declares an abstract input, known only during a run, and the step of its name; `model` is of its type."""
        port = self.DeclareAbstractInputPort(name, model)
        self.steps[name], self._read[name], self._tickets[name] = Value(model), port.Eval, {port.ticket()}
        return port

    def constant(self, name: str, value: Array) -> None:
        """Declares a step that never changes."""
        self.steps[name], self._read[name] = Constant(value), lambda _: value
        self._tickets[name] = {self.nothing_ticket()}

    def derive(
        self,
        name: str,
        function: Callable[..., Any],
        *sources: str,
        over_time: Callable[..., Any] | None = None,
        kept: bool = True,
    ) -> None:
        """Declares a step that several others use, computed once per sample; or by the only one, if it is not `kept`.

        `over_time` replaces the function for a whole recording, if the function handles a single sample only.
        """
        self.steps[name] = Function(function, sources, over_time or function)
        read, tickets = _of_all(function, [self._read[source] for source in sources]), self._tickets_of(sources)
        if kept:
            self._keep(name, read, tickets)
        else:
            self._read[name], self._tickets[name] = read, tickets

    def show(self, name: str, function: Callable[[Context], Any], tickets: set[Any]) -> None:
        """Declares a step that is not an array, and an output that holds it; over all samples it is a list."""
        self._calcs[name] = function
        calc = partial(weakly(self._calc_step), name)
        port = self.DeclareAbstractOutputPort(name, lambda: AbstractValue.Make(object()), calc, tickets)
        self.steps[name], self._read[name], self._tickets[name] = Step(), port.Eval, tickets

    def sample(
        self,
        name: str,
        source: str,
        begin: Array | float = 0.0,
        *,
        at_initialization: bool = True,
        at_first: bool = True,
    ) -> None:
        """Declares a step that is an earlier step, or the time, at the last sample; see `Sample`.

        `begin` has the size of the step, unless that is a vector input.
        """
        shape = (self.GetInputPort(source).size(),) if self.HasInputPort(source) else np.atleast_1d(begin).shape
        step = Sample(source, np.broadcast_to(begin, shape).astype(float), at_initialization, at_first)
        self.steps[name], self._tickets[name] = step, {self.xd_ticket()}
        group, self._read[name] = self._declare_state(name, step.begin)
        self._samples[name] = step, group

    def remember(
        self,
        name: str,
        function: Callable[..., Any],
        *sources: str,
        begin: Array,
        keep: Callable[..., Array],
        kept: Sequence[str] = (),
        begin_of: tuple[Callable[[Array], Array], str] | None = None,
        over_time: Callable[..., Any] | None = None,
    ) -> None:
        """Declares a step that also depends on what is remembered of the sample before.

        Args:
            name: of the step.
            function: of what is remembered and the sources.
            sources: steps.
            begin: remembered before the first sample.
            keep: what is remembered at the next sample, from this step and those named in `kept`; at the first sample
                nothing is.
            kept: further steps, which may be declared later.
            begin_of: a function and the input from which it finds `begin` when a run is initialized.
            over_time: computes the step at all samples of a recording from the sources, at whose first sample nothing
                is remembered; None: the memory is known only during a run.
        """
        begin = np.asarray(begin, dtype=float)
        self.steps[name] = step = Memory(function, sources, begin, keep, tuple(kept), begin_of, over_time)
        group, held = self._declare_state(name, begin)
        self._memories[name] = step, group
        reads = [held, *(self._read[source] for source in sources)]
        self._keep(name, _of_all(function, reads), self._tickets_of(sources) | {self.xd_ticket()})

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
        value = _of_all(function, [self._read[source] for source in sources])
        check_inputs = weakly(self._check_inputs)

        def calc(context: Context, output: BasicVector) -> None:
            try:
                output.SetFromVector(np.asarray(value(context)).reshape(-1))
            except ValueError:
                check_inputs(context)
                raise

        port = self.DeclareVectorOutputPort(name, size, calc, self._tickets_of(sources))
        describe(port, unit, meanings, **axes)
        self.outputs[name] = function, sources

    def follows(self, output: str, period: float) -> bool:
        """Whether `leaves` determine an output at all samples of a recording, `period` s apart."""
        return output in self.outputs and all(self._follows(step, period) for step in self.outputs[output][1])

    def leaves(self, output: str) -> list[str]:
        """Names of the inputs, and of the outputs declared by `show`, that determine an output."""
        return list(dict.fromkeys(leaf for step in self.outputs[output][1] for leaf in self._leaves(step)))

    def over_time(self, time: Array, leaves: Mapping[str, Any], outputs: Iterable[str]) -> dict[str, Array]:
        """Outputs at all T samples, (T, size) each.

        Args:
            time: of the samples, s, (T,).
            leaves: values at these times, (T, size) each, or a list of T, by port name.
            outputs: names of ports.
        """
        known: dict[str, Any] = {TIME: time, **leaves}
        return {name: self.output_over_time(name, known) for name in outputs}

    def output_over_time(self, output: str, known: dict[str, Any]) -> Array:
        """An output at all T samples, (T, size).

        Args:
            output: name of the port.
            known: time and leaves as of `over_time`; steps that are computed and have several readers are added.
        """
        function, sources = self.outputs[output]
        try:
            values = function(*[self._at_all(source, known) for source in sources])
        except ValueError:
            check_finite(self, {name: known[name] for name in self.leaves(output)})
            raise
        return np.reshape(values, (len(known[TIME]), -1))

    def _at_all(self, name: str, known: dict[str, Any]) -> Any:
        step = self.steps.get(name)
        if name in known or step is None or is_leaf(step):
            return known[name]
        values = self._step_over_time(step, known)
        if self._readers[name] > 1:
            known[name] = values
        return values

    def _step_over_time(self, step: Step, known: dict[str, Any]) -> Any:
        if isinstance(step, Constant):
            return np.broadcast_to(step.value, (*known[TIME].shape, *step.value.shape))
        if isinstance(step, Sample):
            values = self._at_all(step.source, known)
            return step.over_time(values[:, None] if step.source == TIME else values)
        assert isinstance(step, Function | Memory)
        assert step.over_time is not None
        return step.over_time(*[self._at_all(source, known) for source in step.sources])

    @cached_property
    def _readers(self) -> Counter[str]:
        """How many steps and outputs of the same sample take each step."""
        sources = (*map(sources_of, self.steps.values()), *(names for _, names in self.outputs.values()))
        return Counter(name for names in sources for name in names)

    def _follows(self, name: str, period: float) -> bool:
        step = self.steps[name]
        if isinstance(step, Value) or (isinstance(step, Sample) and not (step.at_first and self.period == period)):
            return False
        if isinstance(step, Memory) and (step.over_time is None or self.period != period):
            return False
        return all(self._follows(source, period) for source in sources_of(step))

    def _leaves(self, name: str) -> list[str]:
        step = self.steps[name]
        if not is_leaf(step):
            return [leaf for source in sources_of(step) for leaf in self._leaves(source)]
        return [name]

    def _declare_state(self, name: str, begin: Array) -> tuple[int, Callable[[Context], Array]]:
        """Declares the state of a step; returns its number, and what reads it."""
        if self.period is None:
            raise ValueError(f"step '{name}' samples or remembers: give the block a period")
        group = int(self.DeclareDiscreteState(begin.ravel()))

        def flat(context: Context) -> Array:
            state: Array = context.get_discrete_state(group).value()
            return state

        return group, flat if begin.ndim == 1 else lambda context: flat(context).reshape(begin.shape)

    def _begin(self, context: Context, values: DiscreteValues) -> None:
        """Takes the samples at the initialization of a run, unless it goes on with the context of another."""
        if self._last_sample(context) <= context.get_time():
            return
        values.set_value(self._last, [np.inf])
        for sample, group in self._samples.values():
            first = self._source(sample, context) if sample.at_initialization else sample.begin
            values.set_value(group, first.ravel())
        for memory, group in self._memories.values():
            values.set_value(group, self._remembered_first(memory, context).ravel())

    def _remembered_first(self, step: Memory, context: Context) -> Array:
        if step.begin_of is None:
            return step.begin
        function, source = step.begin_of
        return function(self._read[source](context))

    def _advance(self, context: Context, values: DiscreteValues) -> None:
        """Takes samples, and remembers what belongs to the sample before; at the first there is none.

        An event that began at `period` instead would drift off those at multiples of it by rounding.
        """
        is_later = self._last_sample(context) < context.get_time()
        values.set_value(self._last, [context.get_time()])
        for sample, group in self._samples.values():
            if is_later or sample.at_first:
                values.set_value(group, self._source(sample, context).ravel())
        for name, (memory, group) in self._memories.items() if is_later else ():
            known = [self._read[source](context) for source in (name, *memory.kept)]
            values.set_value(group, memory.keep(*known).ravel())

    def _last_sample(self, context: Context) -> float:
        return float(context.get_discrete_state(self._last).value()[0])

    def _source(self, step: Sample, context: Context) -> Any:
        return np.array([context.get_time()]) if step.source == TIME else self._read[step.source](context)

    def _keep(self, name: str, read: Callable[[Context], Any], tickets: set[Any]) -> None:
        """Adds the cache entry of a step."""
        self._calcs[name] = read
        cached = Cached(self, name, partial(weakly(self._calc_step), name), tickets)
        self._read[name], self._tickets[name] = cached.Eval, {cached.ticket}

    def _calc_step(self, name: str, context: Context, value: AbstractValue) -> None:
        try:
            value.set_value(self._calcs[name](context))
        except ValueError:
            self._check_inputs(context)
            raise

    def _check_inputs(self, context: Context) -> None:
        ports = [self.get_input_port(i) for i in range(self.num_input_ports())]
        check_finite(self, {port.get_name(): port.Eval(context) for port in ports if port.HasValue(context)})

    def _tickets_of(self, sources: Sequence[str]) -> set[Any]:
        return {ticket for source in sources for ticket in self._tickets[source]}


def _of_all(function: Callable[..., Any], reads: Sequence[Callable[[Context], Any]]) -> Callable[[Context], Any]:
    return lambda context: function(*[read(context) for read in reads])


def is_leaf(step: Step) -> bool:
    """Whether a step comes from a port."""
    return type(step) in (Step, Value)


def sources_of(step: Step) -> tuple[str, ...]:
    """The steps from which a step of the same sample follows."""
    if isinstance(step, Sample):
        return () if step.source == TIME else (step.source,)
    return step.sources if isinstance(step, Function | Memory) else ()
