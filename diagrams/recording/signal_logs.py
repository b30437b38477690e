"""SignalLogs: every named signal at the sensors' rate, by logs of what the signals follow from."""

from collections.abc import Mapping

from pydrake.systems.framework import Context, Diagram, DiagramBuilder, OutputPort, PortDataType
from pydrake.systems.primitives import VectorLogSink

from soft_gripper.arrays import Array
from soft_gripper.diagrams.recording.derived_signals import Logged, SignalSources, Source, derive
from soft_gripper.diagrams.recording.value_log import ValueLog
from soft_gripper.signals import Signal, signal_of


class SignalLogs(Diagram):
    """Keeps what signals follow from, sampled each `period` s; an input port for each."""

    def __init__(self, signals: Mapping[str, OutputPort], sources: Mapping[str, Source], period: float):
        """`signals` are vector ports by the names that a recording gives them; what they carry is read from them."""
        super().__init__()
        builder = DiagramBuilder()
        self.signals: dict[str, Signal] = {name: signal_of(port) for name, port in signals.items()}
        self._sources = dict(sources)
        self._sinks: dict[OutputPort, VectorLogSink | ValueLog] = {}
        for port, name in _logged_ports(sources).items():
            sink = VectorLogSink(port.size(), period) if _is_vector(port) else ValueLog(period)
            self._sinks[port] = builder.AddNamedSystem(name, sink)
            builder.ExportInput(sink.get_input_port(), name)
        builder.BuildInto(self)

    @property
    def logged(self) -> list[OutputPort]:
        """The ports that have a log, in the order of the inputs."""
        return list(self._sinks)

    def samples(self, root_context: Context) -> tuple[Array, dict[str, Array]]:
        """Times, (T,) s, and all signals, (T, size) each, in the context of the whole diagram."""
        vectors = {port: sink.FindLog(root_context) for port, sink in self._sinks.items() if _is_vector(port)}
        values = {port: sink.values(root_context) for port, sink in self._sinks.items() if not _is_vector(port)}
        time: Array = next(iter(vectors.values())).sample_times()
        return time, derive(self._sources, time, {port: log.data().T for port, log in vectors.items()} | values)

    def clear(self, root_context: Context) -> None:
        """Forgets all samples, in the context of the whole diagram."""
        for port, sink in self._sinks.items():
            if _is_vector(port):
                sink.FindMutableLog(root_context).Clear()
            else:
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
