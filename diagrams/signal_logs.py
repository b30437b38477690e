"""Logs of the ports from which the signals of a run follow."""

from collections.abc import Mapping, Sequence
from functools import cached_property
from typing import Any

import numpy as np
from pydrake.systems.framework import Context, Diagram, DiagramBuilder, InputPort, OutputPort, PortDataType
from pydrake.systems.primitives import Multiplexer, VectorLogSink

from soft_gripper.array_block import ArrayBlock
from soft_gripper.arrays import Array
from soft_gripper.cached import Cached
from soft_gripper.diagrams.signal_labels import Labels, labels_of
from soft_gripper.diagrams.signal_sources import DerivedProduct, LoggedPort, Samples, SignalSource, SignalSources
from soft_gripper.signals import Signal, signal_of


class SignalLogs(Diagram):
    """Logs the sources of signals, sampled every `period` s; with an input port for each vector.

    Vectors share one log, because each additional system in a diagram costs time at every step. Other values are logged
    by the blocks that show them.
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
        self._values: dict[int, tuple[ArrayBlock, Cached]] = {}  # blocks that log values, and these
        multiplexer = builder.AddNamedSystem("vectors", Multiplexer([*self._sizes.values()]))
        self._sink = builder.AddNamedSystem("log", VectorLogSink(multiplexer.get_output_port().size(), period))
        builder.Connect(multiplexer.get_output_port(), self._sink.get_input_port())
        for i, port_number in enumerate(self._sizes):
            builder.ExportInput(multiplexer.get_input_port(i), names[port_number])
        for port_number, port in ports.items():
            if port_number not in self._sizes:
                block = port.get_system()
                self._values[port_number] = block, block.log(port.get_name(), period)
        builder.BuildInto(self)

    @cached_property
    def labels(self) -> Labels:
        """The axes of all signals."""
        return labels_of(self.signals)

    @property
    def port_numbers(self) -> list[int]:
        """The logged ports by their indices among those of the sources: the inputs in order, then values of blocks."""
        return [*self._sizes, *self._values]

    def samples(self, root_context: Context) -> Samples:
        """Reads all signals in the context of the root diagram."""
        log = self._sink.FindLog(root_context)
        ends = np.cumsum([*self._sizes.values()])
        vectors = dict(zip(self._sizes, np.split(log.data().T.copy(), ends[:-1], axis=1), strict=True))
        values = {i: [*log.Eval(block.GetMyContextFromRoot(root_context))] for i, (block, log) in self._values.items()}
        return self.make_samples(log.sample_times().copy(), vectors | values)

    def make_samples(self, time: Array, logged: Mapping[int, Any]) -> Samples:
        """Makes all signals from times, (T,) s, and from the contents of the logs, by port number."""
        return Samples(self._sources, time, logged)

    def clear(self, root_context: Context) -> None:
        """Forgets all samples, in the context of the root diagram."""
        self._sink.FindMutableLog(root_context).Clear()
        for block, log in self._values.values():
            log.Eval(block.GetMyContextFromRoot(root_context)).clear()


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
    for i, port_number in enumerate(logs.port_numbers[: logs.num_input_ports()]):
        port = sources.ports[port_number]
        connect = builder.ConnectToSame if isinstance(port, InputPort) else builder.Connect
        connect(port, logs.get_input_port(i))
    return logs


def _logged_ports(sources: Mapping[str, SignalSource], ports: Sequence[OutputPort | InputPort]) -> dict[int, str]:
    """The ports that need a log, with the name of each log: the signal's name if the port is a signal."""
    port_names = {
        source.number: name for name, source in reversed(list(sources.items())) if isinstance(source, LoggedPort)
    }
    pending = list(sources.values())
    while pending:
        source = pending.pop()
        if isinstance(source, LoggedPort):
            port = ports[source.number]
            port_names.setdefault(source.number, f"{port.get_system().get_name()}.{port.get_name()}")
        else:
            pending += [source.source] if isinstance(source, DerivedProduct) else source.derived.leaves.values()
    return port_names
