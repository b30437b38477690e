"""The arm: a plant of its own for planning and for its weight.

Planning and gravity compensation use a plant of the arm alone (`Arm.plant`), in which the gripper is one rigid body.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from pydrake.common.schema import Transform
from pydrake.multibody.plant import MultibodyPlant
from pydrake.multibody.tree import Frame, ModelInstanceIndex, SpatialInertia

from soft_gripper.arrays import Array
from soft_gripper.diagrams.scene import add_model, find_frame, own_frame
from soft_gripper.errors import InputError
from soft_gripper.fingers.plant_finger import PlantFinger
from soft_gripper.scenario.scenario import ArmConfig, ModelConfig


@dataclass(frozen=True)
class Arm:
    """An arm that carries a gripper."""

    name: str
    model: ModelInstanceIndex  # in the plant of the station
    plant: MultibodyPlant  # of the arm alone, what it carries being one rigid body
    tool: Frame  # in this plant: the frame by which the gripper is welded
    tool_model: ModelConfig  # what is welded by it
    config: ArmConfig

    @property
    def home(self) -> Array:
        """The posture in which it begins, (n) rad or m."""
        return np.array(self.config.home)


def make_arm(
    plant: MultibodyPlant, models: Sequence[ModelConfig], arm: ArmConfig, fingers: Sequence[PlantFinger] = ()
) -> Arm:
    """The arm among the models of the finalized `plant`.

    Raises:
        InputError: if it does not carry the fingers.
    """
    index = [model.name for model in models].index(arm.model)
    config, gripper = models[index], gripper_model(models, arm.model, fingers)
    alone = MultibodyPlant(0.0)
    alone.mutable_gravity_field().set_gravity_vector(plant.gravity_field().gravity_vector())
    X_WBase = own_frame(plant, config, f"models[{index}]").CalcPoseInWorld(plant.CreateDefaultContext())
    add_model(alone, replace(config, parent="world", X_PC=Transform(X_WBase)), f"models[{index}]", is_arm=True)
    inertia = _inertia(plant, gripper, carried_models(models, arm.model))
    body = alone.AddRigidBody("payload", alone.AddModelInstance("carried"), inertia)
    parent = find_frame(alone, gripper.parent, "models", "parent")
    alone.WeldFrames(parent, body.body_frame(), gripper.X_PC.GetDeterministicValue())
    alone.Finalize()
    model = plant.GetModelInstanceByName(config.name)
    return Arm(config.name, model, alone, body.body_frame(), gripper, arm)


def carried_models(models: Sequence[ModelConfig], arm: str) -> list[ModelConfig]:
    """The models that the arm carries, itself not among them."""
    names = [arm]
    for model in models:
        if model.parent.rpartition("::")[0] in names and not model.free:
            names.append(model.name)
    return [model for model in models if model.name in names[1:]]


def gripper_model(models: Sequence[ModelConfig], arm: str, fingers: Sequence[PlantFinger]) -> ModelConfig:
    """The model, welded to the arm, that is or carries the fingers; without fingers, the first that is carried.

    Raises:
        InputError: if the fingers do not hang on the arm, or on several models that are welded to it.
    """
    of_name = {model.name: model for model in models}
    tips = {finger.model_name for finger in fingers} or {model.name for model in carried_models(models, arm)[:1]}
    welded = set()
    for name in tips:
        while name in of_name and of_name[name].parent.rpartition("::")[0] != arm:
            name = of_name[name].parent.rpartition("::")[0]
        welded.add(name)
    if len(welded) != 1 or not welded <= set(of_name):
        raise InputError("arm", "model", arm, f"does not carry the gripper; weld that to it: parent: {arm}::...")
    return of_name[welded.pop()]


def _inertia(plant: MultibodyPlant, gripper: ModelConfig, carried: Sequence[ModelConfig]) -> SpatialInertia:
    """All that is carried as one body, about and in the frame by which the gripper is welded."""
    bodies = [index for model in carried for index in plant.GetBodyIndices(plant.GetModelInstanceByName(model.name))]
    return plant.CalcSpatialInertia(plant.CreateDefaultContext(), own_frame(plant, gripper, "models"), bodies)
