"""SignalLogs: one log for every named signal, at the sensors' rate."""

from collections.abc import Mapping

from pydrake.systems.framework import Context, Diagram, DiagramBuilder, OutputPort
from pydrake.systems.primitives import VectorLog, VectorLogSink


class SignalLogs(Diagram):
    """Keeps every signal, sampled each `period` s; an input port a signal, named like it."""

    def __init__(self, signals: Mapping[str, OutputPort], period: float):
        super().__init__()
        builder = DiagramBuilder()
        self._sinks = {}
        for name, port in signals.items():
            self._sinks[name] = builder.AddNamedSystem(name, VectorLogSink(port.size(), period))
            builder.ExportInput(self._sinks[name].get_input_port(), name)
        builder.BuildInto(self)

    @property
    def signals(self) -> list[str]:
        """Names of the signals, in the order of the input ports."""
        return list(self._sinks)

    def find_log(self, signal: str, root_context: Context) -> VectorLog:
        """The log of a signal in the context of the whole diagram."""
        return self._sinks[signal].FindLog(root_context)
