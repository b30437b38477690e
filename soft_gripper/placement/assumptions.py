"""What a placement is to be good for: an estimator, and how wrong sensors and beliefs may be."""

import math
from dataclasses import dataclass
from functools import cached_property

from soft_gripper.diagrams.wiring.named_blocks import find_estimator
from soft_gripper.errors import InputError
from soft_gripper.estimators.uncertainty import Uncertainty
from soft_gripper.fingers.finger import Finger
from soft_gripper.scenario.belief import Belief
from soft_gripper.scenario.scenario import BelievedConfig
from soft_gripper.sensors.strain_errors import StrainErrors

SETS = 16  # of sensors that are drawn, where they have errors
USUAL_STRAIN = 0.05  # at which errors that are a share of the strain are believed


@dataclass(frozen=True)
class Assumptions:
    """An estimator, the errors of its sensors, and by how much the stiffness is believed wrong.

    Raises:
        InputError: if there is no such estimator, or a finger cannot be believed so wrong.
    """

    estimator: str = "gaussian"
    errors: StrainErrors | None = None  # None: ideal sensors
    belief: float = 0.0  # %, of Young's modulus, up and down
    seed: int = 1  # of what is random

    def __post_init__(self) -> None:
        find_estimator(self.estimator, field="--estimator")
        if not 0 <= self.belief < 100:
            raise InputError("place-sensors", "--belief", self.belief, "give a percentage from 0 to below 100")

    @property
    def sets(self) -> int:
        """How many sets of sensors are drawn; ideal ones are all alike."""
        return 1 if self.errors is None else SETS

    def believed(self, finger: Finger) -> list[Finger]:
        """The finger as it is believed to be, once too stiff and once too soft."""
        signs = (1, -1) if self.belief else (1,)
        changes = [BelievedConfig(youngs_modulus=f"{sign * self.belief:+g} %") for sign in signs]
        return [Belief(change).finger(finger) for change in changes]

    @cached_property
    def uncertainty(self) -> Uncertainty:
        """What the estimator believes of these errors: their sizes, no less than by default."""
        least = Uncertainty()
        bend = max(least.bend_per_pressure, self.belief / 100)
        reading = least.reading if self.errors is None else max(least.reading, reading_std(self.errors))
        return Uncertainty(reading=reading, bend_per_pressure=bend)


def reading_std(errors: StrainErrors) -> float:
    """About by how much extension ratios are read wrong: all errors together, at a usual strain, after a minute."""
    absolute = errors.noise, errors.offset, errors.drift, errors.low_frequency_noise
    relative = errors.gain_error, errors.hysteresis, errors.creep
    return math.hypot(*absolute, *(USUAL_STRAIN * share for share in relative))
