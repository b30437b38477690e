"""The arm: its home posture, and a plant of its own for planning and for its weight."""

from dataclasses import dataclass

import numpy as np
from pydrake.multibody.plant import MultibodyPlant
from pydrake.multibody.tree import Frame, Joint, ModelInstanceIndex, SpatialInertia

from soft_gripper.arrays import Array
from soft_gripper.diagrams.placing import add_model, find_frame, own_frame
from soft_gripper.diagrams.scenario import ModelConfig, Scenario
from soft_gripper.errors import InputError


@dataclass(frozen=True)
class Arm:
    """An arm that carries a gripper."""

    name: str
    model: ModelInstanceIndex  # in the plant of the station
    plant: MultibodyPlant  # of the arm alone, what it carries being one rigid body
    tool: Frame  # in this plant: the frame by which the gripper is welded
    home: Array  # (n) rad or m


def make_arm(scenario: Scenario, plant: MultibodyPlant) -> Arm:
    """The arm of a scenario, as it stands in the finalized `plant`.

    Raises:
        InputError: if it carries no gripper.
    """
    index = [model.name for model in scenario.models].index(scenario.arm.model)
    config = scenario.models[index]
    carried = carried_models(scenario)
    if not carried:
        raise InputError(
            "arm", "model", config.name, f"carries nothing; weld a gripper to it: parent: {config.name}::..."
        )
    alone = MultibodyPlant(0.0)
    alone.mutable_gravity_field().set_gravity_vector(scenario.gravity)
    add_model(alone, config, f"models[{index}]", is_arm=True)
    gripper = carried[0]
    body = alone.AddRigidBody("payload", alone.AddModelInstance("carried"), _inertia(plant, carried))
    parent = find_frame(alone, gripper.parent, "models", "parent")
    alone.WeldFrames(parent, body.body_frame(), gripper.X_PC.GetDeterministicValue())
    alone.Finalize()
    model = plant.GetModelInstanceByName(config.name)
    return Arm(config.name, model, alone, body.body_frame(), np.array(scenario.arm.home))


def carried_models(scenario: Scenario) -> list[ModelConfig]:
    """The models that the arm carries, itself not among them; the first is welded to the arm."""
    names = [scenario.arm.model]
    for model in scenario.models:
        if model.parent.rpartition("::")[0] in names and not model.free:
            names.append(model.name)
    return [model for model in scenario.models if model.name in names[1:]]


def _inertia(plant: MultibodyPlant, carried: list[ModelConfig]) -> SpatialInertia:
    """All that is carried as one body, about and in the frame by which the gripper is welded."""
    bodies = [index for model in carried for index in plant.GetBodyIndices(plant.GetModelInstanceByName(model.name))]
    frame = own_frame(plant, carried[0], "models")
    return plant.CalcSpatialInertia(plant.CreateDefaultContext(), frame, bodies)


def take_home(plant: MultibodyPlant, scenario: Scenario) -> None:
    """Makes the home posture of the arm, if there is one, its default.

    Raises:
        InputError: if there is no such model, or the posture does not fit its joints.
    """
    arm = scenario.arm
    if not arm.model:
        return
    if not plant.HasModelInstanceNamed(arm.model):
        raise InputError("arm", "model", arm.model, "is none of the models")
    joints = arm_joints(plant, plant.GetModelInstanceByName(arm.model))
    if len(arm.home) != len(joints):
        raise InputError("arm", "home", arm.home, f"give a position for each of: {', '.join(j.name() for j in joints)}")
    for joint, position in zip(joints, arm.home, strict=True):
        (low,), (high,) = joint.position_lower_limits(), joint.position_upper_limits()
        if not low <= position <= high:
            expected = f"give a position within its limits, {low:g} to {high:g}"
            raise InputError("arm.home", joint.name(), position, expected)
        joint.set_default_positions([position])


def arm_joints(plant: MultibodyPlant, model: ModelInstanceIndex) -> list[Joint]:
    """The movable joints of a model, each of one degree of freedom, in the order of its positions.

    Raises:
        InputError: if a joint has more than one degree of freedom.
    """
    joints = [plant.get_joint(index) for index in plant.GetJointIndices(model)]
    for joint in joints:
        if joint.num_positions() > 1:
            raise InputError("arm", "joint", joint.name(), "has several degrees of freedom; an arm's joints have one")
    return sorted((j for j in joints if j.num_positions()), key=lambda joint: joint.position_start())
