"""Draws random objects of four shapes, puts them between two fingers, and reads these by sensors with errors."""

from copy import deepcopy
from dataclasses import replace

import numpy as np
from pydrake.common.schema import Transform
from pydrake.math import RigidTransform, RotationMatrix

from soft_gripper.errors import InputError
from soft_gripper.extras.grasps.trial import RandomObject
from soft_gripper.model_import.mesh_files import read_scene
from soft_gripper.runs.scores.readings import ReadAgain
from soft_gripper.scenario.model_files import model_path
from soft_gripper.scenario.schema import ModelConfig, Scenario
from soft_gripper.sensors.strain_errors import StrainErrors, disturb

SHAPES = {shape: f"package://soft_gripper/objects/{shape}.obj" for shape in ("sphere", "cylinder", "box", "irregular")}
SCALES = {"irregular": 0.7}  # of the meshes whose width differs from that of the others
SETS = ("train", "test")
SENSOR_DRAWS = 8  # of the sensors of a grasp, if they have errors
SENSOR_STREAM = 1  # separates the random numbers of the sensors from those of the object
MAX_OFFSET = 3.0  # mm, from the middle between the fingers, along x and along y
MAX_YAW = 20.0  # degrees
MASS_RANGE = (20.0, 60.0)  # g
FRICTION_RANGE = (0.5, 0.9)
MAX_SIZE = 15  # percent of the mesh's size, rounded, so that few scaled meshes fill the cache
MEAN_SAMPLES = 5  # samples at the end of a step whose mean counts


def draw(
    seed: int, set: str, number: int, shape: str, max_yaw: float = MAX_YAW, max_size: int = MAX_SIZE
) -> RandomObject:
    """Draws the parameters of a grasp, uniformly distributed and independent of other grasps."""
    rng = np.random.default_rng([seed, SETS.index(set), number, *shape.encode()])
    x, y, yaw = rng.uniform(-1.0, 1.0, 3) * (MAX_OFFSET, MAX_OFFSET, max_yaw)
    size = 1 + rng.integers(-max_size, max_size, endpoint=True) / 100
    return RandomObject(*map(float, (x, y, yaw, rng.uniform(*MASS_RANGE), rng.uniform(*FRICTION_RANGE), size)))


def disturb_readings(undisturbed: ReadAgain, errors: StrainErrors, rng: np.random.Generator) -> list[ReadAgain]:
    """Readings of a finger by SENSOR_DRAWS sets of sensors with errors."""
    response = undisturbed.layout.response
    ratios = np.repeat(response.ratio(undisturbed.readings)[:, None], SENSOR_DRAWS, axis=1)
    readings = response.reading(disturb(errors, ratios, undisturbed.period, rng))
    return [replace(undisturbed, readings=sensor_readings) for sensor_readings in np.moveaxis(readings, 1, 0)]


def replace_object(scenario: Scenario, shape: str, draw: RandomObject) -> Scenario:
    """Copy of a scenario with a drawn object, at the drawn position and the object's height.

    Raises:
        InputError: unless exactly one model is free.
    """
    return replace_mesh(scenario, SHAPES[shape], SCALES.get(shape, 1.0), draw)


def replace_mesh(scenario: Scenario, file: str, scale: float, draw: RandomObject) -> Scenario:
    """Copy of a scenario with the mesh of a file as its object; raises as `replace_object`."""
    changed = deepcopy(scenario)
    model = free_model(changed)
    X_WO = model.X_PC.GetDeterministicValue()
    height = X_WO.translation()[2] + model.mesh.scale * lowest_height(model.file, X_WO.rotation())
    turn = RotationMatrix.MakeZRotation(np.radians(draw.yaw_deg))
    x, y, _ = X_WO.translation() + 1e-3 * np.array([draw.x_mm, draw.y_mm, 0.0])
    model.file, model.mesh.scale = file, draw.size * scale
    model.mass, model.friction = 1e-3 * draw.mass_g, draw.friction
    model.X_PC = Transform(RigidTransform(turn, [x, y, height - model.mesh.scale * lowest_height(model.file, turn)]))
    return changed


def free_model(scenario: Scenario) -> ModelConfig:
    """Grasped object; raises as `replace_object`."""
    free_models = [model for model in scenario.models if model.free]
    if len(free_models) != 1:
        raise InputError("grasp", "models", [model.name for model in free_models], "give one free model, the object")
    return free_models[0]


def lowest_height(file: str, rotation: RotationMatrix) -> float:
    """Height of the lowest_height point of a mesh file, turned, over its frame, in its unit.

    Raises:
        InputError: if it is not a mesh file.
    """
    vertices = read_scene(model_path(file)).convex_hull.vertices
    return float(np.min(vertices @ rotation.matrix()[2]))
