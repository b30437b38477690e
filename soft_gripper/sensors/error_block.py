"""ErrorBlock: an ideal sampled signal -> the reading of a sensor with errors, without adding a sample of delay.

State is updated at the sample, and the output follows from state and present input: the block remembers without
delaying. Random numbers are drawn at the sample too and kept in state. Drake makes the unrestricted updates of a
RandomSource before discrete ones, so a draw read from its port would change before the strain does.
"""

from typing import NamedTuple, Protocol

import numpy as np
from pydrake.common import RandomDistribution
from pydrake.common.value import AbstractValue
from pydrake.systems.framework import BasicVector, Context, DiscreteValues, LeafSystem

from soft_gripper.arrays import Array
from soft_gripper.cached import Cached, weakly


class ErrorModel(Protocol):
    """Errors of a sensor with R readings, applied sample by sample."""

    @property
    def draws(self) -> tuple[int, int]:
        """Number of standard normal draws per reading: for a run, and for each sample."""

    def begin(self, draws: Array) -> Array:
        """Initial memory, (rows, R), from the draws for the run, (draws, R)."""

    def step(self, memory: Array, ideal: Array, draws: Array) -> tuple[Array, Array]:
        """Memory after a sample, (rows, R), and the reading, (R), from the draws for the sample, (draws, R)."""


class Sample(NamedTuple):
    """Result of one sample."""

    memory: Array  # (rows, R), after it
    read: Array  # (R)


class ErrorBlock(LeafSystem):
    """Disturbs the samples of a sensor.

    ::

        ideal (R) --------------------> +------------+
                                        | ErrorBlock | ---> disturbed (R)
        standard_normal (draws * R) --> +------------+

    `standard_normal` is a random input: connect a RandomSource of the same period, whose first sample also gives the
    draws for the run. Give it an ideal signal that is sampled every `period` s, from time 0, in discrete state.
    """

    def __init__(self, model: ErrorModel, readings: int, period: float, ideal: str, disturbed: str):
        """The errors of `model`; `ideal` and `disturbed` name the ports."""
        super().__init__()
        self._model, self._readings = model, readings
        self._run, self._each = model.draws
        self._ideal = self.DeclareVectorInputPort(ideal, readings)
        size = (self._run + self._each) * readings
        self._normal = self.DeclareVectorInputPort("standard_normal", size, RandomDistribution.kGaussian)
        memory = model.begin(np.zeros((self._run, readings)))
        self._memory = self.DeclareDiscreteState(memory.ravel())
        self._draws = self.DeclareDiscreteState(self._each * readings)
        self.DeclareInitializationDiscreteUpdateEvent(self._begin)
        self.DeclarePeriodicDiscreteUpdateEvent(period, 0.0, self._remember)
        self._sample = Cached(self, "sample", weakly(self._calc), {self._ideal.ticket(), self.xd_ticket()})
        self.DeclareVectorOutputPort(disturbed, readings, self._calc_read, {self._sample.ticket})

    def _begin(self, context: Context, values: DiscreteValues) -> None:
        run, each = np.split(self._normal.Eval(context).reshape(-1, self._readings), [self._run])
        values.set_value(self._memory, self._model.begin(run).ravel())
        values.set_value(self._draws, each.ravel())

    def _remember(self, context: Context, values: DiscreteValues) -> None:
        """Stores the memory of the previous sample, and draws random numbers for the current one.

        At time 0 the first sample is taken again, with the draws that it has. The source has drawn already when this
        is called, so draws that were not kept in state would change before the ideal signal does.
        """
        if context.get_time() > 0:
            values.set_value(self._memory, self._sample.Eval(context).memory.ravel())
            values.set_value(self._draws, self._normal.Eval(context)[self._run * self._readings :])

    def _calc(self, context: Context, value: AbstractValue) -> None:
        memory, draws = (
            context.get_discrete_state(index).value().reshape(-1, self._readings)
            for index in (self._memory, self._draws)
        )
        value.set_value(Sample(*self._model.step(memory, self._ideal.Eval(context), draws)))

    def _calc_read(self, context: Context, output: BasicVector) -> None:
        output.SetFromVector(self._sample.Eval(context).read)


def pass_delay_line(line: Array, present: Array) -> tuple[Array, Array]:
    """The delay line after this sample, and the value that leaves it.

    Args:
        line: what is on its way, (..., delay, R), from the oldest; NaN before the first sample, which is then what
            arrives until it has passed itself.
        present: what sets out, (..., R).

    Returns:
        the line after this sample, and (..., R) that arrives.
    """
    present = present[..., None, :]
    queue = np.concatenate([np.where(np.isnan(line), present, line), present], axis=-2)
    return queue[..., 1:, :], queue[..., 0, :]
