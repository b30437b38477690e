"""StrainSensor: the only block that samples; all that follows it is stateless."""

from pydrake.systems.framework import Context, DiscreteValues, LeafSystem

from soft_gripper.sensor_layout import SensorLayout, extension_ratios


class StrainSensor(LeafSystem):
    """Samples the joints of one finger and reads the strain sensors along its sides.

                      +--------------+
    joint_angles ---> |              | ---> sampled_joint_angles  (N) rad, the truth behind the readings
                      | StrainSensor | ---> extension_ratio       (paths * S) length over rest length
                      |              | ---> strain                (paths * S) readings
                      +--------------+

    `joint_angles` (N,) rad. Readings run path after path (inner, outer; only outer when one-sided), from the
    base to the tip. The outputs hold their values between samples.
    """

    def __init__(self, layout: SensorLayout, period: float):
        """A sensor of the given layout that samples every `period` s, beginning at initialization."""
        super().__init__()
        self._layout = layout
        joints, readings = layout.finger.segments, layout.readings
        self._joint_angles = self.DeclareVectorInputPort("joint_angles", joints)
        for name, size in (
            ("sampled_joint_angles", joints),
            ("extension_ratio", readings),
            ("strain", readings),
        ):
            self.DeclareStateOutputPort(name, self.DeclareDiscreteState(size))
        self.DeclareInitializationDiscreteUpdateEvent(self._sample)
        self.DeclarePeriodicDiscreteUpdateEvent(period, 0.0, self._sample)

    def _sample(self, context: Context, values: DiscreteValues) -> None:
        q = self._joint_angles.Eval(context)
        ratios = extension_ratios(self._layout, q)
        values.set_value(0, q)
        values.set_value(1, ratios)
        values.set_value(2, self._layout.response.reading(ratios))
