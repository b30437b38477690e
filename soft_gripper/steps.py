"""Steps: the quantities of one sample, each a function of others and of what it remembers.

The functions take arrays whose leading axes are free. So one graph of steps is computed for one sample, for several
equal fingers or environments at once (`stacked`), and for all samples of a recording (`recorded`). Functions that take
one sample only are called `row_by_row`. This graph puts out the sum of all x so far:

    total = Step(np.add, ("x",), Memory(np.zeros(1), same, ("total",), at_first=True))
    steps = Steps({"x": Step(), "total": total}, {"sum": (same, ["total"])})
    steps.output("sum", {"x": np.array([2.0])}, {"total": np.array([1.0])})  # 3
"""

from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property, partial
from itertools import repeat
from types import MappingProxyType
from typing import Any

import numpy as np

from soft_gripper.arrays import Array

TIME = "time"  # a source of any step, (..., 1) s
Output = tuple[Callable[..., Any], Sequence[str]]  # a function, and the steps that it takes
Rename = Callable[[str], str]
_NO_VALUES: Mapping[str, Any] = MappingProxyType({})


def same(value: Any) -> Any:
    return value


@dataclass(frozen=True, eq=False)
class Memory:
    """Memory of a step from one sample to the next; all memories are taken together, before any update."""

    begin: Array  # before the first sample
    keep: Callable[..., Array]  # from the sources to what is remembered at the next sample
    sources: tuple[str, ...]
    at_first: bool  # is kept at the first sample too
    begin_of: tuple[Callable[[Any], Array], str] | None = None  # instead of `begin`, from a step at initialization


@dataclass(frozen=True, eq=False)
class Step:
    function: Callable[..., Any] | None = None  # of what is remembered, if anything is, and the sources; None: an input
    sources: tuple[str, ...] = ()
    memory: Memory | None = None
    over_time: Callable[..., Any] | None = same  # the function over a recording; None: known only during a run
    sources_over_time: tuple[str, ...] = ()
    loops: bool = False  # `over_time` loops over samples, (T, ..., size): several fingers share one loop

    def renamed(self, rename: Rename) -> "Step":
        memory = self.memory
        if memory is not None:
            begin_of = None if memory.begin_of is None else (memory.begin_of[0], rename(memory.begin_of[1]))
            memory = replace(memory, sources=tuple(map(rename, memory.sources)), begin_of=begin_of)
        sources, recorded = (tuple(map(rename, names)) for names in (self.sources, self.sources_over_time))
        return replace(self, sources=sources, memory=memory, sources_over_time=recorded)


def constant(value: Array) -> Step:
    return Step(lambda: value, (), None, lambda time: np.broadcast_to(value, (len(time), *np.shape(value))), (TIME,))


def sampled(source: str, begin: Array, at_initialization: bool = True, at_first: bool = True) -> Step:
    """An earlier step, or the time, at the last sample.

    Over a recording it is that of the sample before.

    Args:
        source: the step.
        begin: before the first sample.
        at_initialization: it is also taken when a run is initialized.
        at_first: it is taken again at the first sample, which is at the same time if a run begins at a sample. Else it
            is known only during a run: what is taken before the first sample is not in the recording.
    """

    def previous_samples(values: Array) -> Array:
        first = values[:1] if at_initialization else np.broadcast_to(begin, (1, *np.shape(values)[1:]))
        return np.concatenate([first, values[:-1]])

    memory = Memory(begin, same, (source,), at_first, (same, source) if at_initialization else None)
    return Step(same, (), memory, previous_samples if at_first else None, (source,))


class Steps(dict[str, Step]):
    """Steps by name, each after its sources, and functions of the outputs."""

    def __init__(self, steps: Mapping[str, Step] = _NO_VALUES, outputs: Mapping[str, Output] = _NO_VALUES):
        super().__init__(steps)
        self.outputs = dict(outputs)

    @cached_property
    def readers(self) -> Counter[str]:
        """Number of steps, memories and outputs that take each step."""
        memories = (step.memory.sources for step in self.values() if step.memory is not None)
        outputs = (sources for _, sources in self.outputs.values())
        steps = (step.sources for step in self.values())
        return Counter(name for names in (*steps, *memories, *outputs) for name in names)

    def value(self, name: str, step_values: dict[str, Any], remembered: Mapping[str, Array] = _NO_VALUES) -> Any:
        """Computes or looks up the value of a step; those with several readers are added to `step_values`."""
        step = self.get(name)
        if step is None or step.function is None or name in step_values:
            return step_values[name]
        memory = () if step.memory is None else (remembered[name],)
        value = step.function(*memory, *[self.value(source, step_values, remembered) for source in step.sources])
        if self.readers[name] > 1:
            step_values[name] = value
        return value

    def output(self, name: str, step_values: dict[str, Any], remembered: Mapping[str, Array] = _NO_VALUES) -> Any:
        """Computes an output, see `value`."""
        function, sources = self.outputs[name]
        return function(*[self.value(source, step_values, remembered) for source in sources])

    def stacked(self, count: int) -> "Steps":
        """A copy with a leading axis of `count`, for inputs and a time that have it."""

        def repeated(value: Array) -> Array:
            return np.broadcast_to(value, (count, *np.shape(value)))

        steps = dict(self)
        for name, step in self.items():
            if step.memory is not None:
                steps[name] = replace(step, memory=replace(step.memory, begin=repeated(step.memory.begin)))
            elif step.function is not None and not step.sources:
                steps[name] = replace(step, function=partial(same, repeated(step.function())))
        return Steps(steps, self.outputs)

    @cached_property
    def recorded(self) -> "Steps":
        """The steps at all samples of a recording, (T, ...), without memories."""
        computed_steps = ((name, step) for name, step in self.items() if step.function is not None and step.over_time)
        steps = {name: Step(step.over_time, step.sources_over_time, loops=step.loops) for name, step in computed_steps}
        return Steps(steps, self.outputs)

    def follows(self, output: str, remembers: bool) -> bool:
        """Whether the leaves of an output determine it at all samples of a recording.

        `remembers`: what is remembered changes with the samples of the recording.
        """
        if output not in self.outputs:
            return False
        steps = [self.get(name, Step()) for name in self._upstream(output, over_time=True)]
        return all(step.over_time is not None and (step.memory is None or remembers) for step in steps)

    def takes_time(self, output: str) -> bool:
        """Whether an output changes with the time between samples."""
        return TIME in self._upstream(output, over_time=False)

    def leaves(self, output: str) -> list[str]:
        """Names of the inputs that determine an output over a recording."""
        names = self._upstream(output, over_time=True)
        return [name for name in names if name in self and self[name].function is None]

    def _upstream(self, output: str, over_time: bool) -> list[str]:
        """Names of the steps that an output takes, directly or through others."""
        names: dict[str, None] = {}

        def add(sources: Sequence[str]) -> None:
            for name in [source for source in sources if source not in names]:
                names[name] = None
                step = self.get(name, Step())
                add(step.sources_over_time if over_time else step.sources)

        add(self.outputs[output][1])
        return list(names)


def row_by_row(graphs: Sequence[Steps]) -> Steps:
    """One graph of equal ones; each computes its row of a leading axis, as functions take one sample."""
    first = graphs[0]
    outputs: dict[str, Output] = {}
    for name, (_, sources) in first.outputs.items():
        outputs[name] = _call_rows([graph.outputs[name][0] for graph in graphs]), sources
    return Steps({name: _row_step([graph[name] for graph in graphs]) for name in first}, outputs)


def _row_step(rows: Sequence[Step]) -> Step:
    """A step with functions that are called for each row."""
    first = rows[0]
    if first.function is None:
        return first
    memories = [row.memory for row in rows if row.memory is not None]
    functions = [row.function for row in rows if row.function is not None]
    if not memories and not first.sources:
        return replace(first, function=partial(same, np.array([function() for function in functions])))
    function = same if first.function is same else _call_rows(functions)
    if not memories:
        return replace(first, function=function)
    begins = [memory.begin_of for memory in memories if memory.begin_of is not None]
    begin_of = (_call_rows([begin for begin, _ in begins], np.array), begins[0][1]) if begins else None
    begin, keep = np.array([memory.begin for memory in memories]), [memory.keep for memory in memories]
    memory = replace(memories[0], begin=begin, keep=_call_rows(keep, np.array), begin_of=begin_of)
    return replace(first, function=function, memory=memory)


def _call_rows(
    functions: Sequence[Callable[..., Any]], collect: Callable[[list[Any]], Any] = same
) -> Callable[..., Any]:
    """A function that calls one of several for each row of its arguments; some arguments may be None."""

    def called(*values: Any) -> Any:
        columns = (repeat(None, len(functions)) if value is None else value for value in values)
        return collect([function(*row) for function, *row in zip(functions, *columns, strict=True)])

    return called
