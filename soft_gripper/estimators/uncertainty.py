"""Uncertainty of a finger, its sensors and its load, as an estimator assumes it.

What a scenario does not give follows from the errors of its sensors: an estimator that trusts noisy readings reports
bands that are far too narrow. Hysteresis and creep count as a share of the strain, as a gain error does; `recursive`
counts what they leave of the largest strain so far, too. A drift, which is steady, counts in proportion to the time
since the zeros were found (`zeroing`); where the offsets are followed (`recursive`), as their rates, which change
within an hour.
"""

import math
from dataclasses import dataclass

import numpy as np

from soft_gripper.arrays import Array
from soft_gripper.files.document import check_config
from soft_gripper.quantity import quantity
from soft_gripper.sensors.pressure_errors import PressureErrors
from soft_gripper.sensors.strain_errors import MINUTE, StrainErrors

_VARIATION_RATIO = 0.6  # standard deviations, of degree 1 over degree 0
_QUADRATIC_RATIO = 0.6  # standard deviations, of degree 2 over degree 1
EXACT = 0.005  # bend per pressure, as a share: that of a nominal model which is exact, but for the discretization


@dataclass
class Uncertainty:
    """Standard deviations and limits, as an estimator assumes them.

    Raises:
        InputError: unless all are finite, `reading` and `load_pressure` are above 0 and the others are not below.
    """

    reading: float = quantity(1e-4, above=0)  # of the measured extension ratios
    angle: float = quantity(2e-4, "rad", least=0)  # of a joint's angle where the finger differs from the nominal one
    # Fraction of the bend due to pressure and to the memory of creep: that of a stiffness and a drive that are known to
    # some 10 %, as those of a finger that was built and not calibrated. 0.005 declares an exact model.
    bend_per_pressure: float = quantity(0.08, least=0)
    # Fraction by which that changes linearly from the middle to the tip, as where a wall is thicker toward one end.
    # Both ends may differ from the middle by 0.9 of it as well.
    # None: 0.6 of `bend_per_pressure`, and 0 of an exact model.
    bend_variation: float | None = quantity(None, least=0)
    pressure: float = quantity(0.0, "Pa", least=0)  # of the pressure measurement
    gain: float = quantity(0.0, least=0)  # fraction of the strain, per sensor; estimated by `recursive`
    offset: float = quantity(0.0, least=0)  # of the extension ratio, per sensor; estimated by `recursive`
    drift: float = quantity(0.0, "1/sqrt(s)", least=0)  # what offsets drift in a minute, over its square root
    # Random walk of the bend per pressure, of creep that the model does not know; followed by `recursive`
    creep: float = quantity(0.0, "1/sqrt(s)", least=0)
    # Whose largest torque at a joint is that of a usual load at the base.
    load_pressure: float = quantity(1.5e5, "Pa", above=0)
    largest_force: float = quantity(10.0, "N", above=0)  # that the scene can exert on a finger
    friction: float = quantity(0.9, above=0)  # largest coefficient between a finger and what it touches
    # Pressure of the drive below which a finger is known to touch nothing: its sensors are zeroed there; 0: never.
    free_pressure: float = quantity(0.0, "Pa", least=0)
    # Fraction of the length before which nothing can touch; two of the bounds of `contact` rely on it.
    nearest_contact: float = quantity(0.3, least=0, below=1)

    def __post_init__(self) -> None:
        check_config("uncertainty", self)

    @property
    def bend_stds(self) -> Array:
        """Standard deviations of the bend per pressure by degree of the Legendre polynomial along the finger, (3,)."""
        common, variation = self.bend_per_pressure, self.bend_variation
        if variation is None:
            variation = _VARIATION_RATIO * math.sqrt(max(common**2 - EXACT**2, 0.0))
        return np.array([common, variation, _QUADRATIC_RATIO * variation])

    def any_reading(self, age: Array | float = 0.0) -> Array | float:
        """Standard deviation of an extension ratio, (...), for estimators without lasting errors.

        `age` is the time since the sensors were zeroed, (...) s; what drifts in a minute counts in any case.
        """
        initial_std, drift_std = math.hypot(self.reading, self.offset), self.drift * math.sqrt(MINUTE)
        return np.hypot(initial_std, drift_std * np.maximum(age / MINUTE, 1.0))


def uncertainty_of(
    strain: StrainErrors | None = None, pressure: PressureErrors | None = None, finger: float | None = None
) -> Uncertainty:
    """The uncertainty that follows from sensor errors, None for ideal sensors; see `Uncertainty` for the defaults.

    `finger` is the standard deviation of the nominal bend per pressure, as a share: of Young's modulus, say; None: the
    default.
    """
    ideal, strain, pressure = Uncertainty(), strain or StrainErrors(), pressure or PressureErrors()
    finger = ideal.bend_per_pressure if finger is None else math.hypot(EXACT, finger)
    rounding = (strain.quantization or 0.0) / math.sqrt(12)
    return Uncertainty(
        reading=math.hypot(ideal.reading, strain.low_frequency_noise, strain.noise, rounding),
        gain=math.hypot(strain.gain_error, strain.hysteresis, strain.creep),
        offset=strain.offset,
        drift=strain.drift / math.sqrt(MINUTE),
        bend_per_pressure=math.hypot(pressure.gain_error, finger),
        pressure=math.hypot(ideal.pressure, pressure.offset, pressure.noise),
    )
