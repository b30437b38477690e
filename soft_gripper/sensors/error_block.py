"""ErrorBlock: an ideal sampled signal -> the reading of a sensor with errors, without adding a sample of delay.

The output follows from what is remembered and the present input: the block remembers without delaying. Random numbers
are sampled too: Drake makes the unrestricted updates of a RandomSource before discrete ones, so a draw read from its
port would change before the strain does.
"""

from collections.abc import Sequence
from typing import Any, Protocol

import numpy as np
from pydrake.common import RandomDistribution

from soft_gripper.array_block import ArrayBlock
from soft_gripper.arrays import Array


class ErrorModel(Protocol):
    """Errors of a sensor with R readings, applied sample by sample."""

    @property
    def draws(self) -> tuple[int, int]:
        """Number of standard normal draws per reading: for a run, and for each sample."""

    def begin(self, draws: Array) -> Array:
        """Initial memory, (rows, R), from the draws for the run, (draws, R)."""

    def step(self, memory: Array, ideal: Array, draws: Array) -> tuple[Array, Array]:
        """Memory after a sample, (rows, R), and the reading, (R), from the draws for the sample, (draws, R)."""


class ErrorBlock(ArrayBlock):
    """Disturbs the samples of a sensor.

    ::

        ideal (R) --------------------> +------------+
                                        | ErrorBlock | ---> disturbed (R)
        standard_normal (draws * R) --> +------------+

    `standard_normal` is a random input: connect a RandomSource of the same period, whose first sample also gives the
    draws for the run. Give it an ideal signal that is sampled every `period` s, from time 0. A value that is not
    finite is put out and not remembered: in place of it a delay line repeats the value before.
    """

    def __init__(
        self,
        model: ErrorModel,
        readings: int,
        period: float,
        ideal: str,
        disturbed: str,
        *,
        unit: str | Sequence[str] = "1",
        **axes: Sequence[Any],
    ):
        """The errors of `model`; `ideal` and `disturbed` name the ports; unit and axes as for `describe`."""
        super().__init__(period)
        run_draws, sample_draws = model.draws

        def rows(draws: Array) -> Array:
            return draws.reshape(*draws.shape[:-1], -1, readings)

        def step(memory: Array, ideal: Array, draws: Array) -> tuple[Array, Array]:
            next_memory, disturbed = model.step(memory, ideal, rows(draws)[..., run_draws:, :])
            return np.where(np.isfinite(next_memory), next_memory, memory), disturbed

        self.take(ideal, readings)
        self.take("standard_normal", (run_draws + sample_draws) * readings, RandomDistribution.kGaussian)
        # The draws at initialization are those of the first sample.
        self.sample("draws", "standard_normal", at_first=False)
        self.remember(
            *("sample", step, ideal, "draws"),
            begin=model.begin(np.zeros((run_draws, readings))),
            begin_of=(lambda draws: model.begin(rows(draws)[..., :run_draws, :]), "standard_normal"),
            keep=lambda sample: sample[0],
        )
        self.put_out(disturbed, lambda sample: sample[1], "sample", unit=unit, **axes)


def pass_delay_line(line: Array, newest: Array) -> tuple[Array, Array]:
    """The delay line after this sample, and the value that leaves it, (..., R).

    The line holds what is on its way, (..., delay, R), from the oldest; NaN before the first sample, which is then what
    arrives until it has passed itself. What sets out is `newest`, (..., R).
    """
    newest = newest[..., None, :]
    queue = np.concatenate([np.where(np.isnan(line), newest, line), newest], axis=-2)
    return queue[..., 1:, :], queue[..., 0, :]
