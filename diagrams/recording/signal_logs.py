"""SignalLogs: every named signal at the sensors' rate, by logs of what the signals follow from."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from pydrake.common.value import AbstractValue
from pydrake.systems.framework import (
    Context,
    Diagram,
    DiagramBuilder,
    EventStatus,
    LeafSystem,
    OutputPort,
    PortDataType,
)
from pydrake.systems.primitives import Multiplexer, VectorLogSink

from soft_gripper.arrays import Array
from soft_gripper.cached import Cached
from soft_gripper.diagrams.recording.derived_signals import Logged, SignalSources, Source, derive
from soft_gripper.signals import Signal, signal_of


class ValueLog(LeafSystem):
    """Keeps the values of a port, as a VectorLogSink keeps vectors: in its context, from the beginning of a run.

    ::

        value (any Python object) ---> ValueLog
    """

    def __init__(self, period: float):
        """Takes a value every `period` s."""
        super().__init__()
        self._value = self.DeclareAbstractInputPort("value", AbstractValue.Make(object()))
        self._log = Cached(self, "log", lambda _, value: value.set_value([]), {self.nothing_ticket()})
        self.DeclarePeriodicPublishEvent(period, 0.0, self._keep)
        self.DeclareForcedPublishEvent(self._keep)

    def values(self, root_context: Context) -> list[Any]:
        """The kept values, in the context of the whole diagram."""
        log: list[Any] = self._log.Eval(self.GetMyContextFromRoot(root_context))
        return log

    def _keep(self, context: Context) -> EventStatus:
        self._log.Eval(context).append(self._value.Eval(context))
        return EventStatus.Succeeded()


class SignalLogs(Diagram):
    """Keeps what signals follow from, sampled each `period` s; an input port for each.

    Vectors go into one log side by side, since every additional system in a diagram costs time at every step.
    """

    def __init__(self, signals: Mapping[str, OutputPort], sources: SignalSources, period: float):
        """`signals` are vector ports by their names in the recording; units and axes are read from the ports."""
        super().__init__()
        builder = DiagramBuilder()
        self.signals: dict[str, Signal] = {name: signal_of(port) for name, port in signals.items()}
        self._sources = {name: sources.find(port) for name, port in signals.items()}
        names = _logged_ports(self._sources, sources.ports)
        self._sizes = {i: sources.ports[i].size() for i in names if _is_vector(sources.ports[i])}
        self._values: dict[int, ValueLog] = {}
        together = builder.AddNamedSystem("vectors", Multiplexer([*self._sizes.values()]))
        self._sink = builder.AddNamedSystem("log", VectorLogSink(together.get_output_port().size(), period))
        builder.Connect(together.get_output_port(), self._sink.get_input_port())
        for i, number in enumerate(self._sizes):
            builder.ExportInput(together.get_input_port(i), names[number])
        for number, name in names.items():
            if number not in self._sizes:
                self._values[number] = builder.AddNamedSystem(name, ValueLog(period))
                builder.ExportInput(self._values[number].get_input_port(), name)
        builder.BuildInto(self)

    @property
    def logged(self) -> list[int]:
        """The ports that have a log, in the order of the inputs, by their places among those of the sources."""
        return [*self._sizes, *self._values]

    def samples(self, root_context: Context) -> tuple[Array, dict[str, Array]]:
        """Times, (T,) s, and all signals, (T, size) each, in the context of the whole diagram."""
        log = self._sink.FindLog(root_context)
        ends = np.cumsum([*self._sizes.values()])
        vectors = dict(zip(self._sizes, np.split(log.data().T, ends[:-1], axis=1), strict=True))
        values = {number: sink.values(root_context) for number, sink in self._values.items()}
        time: Array = log.sample_times()
        return time, derive(self._sources, time, vectors | values)

    def clear(self, root_context: Context) -> None:
        """Forgets all samples, in the context of the whole diagram."""
        self._sink.FindMutableLog(root_context).Clear()
        for sink in self._values.values():
            sink.values(root_context).clear()


def add_logs(builder: DiagramBuilder, signals: Mapping[str, OutputPort], period: float) -> SignalLogs:
    """Adds `logs` to any diagram; `read_logs` makes a Recording of all signals of them after a run.

    Signals of an ArrayBlock are not computed while the diagram runs, unless something else reads them.

    Args:
        builder: of the diagram, in which the sources of the signals are connected.
        signals: vector ports by their names in the recording, such as "left_finger.strain".
        period: between the samples, s.
    """
    sources = SignalSources(builder, period)
    logs = SignalLogs(signals, sources, period)
    builder.AddNamedSystem("logs", logs)
    for i, number in enumerate(logs.logged):
        builder.Connect(sources.ports[number], logs.get_input_port(i))
    return logs


def _logged_ports(sources: Mapping[str, Source], ports: Sequence[OutputPort]) -> dict[int, str]:
    """The ports that need a log, and its name: that of the signal, if the port is one."""
    found = {source.number: name for name, source in reversed(list(sources.items())) if isinstance(source, Logged)}
    blocks = [source.of for source in sources.values() if not isinstance(source, Logged)]
    while blocks:
        for source in blocks.pop().leaves.values():
            if isinstance(source, Logged):
                port = ports[source.number]
                found.setdefault(source.number, f"{port.get_system().get_name()}.{port.get_name()}")
            else:
                blocks.append(source.of)
    return found


def _is_vector(port: OutputPort) -> bool:
    return bool(port.get_data_type() == PortDataType.kVectorValued)
