"""What is uncertain to an estimator whose sensors have errors, and who knows the finger to some accuracy only.

All that disturbs a reading counts as one standard deviation, as if it were drawn anew for every sample: white noise
is, gain and offset stay as they are drawn. Of a drift it is what a minute brings.
"""

import math

from soft_gripper.sensors.pressure_errors import PressureErrors
from soft_gripper.sensors.strain_errors import StrainErrors
from soft_gripper.shape.uncertainty import Uncertainty


def uncertainty_of(
    strain: StrainErrors | None = None, pressure: PressureErrors | None = None, finger: float = 0.0
) -> Uncertainty:
    """What follows from the errors of the sensors, None for ideal ones; see `Uncertainty` for what is known without.

    `finger` is the standard deviation of what is believed of the bend per pressure, as a share: of Young's modulus, say.
    """
    ideal, strain, pressure = Uncertainty(), strain or StrainErrors(), pressure or PressureErrors()
    rounding = (strain.quantization or 0.0) / math.sqrt(12)
    of_ratio = strain.offset, strain.drift, strain.low_frequency_noise, strain.noise, rounding
    return Uncertainty(
        reading=math.hypot(ideal.reading, *of_ratio),
        strain_share=math.hypot(strain.gain_error, strain.hysteresis, strain.creep),
        bend_per_pressure=math.hypot(ideal.bend_per_pressure, pressure.gain_error, finger),
        pressure=math.hypot(ideal.pressure, pressure.offset, pressure.noise),
    )
