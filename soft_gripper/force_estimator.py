"""ForceEstimator: pose and pressure -> external torque at every joint."""

from pydrake.common.value import AbstractValue
from pydrake.math import RigidTransform
from pydrake.systems.framework import BasicVector, Context, LeafSystem

from soft_gripper.arrays import Array
from soft_gripper.external_torque import external_torque, free_bending_angles
from soft_gripper.sensor_layout import SensorLayout


class ForceEstimator(LeafSystem):
    """Feels what bends one finger besides its pressure (paper, II.D).

    theta (S) rad ------> +----------------+
    pressure (1) Pa ----> | ForceEstimator | ---> free_bending_angles  (N) rad, under the pressure alone
    X_WB ---------------> |                | ---> external_torque      (N) N m, positive where it closes
                          +----------------+

    This is torque at the joints, not contact force. Weight is compensated with the known orientation of the
    base; without compensation it is read as an external torque. Reads NaN while any
    section of `theta` is NaN. Stateless: give it inputs that are sampled together.
    """

    def __init__(self, layout: SensorLayout, gravity: Array):
        """A finger of the given sensors; `gravity` in the world, (3,) m/s^2, or zero for no compensation."""
        super().__init__()
        self._layout, self._gravity = layout, gravity
        self._theta = self.DeclareVectorInputPort("theta", layout.sections)
        self._pressure = self.DeclareVectorInputPort("pressure", 1)
        self._X_WB = self.DeclareAbstractInputPort("X_WB", AbstractValue.Make(RigidTransform()))
        joints = layout.finger.segments
        pressure, inputs = {self._pressure.ticket()}, {self.all_input_ports_ticket()}
        self.DeclareVectorOutputPort("free_bending_angles", joints, self._calc_free_bending, pressure)
        self.DeclareVectorOutputPort("external_torque", joints, self._calc_external_torque, inputs)

    def _calc_free_bending(self, context: Context, output: BasicVector) -> None:
        pressure = self._pressure.Eval(context)
        output.SetFromVector(free_bending_angles(self._layout.finger, pressure[0]))

    def _calc_external_torque(self, context: Context, output: BasicVector) -> None:
        x, _, z = self._X_WB.Eval(context).rotation().matrix().T @ self._gravity
        theta, pressure = self._theta.Eval(context), self._pressure.Eval(context)
        output.SetFromVector(external_torque(self._layout, theta, pressure[0], z + 1j * x))
