"""StrainSensor: the strain sensors of a finger as a block."""

from soft_gripper.errors import InputError
from soft_gripper.sensors.measurement import MeasurementModel
from soft_gripper.sensors.sensor_block import SensorBlock
from soft_gripper.sensors.sensor_layout import measures_strain


class StrainSensor(SensorBlock):
    """Samples the joints of one finger and outputs the readings of its strain sensors.

    ::

        joint_angles (N) rad ---> +--------------+ ---> strain           (R) readings
                                  | StrainSensor |
                                  +--------------+ ---> extension_ratio  (R) length over rest length, ahead of a
                                                                             response curve; of a SensorLayout

    Readings run path after path (inner, outer; only outer when one-sided), from the base to the tip. Of a finger that
    leaves its plane, `PathSensors` also take its other joints, see SensorBlock. The outputs hold their values between
    samples.
    """

    def __init__(self, layout: MeasurementModel, period: float):
        """Samples every `period` s, beginning at initialization, the sensors of a `SensorLayout` or `PathSensors`.

        Raises:
            InputError: if the sensors measure something else than strain.
        """
        if not measures_strain(layout):
            expected = "give sensors of strain; SensorBlock reads those of any kind"
            raise InputError("StrainSensor", "layout", layout.quantity, expected)
        super().__init__(layout, period)
