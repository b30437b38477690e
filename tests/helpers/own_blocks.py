"""A sensor and an estimator as a user writes them, named in scenarios as "own_blocks:..."."""

import numpy as np
from pydrake.systems.framework import LeafSystem, System

from soft_gripper.arrays import Array
from soft_gripper.estimators.arcs import arcs_from_readings
from soft_gripper.estimators.contact import ContactShape
from soft_gripper.estimators.shape_estimator import ShapeEstimator
from soft_gripper.estimators.uncertainty import EXACT, Uncertainty
from soft_gripper.sensors.sensor_layout import SensorLayout, extension_ratios
from soft_gripper.signals import describe

WARMTH = 1e-3  # reading, for every pascal in the chamber


class WarmSensor(LeafSystem):
    """Reads the strain, and puts out the warmth of the chamber beside it."""

    def __init__(self, layout: SensorLayout, period: float):
        super().__init__()
        self._layout = layout
        self._angles = self.DeclareVectorInputPort("joint_angles", layout.finger.segments)
        self._pressure = self.DeclareVectorInputPort("pressure", 1)
        strain = self.DeclareStateOutputPort("strain", self.DeclareDiscreteState(layout.readings))
        describe(strain, "1", path=layout.path_names, section=range(layout.sections))
        describe(self.DeclareStateOutputPort("warmth", self.DeclareDiscreteState(1)), "K")
        self.DeclareInitializationDiscreteUpdateEvent(self._sample)
        self.DeclarePeriodicDiscreteUpdateEvent(period, 0.0, self._sample)

    def _sample(self, context, values):
        ratios = extension_ratios(self._layout, self._angles.Eval(context))
        values.set_value(0, self._layout.response.reading(ratios))
        values.set_value(1, WARMTH * self._pressure.Eval(context))


class MeanBend(LeafSystem):
    """Estimates joint angles that are equal within each section, and nothing else."""

    def __init__(self, layout: SensorLayout):
        super().__init__()
        self._layout = layout
        self._strain = self.DeclareVectorInputPort("strain", layout.readings)
        joints = layout.finger.segments
        port = self.DeclareVectorOutputPort("estimated_joint_angles", joints, self._estimate)
        describe(port, "rad", joint=range(joints))

    def _estimate(self, context, output):
        theta = arcs_from_readings(self._layout, self._strain.Eval(context)).theta
        output.SetFromVector(self._layout.shared_equally(theta))


def warm_sensor(layout: SensorLayout, period: float) -> System:
    return WarmSensor(layout, period)


def mean_bend(layout: SensorLayout, gravity: Array, period: float) -> System:
    assert np.shape(gravity) == (3,)
    return MeanBend(layout)


def contact_again(layout: SensorLayout, gravity: Array, period: float) -> System:
    """The function of `contact`, by an exact model, in a block of one's own."""
    return ShapeEstimator(ContactShape(layout, Uncertainty(bend_per_pressure=EXACT)), layout, gravity)


NOT_CALLABLE = 3
