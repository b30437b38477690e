"""Joint control of the arm: implicit PDs in its actuators, and the torque that carries its weight."""

import numpy as np
from pydrake.multibody.plant import MultibodyPlant
from pydrake.multibody.tree import PdControllerGains
from pydrake.systems.framework import DiagramBuilder, InputPort, OutputPort
from pydrake.systems.primitives import ConstantVectorSource, MatrixGain

from soft_gripper.arrays import Array
from soft_gripper.control.gravity_compensation import GravityCompensation
from soft_gripper.diagrams.manipulation.arm import Arm
from soft_gripper.diagrams.scene import arm_joints
from soft_gripper.errors import InputError
from soft_gripper.scenario.scenario import ArmConfig


def add_home(builder: DiagramBuilder, arm: Arm, desired: InputPort) -> OutputPort:
    """Adds `{arm}.home`, which keeps the arm in its home posture; returns its desired state."""
    home = ConstantVectorSource([*arm.home, *np.zeros(len(arm.home))])
    builder.AddNamedSystem(f"{arm.name}.home", home)
    builder.Connect(home.get_output_port(), desired)
    return home.get_output_port()


def add_arm_control(builder: DiagramBuilder, plant: MultibodyPlant, arm: Arm) -> InputPort:
    """Adds `{arm}.gravity_compensation` and gives every actuator of the arm a PD.

    ::

        desired state ----------------------------> PDs, solved with the plant's own equations
        state of the arm -> GravityCompensation -> actuators, within their effort limits

    The compensation knows the gripper's weight but not that of what it grasps.

    Returns:
        where the desired state goes in, positions and then velocities in the order of the joints, (2 n).
    """
    _check_actuators(plant, arm)
    _set_gains(plant, arm)
    compensation = builder.AddNamedSystem(f"{arm.name}.gravity_compensation", GravityCompensation(arm.plant))
    builder.Connect(plant.get_state_output_port(arm.model), compensation.get_input_port())
    of_actuators = _actuator_rows(plant, arm)
    torque = builder.AddNamedSystem(f"{arm.name}.torque", MatrixGain(of_actuators))
    builder.Connect(compensation.get_output_port(), torque.get_input_port())
    builder.Connect(torque.get_output_port(), plant.get_actuation_input_port(arm.model))
    desired = builder.AddNamedSystem(f"{arm.name}.desired", MatrixGain(np.kron(_folded(arm.config), of_actuators)))
    builder.Connect(desired.get_output_port(), plant.get_desired_state_input_port(arm.model))
    return desired.get_input_port()


def _check_actuators(plant: MultibodyPlant, arm: Arm) -> None:
    driven = [plant.get_joint_actuator(i).joint().name() for i in plant.GetJointActuatorIndices(arm.model)]
    for joint in arm_joints(plant, arm.model):
        if joint.name() not in driven:
            expected = "has no actuator; give it an effort limit above 0, in a URDF also a <transmission>"
            raise InputError(f"arm '{arm.name}'", "joint", joint.name(), expected)


def _set_gains(plant: MultibodyPlant, arm: Arm) -> None:
    """Gains of a joint for the wanted frequency, from the inertia that it moves in the home posture."""
    context = arm.plant.CreateDefaultContext()
    arm.plant.SetPositions(context, arm.home)
    inertia = np.diag(arm.plant.CalcMassMatrix(context))
    angular_frequency, ratio = 2 * np.pi * arm.config.frequency, arm.config.damping_ratio  # rad/s, 1
    gains = {
        joint.name(): PdControllerGains(p=moment * angular_frequency**2, d=2 * ratio * moment * angular_frequency)
        for joint, moment in zip(arm_joints(plant, arm.model), inertia, strict=True)
    }
    for index in plant.GetJointActuatorIndices(arm.model):
        actuator = plant.get_joint_actuator(index)
        actuator.set_controller_gains(gains[actuator.joint().name()])


def _folded(arm: ArmConfig) -> Array:
    """Matrix from a wanted position and velocity to a position alone that a PD answers with the same torque.

    Drake's cenic (1.51 and 1.58) takes a wanted velocity with the wrong sign; so it is wanted to be zero.
    """
    angular_frequency = 2 * np.pi * arm.frequency
    return np.array([[1.0, 2 * arm.damping_ratio / angular_frequency], [0.0, 0.0]])


def _actuator_rows(plant: MultibodyPlant, arm: Arm) -> Array:
    """Matrix from the order of the joints to that of the actuators, (n, n)."""
    names = [joint.name() for joint in arm_joints(plant, arm.model)]
    actuators = (plant.get_joint_actuator(index) for index in plant.GetJointActuatorIndices(arm.model))
    return np.eye(len(names))[[names.index(actuator.joint().name()) for actuator in actuators]]
