"""SignalLogs: every named signal at the sensors' rate, by logs of what the signals follow from."""

from collections.abc import Mapping

import numpy as np
from pydrake.systems.framework import Context, Diagram, DiagramBuilder, OutputPort, PortDataType
from pydrake.systems.primitives import Multiplexer, VectorLogSink

from soft_gripper.arrays import Array
from soft_gripper.diagrams.recording.derived_signals import Logged, SignalSources, Source, derive
from soft_gripper.diagrams.recording.value_log import ValueLog
from soft_gripper.signals import Signal, signal_of


class SignalLogs(Diagram):
    """Keeps what signals follow from, sampled each `period` s; an input port for each.

    Vectors go into one log side by side: every system more in a diagram costs at every step.
    """

    def __init__(self, signals: Mapping[str, OutputPort], sources: Mapping[str, Source], period: float):
        """`signals` are vector ports by the names that a recording gives them; what they carry is read from them."""
        super().__init__()
        builder = DiagramBuilder()
        self.signals: dict[str, Signal] = {name: signal_of(port) for name, port in signals.items()}
        self._sources = dict(sources)
        logged = _logged_ports(sources)
        self._vectors = {port: name for port, name in logged.items() if _is_vector(port)}
        self._values: dict[OutputPort, ValueLog] = {}
        together = builder.AddNamedSystem("vectors", Multiplexer([port.size() for port in self._vectors]))
        self._sink = builder.AddNamedSystem("log", VectorLogSink(together.get_output_port().size(), period))
        builder.Connect(together.get_output_port(), self._sink.get_input_port())
        for i, name in enumerate(self._vectors.values()):
            builder.ExportInput(together.get_input_port(i), name)
        for port, name in logged.items():
            if port not in self._vectors:
                self._values[port] = builder.AddNamedSystem(name, ValueLog(period))
                builder.ExportInput(self._values[port].get_input_port(), name)
        builder.BuildInto(self)

    @property
    def logged(self) -> list[OutputPort]:
        """The ports that have a log, in the order of the inputs."""
        return [*self._vectors, *self._values]

    def samples(self, root_context: Context) -> tuple[Array, dict[str, Array]]:
        """Times, (T,) s, and all signals, (T, size) each, in the context of the whole diagram."""
        log = self._sink.FindLog(root_context)
        ends = np.cumsum([port.size() for port in self._vectors])
        vectors = dict(zip(self._vectors, np.split(log.data().T, ends[:-1], axis=1), strict=True))
        values = {port: sink.values(root_context) for port, sink in self._values.items()}
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
        builder: of the diagram, in which what feeds the signals is connected.
        signals: vector ports by the names that the recording gives them, such as "left_finger.strain".
        period: between the samples, s.
    """
    sources = SignalSources(builder, period)
    logs = SignalLogs(signals, {name: sources.find(port) for name, port in signals.items()}, period)
    builder.AddNamedSystem("logs", logs)
    for i, port in enumerate(logs.logged):
        builder.Connect(port, logs.get_input_port(i))
    return logs


def _logged_ports(sources: Mapping[str, Source]) -> dict[OutputPort, str]:
    """The ports that need a log, and its name: that of the signal, if the port is one."""
    found = {source.port: name for name, source in reversed(list(sources.items())) if isinstance(source, Logged)}
    blocks = [source.of for source in sources.values() if not isinstance(source, Logged)]
    while blocks:
        for source in blocks.pop().leaves.values():
            if isinstance(source, Logged):
                found.setdefault(source.port, f"{source.port.get_system().get_name()}.{source.port.get_name()}")
            else:
                blocks.append(source.of)
    return found


def _is_vector(port: OutputPort) -> bool:
    return bool(port.get_data_type() == PortDataType.kVectorValued)
