"""StrainSensor: samples the joints of a finger and reads the sensors along its sides.

The length of a segment's sensor path depends on its own joint alone, so the lengths are computed in closed form,
without forward kinematics of the chain. A test compares them with distances along the points of
`kinematics.sensor_path`.
"""

from pydrake.systems.framework import Context, DiscreteValues, LeafSystem

from soft_gripper.sensors.sensor_layout import SensorLayout, extension_ratios
from soft_gripper.signals import describe


class StrainSensor(LeafSystem):
    """Samples the joints of one finger and reads the strain sensors along its sides.

    ::

        joint_angles (N) rad ---> +--------------+ ---> extension_ratio  (paths * S) length over rest length
                                  | StrainSensor | ---> strain           (paths * S) readings
                                  +--------------+

    Readings run path after path (inner, outer; only outer when one-sided), from the
    base to the tip. The outputs hold their values between samples.
    """

    def __init__(self, layout: SensorLayout, period: float):
        """A sensor of the given layout that samples every `period` s, beginning at initialization."""
        super().__init__()
        self._layout = layout
        self._joint_angles = self.DeclareVectorInputPort("joint_angles", layout.finger.segments)
        for name in ("extension_ratio", "strain"):
            port = self.DeclareStateOutputPort(name, self.DeclareDiscreteState(layout.readings))
            describe(port, "1", path=layout.path_names, section=range(layout.sections))
        self.DeclareInitializationDiscreteUpdateEvent(self._sample)
        self.DeclarePeriodicDiscreteUpdateEvent(period, 0.0, self._sample)

    def _sample(self, context: Context, values: DiscreteValues) -> None:
        ratios = extension_ratios(self._layout, self._joint_angles.Eval(context))
        values.set_value(0, ratios)
        values.set_value(1, self._layout.response.reading(ratios))
