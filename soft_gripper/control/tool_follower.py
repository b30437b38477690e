"""ToolFollower: a desired pose of an arm's tool -> the desired state of its joints."""

import numpy as np
from pydrake.common.value import AbstractValue
from pydrake.math import RigidTransform
from pydrake.multibody.inverse_kinematics import (
    DifferentialInverseKinematicsParameters,
    DifferentialInverseKinematicsStatus,
    DoDifferentialInverseKinematics,
)
from pydrake.multibody.plant import MultibodyPlant
from pydrake.multibody.tree import Frame
from pydrake.systems.framework import Context, DiscreteValues, LeafSystem

from soft_gripper.arrays import Array
from soft_gripper.control.arm_motion import ArmLimits

GAIN = 4.0  # 1/s, tool velocity over its distance from the desired pose
_FAR = 1e3  # rad, m and per second, instead of no limit


class ToolFollower(LeafSystem):
    """Lets the joints of an arm take its tool to a pose, within their limits of position, velocity and acceleration.

    ::

        X_WTool ------------> +--------------+
                              | ToolFollower | ---> desired_state  (2 n) positions, then velocities, of the joints
        robot_state (2 n) --> +--------------+

    At every sample the desired tool velocity is GAIN times its error, turning and shifting evenly; Drake's
    DoDifferentialInverseKinematics finds the joint velocities that come nearest to that in the same direction. Where
    there are none, as when the target jumps aside in full motion, the joints brake. `robot_state` is read once, as the
    simulation begins.
    """

    def __init__(self, arm: MultibodyPlant, tool: Frame, limits: ArmLimits, period: float):
        """`arm` is a finalized plant of the arm alone, with `tool` in it; samples every `period` s."""
        super().__init__()
        n = arm.num_positions()
        self._arm, self._tool, self._period = arm, tool, period
        self._scratch, self._brake = arm.CreateDefaultContext(), limits.acceleration * period
        self._parameters = _parameters(limits, n, period)
        self._target = self.DeclareAbstractInputPort("X_WTool", AbstractValue.Make(RigidTransform()))
        self._robot_state = self.DeclareVectorInputPort("robot_state", 2 * n)
        self.DeclareStateOutputPort("desired_state", self.DeclareDiscreteState(2 * n))
        self.DeclareInitializationDiscreteUpdateEvent(self._begin)
        self.DeclarePeriodicDiscreteUpdateEvent(period, 0.0, self._update)

    def _begin(self, context: Context, values: DiscreteValues) -> None:
        positions, velocities = np.split(self._robot_state.Eval(context), 2)
        values.set_value(np.concatenate([positions, np.zeros_like(velocities)]))

    def _update(self, context: Context, values: DiscreteValues) -> None:
        state = context.get_discrete_state_vector().value()
        self._arm.SetPositionsAndVelocities(self._scratch, state)
        positions, velocities = np.split(state, 2)
        missing = GAIN * self._missing(self._target.Eval(context))
        found = DoDifferentialInverseKinematics(self._arm, self._scratch, missing, self._tool, self._parameters)
        if found.status == DifferentialInverseKinematicsStatus.kNoSolutionFound:
            velocity = velocities - np.clip(velocities, -self._brake, self._brake)
        else:
            velocity = found.joint_velocities
        values.set_value(np.concatenate([positions + self._period * velocity, velocity]))

    def _missing(self, X_WGoal: RigidTransform) -> Array:
        """The rotation and translation to the desired pose of the tool, rad and m in the world, (6,)."""
        X_WTool = self._tool.CalcPoseInWorld(self._scratch)
        turn = (X_WGoal.rotation() @ X_WTool.rotation().inverse()).ToAngleAxis()
        return np.concatenate([turn.angle() * turn.axis(), X_WGoal.translation() - X_WTool.translation()])


def _parameters(limits: ArmLimits, n: int, period: float) -> DifferentialInverseKinematicsParameters:
    parameters = DifferentialInverseKinematicsParameters(n, n)
    lower, upper, velocity = (np.clip(limit, -_FAR, _FAR) for limit in (limits.lower, limits.upper, limits.velocity))
    parameters.set_time_step(period)
    parameters.set_joint_position_limits((lower, upper))
    parameters.set_joint_velocity_limits((-velocity, velocity))
    parameters.set_joint_acceleration_limits((-limits.acceleration, limits.acceleration))
    return parameters
