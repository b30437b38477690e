"""What is believed to be uncertain about a finger, its sensors and its load."""

import math
from dataclasses import dataclass, fields

import numpy as np

from soft_gripper.errors import InputError
from soft_gripper.numbers_check import check_numbers

MINUTE = 60.0  # s


@dataclass
class Uncertainty:
    """Standard deviations, as an estimator believes them.

    Raises:
        InputError: unless all are finite, `reading` and `load_pressure` are above 0 and the others are not below.
    """

    reading: float = 1e-4  # of the extension ratios that sensors read
    angle: float = 2e-4  # rad, of a joint's angle where the finger is not as it is believed to be
    bend_per_pressure: float = 0.005  # share of the bend that pressure, and the memory of creep, lead to
    pressure: float = 0.0  # Pa, of the pressure's measurement
    gain: float = 0.0  # share of the strain, of each sensor; learnt by `recursive`
    offset: float = 0.0  # of the extension ratio, of each sensor; learnt by `recursive`
    drift: float = 0.0  # 1/sqrt(s), random walk of the offsets; followed by `recursive`
    load_pressure: float = 1.5e5  # Pa, whose torque at the base is that of a usual load

    def __post_init__(self) -> None:
        check_numbers("uncertainty", self)
        for field in fields(self):
            value = getattr(self, field.name)
            never_zero = field.name in ("reading", "load_pressure")
            if not np.isfinite(value) or value < 0 or (never_zero and value == 0):
                least = "above 0" if never_zero else "of at least 0"
                raise InputError("uncertainty", field.name, value, f"give a finite number {least}")

    @property
    def any_reading(self) -> float:
        """Of an extension ratio that is read at any time within a minute, to whoever does not learn what is lasting."""
        return math.hypot(self.reading, self.offset, self.drift * math.sqrt(MINUTE))
