"""What is uncertain to an estimator whose sensors have errors, and who knows the finger to some accuracy only.

All that disturbs a reading counts as one standard deviation, as if it were drawn anew for every sample: white noise
is, gain and offset stay as they are drawn. What is a share of the strain is taken at that of a finger that is well
bent.
"""

import math

from soft_gripper.sensors.pressure_errors import PressureErrors
from soft_gripper.sensors.strain_errors import StrainErrors
from soft_gripper.shape.uncertainty import Uncertainty

USUAL_STRAIN = 0.1


def uncertainty_of(
    strain: StrainErrors | None = None, pressure: PressureErrors | None = None, finger: float = 0.0
) -> Uncertainty:
    """What follows from the errors of the sensors, None for ideal ones; see `Uncertainty` for what is known without.

    `finger` is the standard deviation of what is believed of the bend per pressure, as a share: of Young's modulus, say.
    """
    ideal, strain, pressure = Uncertainty(), strain or StrainErrors(), pressure or PressureErrors()
    return Uncertainty(
        reading=math.hypot(ideal.reading, *_of_reading(strain)),
        bend_per_pressure=math.hypot(ideal.bend_per_pressure, pressure.gain_error, finger),
        pressure=math.hypot(ideal.pressure, pressure.offset, pressure.noise),
    )


def _of_reading(errors: StrainErrors) -> tuple[float, ...]:
    """Standard deviations of the extension ratio that is read; what hysteresis and creep keep back, up to all of it."""
    of_strain = (errors.gain_error, errors.hysteresis / 2, errors.creep / 2)
    rounding = (errors.quantization or 0.0) / math.sqrt(12)
    others = (errors.offset, errors.drift, errors.low_frequency_noise, errors.noise, rounding)
    return (*(share * USUAL_STRAIN for share in of_strain), *others)
