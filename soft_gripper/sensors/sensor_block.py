"""SensorBlock: samples the joints of a finger and reads its sensors."""

from pydrake.systems.framework import Context, DiscreteValues, LeafSystem

from soft_gripper.sensors.measurement import MeasurementModel
from soft_gripper.signals import describe


class SensorBlock(LeafSystem):
    """Samples the joints of one finger and outputs its sensor readings.

    ::

        joint_angles (N) rad ---> +-------------+ ---> extension_ratio  (R) length over rest length, of strain sensors
                                  | SensorBlock | ---> strain           (R) readings; of other sensors `curvature`,
                                  +-------------+                           or whatever they measure

    Readings of strain sensors run path after path (inner, outer; only outer when one-sided), from the base to the tip.
    The outputs hold their values between samples.
    """

    def __init__(self, layout: MeasurementModel, period: float):
        """Samples the sensors every `period` s, beginning at initialization."""
        super().__init__()
        self._layout = layout
        self._joint_angles = self.DeclareVectorInputPort("joint_angles", layout.finger.segments)
        for name in layout.signals(layout.straight):
            port = self.DeclareStateOutputPort(name, self.DeclareDiscreteState(layout.readings))
            describe(port, layout.unit, **layout.axes)
        self.DeclareInitializationDiscreteUpdateEvent(self._sample)
        self.DeclarePeriodicDiscreteUpdateEvent(period, 0.0, self._sample)

    def _sample(self, context: Context, values: DiscreteValues) -> None:
        for i, signal in enumerate(self._layout.signals(self._joint_angles.Eval(context)).values()):
            values.set_value(i, signal)
