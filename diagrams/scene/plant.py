"""The plant: models put in their places, and the fingers found in them."""

from collections.abc import Sequence
from typing import NamedTuple

from pydrake.geometry import SceneGraph
from pydrake.multibody.plant import AddMultibodyPlant, MultibodyPlant, MultibodyPlantConfig
from pydrake.systems.framework import DiagramBuilder

from soft_gripper.diagrams.loading.drake_reading import drake_reads
from soft_gripper.diagrams.scene.arm_home import set_home_posture
from soft_gripper.diagrams.scene.placing import add_model
from soft_gripper.diagrams.schema.scenario import ArmConfig, ModelConfig
from soft_gripper.errors import InputError
from soft_gripper.fingers.plant_finger import PlantFinger


class Scene(NamedTuple):
    """What is simulated."""

    plant: MultibodyPlant
    scene_graph: SceneGraph
    fingers: list[PlantFinger]


def add_plant(
    builder: DiagramBuilder,
    config: MultibodyPlantConfig,
    models: Sequence[ModelConfig],
    gravity: Sequence[float],
    arm: ArmConfig | None = None,
) -> Scene:
    """Adds a finalized plant named "plant" and its SceneGraph, with all models in their places.

    Args:
        builder: of the diagram.
        config: of the plant, Drake's own.
        models: in an order in which each is welded to one before it.
        gravity: in the world, (3,) m/s^2.
        arm: which of the models is an arm, and the posture in which it begins.

    Raises:
        InputError: if a model or a finger in it is wrong.
    """
    plant, scene_graph = AddMultibodyPlant(config, builder)
    plant.mutable_gravity_field().set_gravity_vector(gravity)
    fingers: list[PlantFinger] = []
    for i, model in enumerate(models):
        where = f"models[{i}]"
        _, found = add_model(plant, model, where, is_arm=arm is not None and model.name == arm.model)
        if model.free and found:
            raise InputError(where, "free", True, "fingers need a base that is welded")
        fingers += found
    with drake_reads("models", "file", [model.file for model in models]):
        plant.Finalize()
    if arm is not None:
        set_home_posture(plant, arm)
    return Scene(plant, scene_graph, fingers)
