"""Models put in their places: welded to a frame, or free where they begin."""

from pydrake.multibody.plant import MultibodyPlant
from pydrake.multibody.tree import Frame, ModelInstanceIndex, RigidBody

from soft_gripper.diagrams.loading.model_files import load_model
from soft_gripper.diagrams.schema.scenario import ModelConfig
from soft_gripper.errors import InputError
from soft_gripper.fingers.plant_finger import PlantFinger


def add_model(
    plant: MultibodyPlant, config: ModelConfig, where: str, is_arm: bool
) -> tuple[ModelInstanceIndex, list[PlantFinger]]:
    """Loads a model and puts it in its place; returns it and the fingers in it.

    Raises:
        InputError: if its file or a frame that it names is wrong.
    """
    model, fingers = load_model(plant, config, where, is_arm)
    X_PC = config.X_PC.GetDeterministicValue()
    if config.free:
        plant.SetDefaultFloatingBaseBodyPose(first_body(plant, config.name), X_PC)
    else:
        plant.WeldFrames(find_frame(plant, config.parent, where, "parent"), own_frame(plant, config, where), X_PC)
    return model, fingers


def own_frame(plant: MultibodyPlant, config: ModelConfig, where: str) -> Frame:
    """The frame of a model by which it is welded to its parent."""
    if config.child is not None:
        return find_frame(plant, f"{config.name}::{config.child}", where, "child")
    return first_body(plant, config.name).body_frame()


def first_body(plant: MultibodyPlant, model: str) -> RigidBody:
    """The first link of a model."""
    return plant.get_body(plant.GetBodyIndices(plant.GetModelInstanceByName(model))[0])


def find_frame(plant: MultibodyPlant, name: str, where: str, field: str) -> Frame:
    """The frame called "world" or "model::frame".

    Raises:
        InputError: if there is none, naming those of the model.
    """
    if name == "world":
        return plant.world_frame()
    model, _, frame = name.rpartition("::")
    if not model:
        raise InputError(where, field, name, 'write "model::frame", or "world"')
    if not plant.HasModelInstanceNamed(model):
        raise InputError(where, field, name, f"no such frame: no model '{model}' stands before this one")
    instance = plant.GetModelInstanceByName(model)
    if not plant.HasFrameNamed(frame, instance):
        frames = (plant.get_frame(index).name() for index in plant.GetFrameIndices(instance))
        known = ", ".join(name for name in frames if not name.endswith(("_parent", "_child")))  # Drake's, of joints
        raise InputError(where, field, name, f"no such frame; known: {known}")
    return plant.GetFrameByName(frame, instance)
