"""SignalLogs: one log for every named signal, at the sensors' rate."""

from collections.abc import Mapping

from pydrake.systems.framework import Context, Diagram, DiagramBuilder, OutputPort
from pydrake.systems.primitives import VectorLog, VectorLogSink

from soft_gripper.signals import Signal, signal_of


class SignalLogs(Diagram):
    """Keeps every signal, sampled each `period` s; an input port a signal, named like it."""

    def __init__(self, signals: Mapping[str, OutputPort], period: float):
        """`signals` are vector ports by the names that a recording gives them; what they carry is read from them."""
        super().__init__()
        builder = DiagramBuilder()
        self.signals: dict[str, Signal] = {name: signal_of(port) for name, port in signals.items()}
        self._sinks = {}
        for name, port in signals.items():
            self._sinks[name] = builder.AddNamedSystem(name, VectorLogSink(port.size(), period))
            builder.ExportInput(self._sinks[name].get_input_port(), name)
        builder.BuildInto(self)

    def find_log(self, signal: str, root_context: Context) -> VectorLog:
        """The log of a signal in the context of the whole diagram."""
        return self._sinks[signal].FindLog(root_context)


def add_logs(builder: DiagramBuilder, signals: Mapping[str, OutputPort], period: float) -> SignalLogs:
    """Adds `logs`, a log for every signal, to any diagram; `read_logs` makes a Recording of them after a run.

    Args:
        builder: of the diagram.
        signals: vector ports by the names that the recording gives them, such as "left_finger.strain".
        period: between the samples, s.
    """
    logs = builder.AddNamedSystem("logs", SignalLogs(signals, period))
    for name, port in signals.items():
        builder.Connect(port, logs.GetInputPort(name))
    return logs
