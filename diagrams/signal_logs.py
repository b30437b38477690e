"""Logs of the ports from which the signals of a run follow."""

from collections.abc import Mapping, Sequence
from functools import cached_property
from typing import Any

import numpy as np
from pydrake.common.value import AbstractValue
from pydrake.systems.framework import (
    Context,
    Diagram,
    DiagramBuilder,
    EventStatus,
    InputPort,
    LeafSystem,
    OutputPort,
    PortDataType,
)
from pydrake.systems.primitives import Multiplexer, VectorLogSink

from soft_gripper.arrays import Array
from soft_gripper.cached import Cached
from soft_gripper.diagrams.signal_labels import Labels, labels_of
from soft_gripper.diagrams.signal_sources import LoggedPort, Samples, SignalSource, SignalSources
from soft_gripper.signals import Signal, signal_of


class ValueLog(LeafSystem):
    """Logs the values of a port as a VectorLogSink logs vectors: in its context, from the beginning of a run.

    ::

        value (any Python object) ---> ValueLog
    """

    def __init__(self, period: float):
        """Samples a value every `period` s."""
        super().__init__()
        self._value = self.DeclareAbstractInputPort("value", AbstractValue.Make(object()))
        self._log = Cached(self, "log", lambda _, value: value.set_value([]), {self.nothing_ticket()})
        self.DeclarePeriodicPublishEvent(period, 0.0, self._keep)
        self.DeclareForcedPublishEvent(self._keep)

    def values(self, root_context: Context) -> list[Any]:
        """The logged values, from the context of the root diagram."""
        log: list[Any] = self._log.Eval(self.GetMyContextFromRoot(root_context))
        return log

    def _keep(self, context: Context) -> EventStatus:
        self._log.Eval(context).append(self._value.Eval(context))
        return EventStatus.Succeeded()


class SignalLogs(Diagram):
    """Logs the sources of signals, sampled every `period` s; with an input port for each.

    Vectors share one log, because each additional system in a diagram costs time at every step.
    """

    def __init__(self, signals: Mapping[str, OutputPort], sources: SignalSources, period: float):
        """`signals` are vector ports by name in the recording; units and axes are read from the ports."""
        super().__init__()
        builder = DiagramBuilder()
        self.signals: dict[str, Signal] = {name: signal_of(port) for name, port in signals.items()}
        self._sources = {name: sources.find(port) for name, port in signals.items()}
        names = _logged_ports(self._sources, sources.ports)
        ports = {i: sources.ports[i] for i in names}
        self._sizes = {i: p.size() for i, p in ports.items() if p.get_data_type() == PortDataType.kVectorValued}
        self._values: dict[int, ValueLog] = {}
        multiplexer = builder.AddNamedSystem("vectors", Multiplexer([*self._sizes.values()]))
        self._sink = builder.AddNamedSystem("log", VectorLogSink(multiplexer.get_output_port().size(), period))
        builder.Connect(multiplexer.get_output_port(), self._sink.get_input_port())
        for i, port_number in enumerate(self._sizes):
            builder.ExportInput(multiplexer.get_input_port(i), names[port_number])
        for port_number, name in names.items():
            if port_number not in self._sizes:
                self._values[port_number] = builder.AddNamedSystem(name, ValueLog(period))
                builder.ExportInput(self._values[port_number].get_input_port(), name)
        builder.BuildInto(self)

    @cached_property
    def labels(self) -> Labels:
        """The axes of all signals."""
        return labels_of(self.signals)

    @property
    def port_numbers(self) -> list[int]:
        """The logged ports, in the order of the inputs, by their indices among those of the sources."""
        return [*self._sizes, *self._values]

    def samples(self, root_context: Context) -> Samples:
        """Reads all signals in the context of the root diagram."""
        log = self._sink.FindLog(root_context)
        ends = np.cumsum([*self._sizes.values()])
        vectors = dict(zip(self._sizes, np.split(log.data().T.copy(), ends[:-1], axis=1), strict=True))
        values = {port_number: [*sink.values(root_context)] for port_number, sink in self._values.items()}
        return self.make_samples(log.sample_times().copy(), vectors | values)

    def make_samples(self, time: Array, logged: Mapping[int, Any]) -> Samples:
        """Makes all signals from times, (T,) s, and from the contents of the logs, by port number."""
        return Samples(self._sources, time, logged)

    def clear(self, root_context: Context) -> None:
        """Forgets all samples, in the context of the root diagram."""
        self._sink.FindMutableLog(root_context).Clear()
        for sink in self._values.values():
            sink.values(root_context).clear()


def add_logs(builder: DiagramBuilder, signals: Mapping[str, OutputPort], period: float) -> SignalLogs:
    """Adds `logs` to any diagram; `read_logs` makes a Recording of all their signals after a run.

    Args:
        builder: builder of the diagram, in which the sources of the signals are connected.
        signals: vector ports by name in the recording, such as "left_finger.strain".
        period: sampling period, s.
    """
    sources = SignalSources(builder, period)
    logs = SignalLogs(signals, sources, period)
    builder.AddNamedSystem("logs", logs)
    for i, port_number in enumerate(logs.port_numbers):
        port = sources.ports[port_number]
        connect = builder.ConnectToSame if isinstance(port, InputPort) else builder.Connect
        connect(port, logs.get_input_port(i))
    return logs


def _logged_ports(sources: Mapping[str, SignalSource], ports: Sequence[OutputPort | InputPort]) -> dict[int, str]:
    """The ports that need a log, with the name of each log: the signal's name if the port is a signal."""
    port_names = {
        source.number: name for name, source in reversed(list(sources.items())) if isinstance(source, LoggedPort)
    }
    blocks = [source.derived for source in sources.values() if not isinstance(source, LoggedPort)]
    while blocks:
        for source in blocks.pop().leaves.values():
            if isinstance(source, LoggedPort):
                port = ports[source.number]
                port_names.setdefault(source.number, f"{port.get_system().get_name()}.{port.get_name()}")
            else:
                blocks.append(source.derived)
    return port_names
