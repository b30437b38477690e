"""Joint control of the arm: implicit PDs in its actuators, and the torque that carries its weight."""

from collections.abc import Sequence

import numpy as np
from pydrake.multibody.plant import MultibodyPlant
from pydrake.multibody.tree import PdControllerGains
from pydrake.systems.framework import DiagramBuilder, InputPort
from pydrake.systems.primitives import ConstantVectorSource, MatrixGain

from soft_gripper.arrays import Array
from soft_gripper.diagrams.arm_home import arm_joints
from soft_gripper.diagrams.manipulation.arm import Arm, make_arm
from soft_gripper.diagrams.plant import PlantFinger
from soft_gripper.diagrams.scenario import Scenario
from soft_gripper.errors import InputError
from soft_gripper.gravity_compensation import GravityCompensation


def add_arm_at_home(
    builder: DiagramBuilder, scenario: Scenario, plant: MultibodyPlant, fingers: Sequence[PlantFinger]
) -> None:
    """Adds the control of an arm that stays in its home posture."""
    desired = add_arm_control(builder, scenario, plant, make_arm(scenario, plant, fingers))
    home = ConstantVectorSource([*scenario.arm.home, *np.zeros(len(scenario.arm.home))])
    builder.AddNamedSystem(f"{scenario.arm.model}.home", home)
    builder.Connect(home.get_output_port(), desired)


def add_arm_control(builder: DiagramBuilder, scenario: Scenario, plant: MultibodyPlant, arm: Arm) -> InputPort:
    """Adds `{arm}.gravity_compensation` and gives every actuator of the arm a PD.

        desired state ----------------------------> PDs, solved with the plant's own equations
        state of the arm -> GravityCompensation -> actuators, within their effort limits

    The compensation knows the gripper's weight but not that of what it grasps.

    Returns:
        where the desired state goes in, positions and then velocities in the order of the joints, (2 n).
    """
    _check_actuators(plant, arm)
    _set_gains(scenario, plant, arm)
    compensation = builder.AddNamedSystem(f"{arm.name}.gravity_compensation", GravityCompensation(arm.plant))
    builder.Connect(plant.get_state_output_port(arm.model), compensation.get_input_port())
    of_actuators = _actuator_rows(plant, arm)
    torque = builder.AddNamedSystem(f"{arm.name}.torque", MatrixGain(of_actuators))
    builder.Connect(compensation.get_output_port(), torque.get_input_port())
    builder.Connect(torque.get_output_port(), plant.get_actuation_input_port(arm.model))
    desired = builder.AddNamedSystem(f"{arm.name}.desired", MatrixGain(np.kron(_folded(scenario), of_actuators)))
    builder.Connect(desired.get_output_port(), plant.get_desired_state_input_port(arm.model))
    return desired.get_input_port()


def _check_actuators(plant: MultibodyPlant, arm: Arm) -> None:
    driven = [plant.get_joint_actuator(i).joint().name() for i in plant.GetJointActuatorIndices(arm.model)]
    for joint in arm_joints(plant, arm.model):
        if joint.name() not in driven:
            expected = "has no actuator; give it an effort limit above 0, in a URDF also a <transmission>"
            raise InputError(f"arm '{arm.name}'", "joint", joint.name(), expected)


def _set_gains(scenario: Scenario, plant: MultibodyPlant, arm: Arm) -> None:
    """Gains of a joint for the wanted frequency, from the inertia that it moves in the home posture."""
    context = arm.plant.CreateDefaultContext()
    arm.plant.SetPositions(context, arm.home)
    inertia = np.diag(arm.plant.CalcMassMatrix(context))
    pulsation = 2 * np.pi * scenario.arm.frequency
    gains = {
        joint.name(): PdControllerGains(p=moment * pulsation**2, d=2 * scenario.arm.damping_ratio * moment * pulsation)
        for joint, moment in zip(arm_joints(plant, arm.model), inertia, strict=True)
    }
    for index in plant.GetJointActuatorIndices(arm.model):
        actuator = plant.get_joint_actuator(index)
        actuator.set_controller_gains(gains[actuator.joint().name()])


def _folded(scenario: Scenario) -> Array:
    """Matrix from a wanted position and velocity to a position alone that a PD answers with the same torque.

    Drake's cenic (1.51 and 1.58) takes a wanted velocity with the wrong sign; so it is wanted to be zero.
    """
    pulsation = 2 * np.pi * scenario.arm.frequency
    return np.array([[1.0, 2 * scenario.arm.damping_ratio / pulsation], [0.0, 0.0]])


def _actuator_rows(plant: MultibodyPlant, arm: Arm) -> Array:
    """Matrix from the order of the joints to that of the actuators, (n, n)."""
    names = [joint.name() for joint in arm_joints(plant, arm.model)]
    actuators = (plant.get_joint_actuator(index) for index in plant.GetJointActuatorIndices(arm.model))
    return np.eye(len(names))[[names.index(actuator.joint().name()) for actuator in actuators]]
