"""LogSource: a recorded signal, sample for sample, as the output of a block."""

from collections.abc import Sequence
from typing import Any

import numpy as np
from pydrake.systems.framework import Context, DiscreteValues, LeafSystem

from soft_gripper.arrays import Array
from soft_gripper.signals import describe


class LogSource(LeafSystem):
    """Puts out what was recorded.

    ::

        +-----------+
        | LogSource | ---> {signal}  (entries of the signal)
        +-----------+

    Sampled in discrete state every period, from time 0, as a sensor is; after the last sample it stays.
    """

    def __init__(self, signal: str, samples: Array, period: float, unit: str, **axes: Sequence[Any]):
        """`samples` (T, ...) every `period` s; unit and axes as for `describe`."""
        super().__init__()
        self._samples, self._period = samples.reshape(len(samples), -1), period
        state = self.DeclareDiscreteState(self._samples.shape[1])
        self.DeclareInitializationDiscreteUpdateEvent(self._sample)
        self.DeclarePeriodicDiscreteUpdateEvent(period, 0.0, self._sample)
        describe(self.DeclareStateOutputPort(signal, state), unit, **axes)

    def _sample(self, context: Context, values: DiscreteValues) -> None:
        row = min(round(context.get_time() / self._period), len(self._samples) - 1)
        values.set_value(np.array(self._samples[row]))
