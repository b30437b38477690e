"""ValueLog: what a port holds that carries no vector, at every sample."""

from typing import Any

from pydrake.common.value import AbstractValue
from pydrake.systems.framework import Context, EventStatus, LeafSystem

from soft_gripper.cached import Cached


class ValueLog(LeafSystem):
    """Keeps the values of a port, as a VectorLogSink keeps vectors: in its context, from the beginning of a run.

    ::

        value (any Python object) ---> ValueLog
    """

    def __init__(self, period: float):
        """Takes a value every `period` s."""
        super().__init__()
        self._value = self.DeclareAbstractInputPort("value", AbstractValue.Make(object()))
        self._log = Cached(self, "log", lambda _: [], {self.nothing_ticket()})
        self.DeclarePeriodicPublishEvent(period, 0.0, self._keep)
        self.DeclareForcedPublishEvent(self._keep)

    def values(self, root_context: Context) -> list[Any]:
        """What was kept, in the context of the whole diagram."""
        log: list[Any] = self._log.Eval(self.GetMyContextFromRoot(root_context))
        return log

    def _keep(self, context: Context) -> EventStatus:
        self._log.Eval(context).append(self._value.Eval(context))
        return EventStatus.Succeeded()
