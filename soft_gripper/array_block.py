"""ArrayBlock: a block made of functions over arrays whose leading axes are free.

Its ports call the functions for one sample. A recording calls them once for all samples, so that signals that nothing
in a diagram reads cost next to nothing while it runs.
"""

from collections.abc import Callable, Iterable, Mapping, Sequence
from functools import partial
from typing import Any, NamedTuple

import numpy as np
from pydrake.common.value import AbstractValue
from pydrake.systems.framework import BasicVector, Context, InputPort, LeafSystem

from soft_gripper.arrays import Array
from soft_gripper.cached import Cached, weakly
from soft_gripper.signals import describe


class _Step(NamedTuple):
    """A quantity known for every sample."""

    read: Callable[[Context], Any]
    tickets: set[Any]
    sources: tuple[str, ...] = ()
    over_time: Callable[..., Any] | None = None  # from those of the sources, at all samples; None: only a run knows
    period: float | None = None  # s, of the samples that it remembers, if any
    is_logged: bool = False  # by a port of its own, and so known at all samples, as inputs are


class ArrayBlock(LeafSystem):
    """A block whose outputs follow from its inputs by functions, given in its constructor step by step.

    A step has a name and follows from those before it. Functions take the steps that they name, of shape
    (..., size) if they are inputs, and return an array, or anything else that keeps the leading axes. Caches and
    prerequisites are as narrow as the steps say.
    """

    def __init__(self) -> None:
        super().__init__()
        self._steps: dict[str, _Step] = {}
        self._calcs: dict[str, Callable[[Context], Any]] = {}  # of the steps that are cached
        self._outputs: dict[str, tuple[Callable[..., Any], tuple[str, ...]]] = {}  # functions and their steps

    def take(self, name: str, size: int) -> InputPort:
        """Declares a vector input and the step of its name."""
        port = self.DeclareVectorInputPort(name, size)
        self._steps[name] = _Step(port.Eval, {port.ticket()})
        return port

    def derive(
        self, name: str, function: Callable[..., Any], *sources: str, over_time: Callable[..., Any] | None = None
    ) -> None:
        """Declares a step that several others use, computed once per sample.

        `over_time` replaces the function for a whole recording, if the function handles a single sample only.
        """
        reads, tickets = self._reads(sources), self._tickets(sources)
        step = _Step(self._read_all(function, reads), set(), sources, over_time or function)
        self._keep(name, step, tickets)

    def show(self, name: str, function: Callable[[Context], Any], tickets: set[Any]) -> None:
        """Declares a step that is not an array, and an output that holds it; over all samples it is a list."""
        self._calcs[name] = function
        calc = partial(weakly(self._calc_step), name)
        port = self.DeclareAbstractOutputPort(name, lambda: AbstractValue.Make(object()), calc, tickets)
        self._steps[name] = _Step(port.Eval, tickets, is_logged=True)

    def remember(
        self,
        name: str,
        function: Callable[[Context], Any],
        *sources: str,
        over_time: Callable[..., Any] | None = None,
        period: float | None = None,
    ) -> None:
        """Declares a step that also depends on the discrete state.

        `over_time` computes it at all samples of a recording, from their times, (T,) s, and the sources, if they are
        `period` s apart; None: the memory is known only during a run.
        """
        step = _Step(function, set(), ("time", *sources), over_time, period)
        self._keep(name, step, self._tickets(sources) | {self.xd_ticket()})

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
        value = self._read_all(function, self._reads(sources))

        def calc(context: Context, output: BasicVector) -> None:
            output.SetFromVector(np.asarray(value(context)).reshape(-1))

        port = self.DeclareVectorOutputPort(name, size, calc, self._tickets(sources))
        describe(port, unit, meanings, **axes)
        self._outputs[name] = function, sources

    def read(self, name: str, context: Context) -> Any:
        """A step of the present sample."""
        return self._steps[name].read(context)

    def follows(self, output: str, period: float) -> bool:
        """Whether `leaves` determine an output at all samples of a recording, `period` s apart."""
        return output in self._outputs and all(self._follows(step, period) for step in self._outputs[output][1])

    def leaves(self, output: str) -> list[str]:
        """Names of the inputs, and of the outputs declared by `show`, that determine an output."""
        return list(dict.fromkeys(leaf for step in self._outputs[output][1] for leaf in self._leaves(step)))

    def over_time(self, time: Array, leaves: Mapping[str, Any], outputs: Iterable[str]) -> dict[str, Array]:
        """Outputs at all T samples, (T, size) each.

        Args:
            time: of the samples, s, (T,).
            leaves: values at these times, (T, size) each, or a list of T, by port name.
            outputs: names of ports.
        """
        known: dict[str, Any] = {"time": time, **leaves}
        found = {}
        for name in outputs:
            function, sources = self._outputs[name]
            found[name] = np.reshape(function(*[self._at_all(source, known) for source in sources]), (len(time), -1))
        return found

    def _at_all(self, name: str, known: dict[str, Any]) -> Any:
        if name not in known:
            step = self._steps[name]
            assert step.over_time is not None
            known[name] = step.over_time(*[self._at_all(source, known) for source in step.sources])
        return known[name]

    def _follows(self, name: str, period: float) -> bool:
        if name == "time" or self._is_leaf(name):
            return True
        step = self._steps[name]
        fits = step.over_time is not None and step.period in (None, period)
        return fits and all(self._follows(source, period) for source in step.sources)

    def _leaves(self, name: str) -> list[str]:
        if name == "time":
            return []
        if self._is_leaf(name):
            return [name]
        return [leaf for source in self._steps[name].sources for leaf in self._leaves(source)]

    def _is_leaf(self, name: str) -> bool:
        step = self._steps[name]
        return step.is_logged or not step.sources

    def _keep(self, name: str, step: _Step, tickets: set[Any]) -> None:
        """Adds a step, with a cache entry for it."""
        self._calcs[name] = step.read
        cached = Cached(self, name, partial(weakly(self._calc_step), name), tickets)
        self._steps[name] = step._replace(read=cached.Eval, tickets={cached.ticket})

    def _calc_step(self, name: str, context: Context, value: AbstractValue) -> None:
        value.set_value(self._calcs[name](context))

    @staticmethod
    def _read_all(function: Callable[..., Any], reads: Sequence[Callable[[Context], Any]]) -> Callable[[Context], Any]:
        return lambda context: function(*[read(context) for read in reads])

    def _reads(self, sources: Sequence[str]) -> list[Callable[[Context], Any]]:
        return [self._steps[source].read for source in sources]

    def _tickets(self, sources: Sequence[str]) -> set[Any]:
        return {ticket for source in sources for ticket in self._steps[source].tickets}
