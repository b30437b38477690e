"""Errors of a pressure sensor: pressure -> disturbed pressure.

Another error is a field of `PressureErrors` and its effect in `step`.
"""

from dataclasses import dataclass

import numpy as np

from soft_gripper.arrays import Array
from soft_gripper.files.document import check_config
from soft_gripper.quantity import quantity
from soft_gripper.sensors.error_block import pass_delay_line


@dataclass
class PressureErrors:
    """The errors of a pressure sensor, in the order of their action; none by default.

    Its memory is an array, (..., 2 + delay, 1): gain, offset, and the pressures on their way.

    Raises:
        InputError: for the first number that is out of range.
    """

    gain_error: float = quantity(0.0, least=0)  # standard deviation, drawn once per run, as a fraction of the pressure
    offset: float = quantity(0.0, "Pa", least=0)  # standard deviation, drawn once per run
    noise: float = quantity(0.0, "Pa", least=0)  # standard deviation, white, of every sample
    delay: int = quantity(0, least=0)  # samples

    draws = (2, 1)

    def __post_init__(self) -> None:
        check_config("sensor.pressure_errors", self)

    def begin(self, draws: Array) -> Array:
        """Initial memory, from standard normal draws for the run, (..., 2, 1)."""
        gain, offset = draws[..., :1, :], draws[..., 1:, :]
        line = np.full((*draws.shape[:-2], self.delay, draws.shape[-1]), np.nan)
        return np.concatenate([1 + self.gain_error * gain, self.offset * offset, line], axis=-2)

    def step(self, memory: Array, ideal: Array, draws: Array) -> tuple[Array, Array]:
        """One sample of pressures, (..., 1) Pa: the new memory and the disturbed pressures, (..., 1) Pa.

        Args:
            memory: after the sample before, or as a run begins.
            ideal: true pressures, (..., 1) Pa.
            draws: standard normal, (..., 1, 1).
        """
        gain, offset = memory[..., 0, :], memory[..., 1, :]
        line, delayed = pass_delay_line(memory[..., 2:, :], gain * ideal + offset + self.noise * draws[..., 0, :])
        return np.concatenate([memory[..., :2, :], line], axis=-2), delayed
