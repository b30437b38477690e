"""SampledSteps: one value after the other."""

from collections.abc import Sequence

from pydrake.systems.framework import Context, DiscreteValues, LeafSystem


class SampledSteps(LeafSystem):
    """A source that changes with the samples only, so that what follows it in Python is called no more often.

    ::

        +--------------+
        | SampledSteps | ---> value  (1)
        +--------------+
    """

    def __init__(self, values: Sequence[float], duration: float, period: float):
        """Each value lasts `duration` s, the last one for ever; samples every `period` s."""
        super().__init__()
        self._values, self._duration = tuple(values), duration
        self.DeclareStateOutputPort("value", self.DeclareDiscreteState([values[0]]))
        if len(values) > 1:
            self.DeclarePeriodicDiscreteUpdateEvent(period, 0.0, self._update)

    def _update(self, context: Context, values: DiscreteValues) -> None:
        step = int((context.get_time() + 1e-9) / self._duration)
        values.set_value([self._values[min(step, len(self._values) - 1)]])
