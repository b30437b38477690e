"""The plant: models put in their places, and the fingers found in them."""

from dataclasses import dataclass

import numpy as np
from pydrake.geometry import SceneGraph
from pydrake.math import RigidTransform
from pydrake.multibody.plant import AddMultibodyPlant, MultibodyPlant
from pydrake.multibody.tree import BodyIndex, Joint, ModelInstanceIndex
from pydrake.systems.framework import DiagramBuilder

from soft_gripper.arrays import Array
from soft_gripper.diagrams.arm_home import take_home
from soft_gripper.diagrams.placing import add_model
from soft_gripper.diagrams.pressure_steps import COMMON
from soft_gripper.diagrams.scenario import Scenario
from soft_gripper.errors import InputError
from soft_gripper.finger import Finger
from soft_gripper.finger_links import joint_name, link_name


@dataclass(frozen=True)
class PlantFinger:
    """A finger in the plant."""

    finger: Finger
    model: ModelInstanceIndex
    model_name: str
    base: BodyIndex  # body whose frame is B
    X_WB: RigidTransform  # base frame in the world, as the simulation begins

    @property
    def name(self) -> str:
        return self.finger.name


def add_plant(builder: DiagramBuilder, scenario: Scenario) -> tuple[MultibodyPlant, SceneGraph, list[PlantFinger]]:
    """Adds a finalized plant named "plant" and its SceneGraph, with all models of the scenario.

    Raises:
        InputError: if a model or a finger in it is wrong, or the time step too long for a finger.
    """
    plant, scene_graph = AddMultibodyPlant(scenario.plant_config, builder)
    plant.mutable_gravity_field().set_gravity_vector(scenario.gravity)
    found: list[tuple[Finger, ModelInstanceIndex]] = []
    for i, model in enumerate(scenario.models):
        where = f"models[{i}]"
        instance, fingers_in_it = add_model(plant, model, where, model.name == scenario.arm.model)
        if model.free and fingers_in_it:
            raise InputError(where, "free", True, "fingers need a base that is welded")
        found += [(finger, instance) for finger in fingers_in_it]
    plant.Finalize()
    take_home(plant, scenario)
    fingers = [_plant_finger(plant, finger, model) for finger, model in found]
    _check_fingers(scenario, fingers)
    return plant, scene_graph, fingers


def _plant_finger(plant: MultibodyPlant, finger: Finger, model: ModelInstanceIndex) -> PlantFinger:
    base = plant.GetBodyByName(link_name(finger.name, 0), model)
    X_WB = plant.EvalBodyPoseInWorld(plant.CreateDefaultContext(), base)
    return PlantFinger(finger, model, plant.GetModelInstanceName(model), base.index(), X_WB)


def _check_fingers(scenario: Scenario, fingers: list[PlantFinger]) -> None:
    names = [finger.name for finger in fingers]
    time_step = scenario.plant_config.time_step
    for name in scenario.pressure.steps:
        if name not in (*names, COMMON):
            raise InputError("pressure.steps", name, "...", f"no such finger; known: {', '.join([*names, COMMON])}")
    for finger in fingers:
        if names.count(finger.name) > 1:
            raise InputError("models", "finger", finger.name, "stands in more than one model")
        limit = finger.finger.stable_time_step()
        if time_step > limit:
            expected = f"longer than stable_time_step() = {limit:.3g} s of finger '{finger.name}'; or 0 for cenic"
            raise InputError("plant_config", "time_step", time_step, expected)


def position_selector(plant: MultibodyPlant, finger: PlantFinger) -> Array:
    """Matrix that picks the joint angles of a finger out of the plant's state, (N, nq + nv)."""
    starts = [joint.position_start() for joint in _joints(plant, finger)]
    return np.eye(plant.num_multibody_states())[starts]


def torque_selector(plant: MultibodyPlant, finger: PlantFinger) -> Array:
    """Matrix that picks the joints of a finger out of its model's generalized forces, (N, model's nv)."""
    of_plant = np.zeros((finger.finger.segments, plant.num_velocities()))
    starts = [joint.velocity_start() for joint in _joints(plant, finger)]
    of_plant[np.arange(len(starts)), starts] = 1.0
    return np.array([plant.GetVelocitiesFromArray(finger.model, row) for row in of_plant])


def _joints(plant: MultibodyPlant, finger: PlantFinger) -> list[Joint]:
    return [plant.GetJointByName(joint_name(finger.name, i), finger.model) for i in range(finger.finger.segments)]
