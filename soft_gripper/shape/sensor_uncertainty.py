"""What is uncertain to an estimator whose sensors have errors, and who knows the finger to some accuracy only.

Hysteresis and creep count as a share of the strain, as a gain does. A drift, which is steady, counts as a random walk
that comes as far in a minute.
"""

import math

from soft_gripper.sensors.pressure_errors import PressureErrors
from soft_gripper.sensors.strain_errors import MINUTE, StrainErrors
from soft_gripper.shape.uncertainty import Uncertainty


def uncertainty_of(
    strain: StrainErrors | None = None, pressure: PressureErrors | None = None, finger: float = 0.0
) -> Uncertainty:
    """What follows from the errors of the sensors, None for ideal ones; see `Uncertainty` for what is known without.

    `finger` is the standard deviation of the bend per pressure that is believed, as a share: of Young's modulus, say.
    """
    ideal, strain, pressure = Uncertainty(), strain or StrainErrors(), pressure or PressureErrors()
    rounding = (strain.quantization or 0.0) / math.sqrt(12)
    return Uncertainty(
        reading=math.hypot(ideal.reading, strain.low_frequency_noise, strain.noise, rounding),
        gain=math.hypot(strain.gain_error, strain.hysteresis, strain.creep),
        offset=strain.offset,
        drift=strain.drift / math.sqrt(MINUTE),
        bend_per_pressure=math.hypot(ideal.bend_per_pressure, pressure.gain_error, finger),
        pressure=math.hypot(ideal.pressure, pressure.offset, pressure.noise),
    )
