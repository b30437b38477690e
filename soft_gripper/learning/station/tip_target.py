"""TipTarget: a point that swings along what the tip of a finger can reach."""

import numpy as np
from pydrake.systems.framework import BasicVector, Context, DiagramBuilder, LeafSystem

from soft_gripper.arrays import Array
from soft_gripper.estimators.plane import planar_gravity
from soft_gripper.fingers.finger import Finger
from soft_gripper.fingers.kinematics import as_points, forward_kinematics
from soft_gripper.fingers.plant_finger import PlantFinger
from soft_gripper.fingers.statics import resting_angles

_GRID = 64  # pressures between which the tip is interpolated


def resting_tip(finger: Finger, pressure: Array, gravity: complex) -> Array:
    """Where the tip rests under pressures (M) Pa, (M, 2) x, z in B, m; `gravity` in the bending plane, m/s^2."""
    q = resting_angles(finger, pressure, np.full(len(pressure), gravity))
    tips: Array = as_points(forward_kinematics(q, finger.segment_length).tip)
    return tips


class TipTarget(LeafSystem):
    """Where the tip is to be: where it would rest under a pressure that swings as a sine.

    ::

        +-----------+ ---> target (2) x, z in B, m
        | TipTarget |
        +-----------+

    The mean and the amplitude of the pressure, Pa, the period, s, and the phase, rad, are parameters in the context.
    """

    def __init__(self, finger: Finger, gravity: complex, limits: tuple[float, float]):
        """`gravity` in the bending plane, m/s^2; `limits` of the pressure, Pa."""
        super().__init__()
        self._pressures = np.linspace(*limits, _GRID)
        self._tips = resting_tip(finger, self._pressures, gravity)
        self._swing = self.DeclareNumericParameter(BasicVector([sum(limits) / 2, 0.0, 1.0, 0.0]))
        followed = {self.time_ticket(), self.pn_ticket()}
        self.DeclareVectorOutputPort("target", 2, self._calc, followed)

    def swing(self, context: Context, mean: float, amplitude: float, period: float, phase: float) -> None:
        """Sets how it swings in its own context."""
        context.get_mutable_numeric_parameter(self._swing).SetFromVector([mean, amplitude, period, phase])

    def _calc(self, context: Context, output: BasicVector) -> None:
        mean, amplitude, period, phase = context.get_numeric_parameter(self._swing).value()
        pressure = mean + amplitude * np.sin(2 * np.pi * context.get_time() / period + phase)
        output.SetFromVector([np.interp(pressure, self._pressures, column) for column in self._tips.T])


def add_tip_target(builder: DiagramBuilder, finger: PlantFinger, limits: tuple[float, float]) -> TipTarget:
    """Adds `target` for a finger that stands still."""
    gravity = np.array(finger.plant.gravity_field().gravity_vector())
    planar = complex(planar_gravity(finger.X_WB.GetAsMatrix34(), gravity))
    return builder.AddNamedSystem("target", TipTarget(finger.finger, planar, limits))
