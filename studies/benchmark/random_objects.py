"""Random objects of four shapes between two fingers, and sensors with errors that read the fingers again."""

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
DRAWS = 8  # of the sensors of a grasp, if they have errors
SENSORS = 1  # separates the random numbers of the sensors from those of the object
OFFSET = 3.0  # mm, from the middle between the fingers, along x and along y
YAW = 20.0  # degrees
MASS = (20.0, 60.0)  # g
FRICTION = (0.5, 0.9)
SIZE = 15  # percent of the mesh's size, rounded, so that few scaled meshes fill the cache
SAMPLES = 5  # at the end of a step, whose mean counts


def draw(seed: int, set: str, number: int, shape: str, most_yaw: float = YAW, most_size: int = SIZE) -> RandomObject:
    """The random parameters of a grasp, uniformly distributed and independent of other grasps."""
    rng = np.random.default_rng([seed, SETS.index(set), number, *shape.encode()])
    x, y, yaw = rng.uniform(-1.0, 1.0, 3) * (OFFSET, OFFSET, most_yaw)
    size = 1 + rng.integers(-most_size, most_size, endpoint=True) / 100
    return RandomObject(*map(float, (x, y, yaw, rng.uniform(*MASS), rng.uniform(*FRICTION), size)))


def with_errors(again: ReadAgain, errors: StrainErrors, rng: np.random.Generator) -> list[ReadAgain]:
    """A finger read again by DRAWS sets of sensors."""
    response = again.layout.response
    ratios = np.repeat(response.ratio(again.readings)[:, None], DRAWS, axis=1)
    readings = response.reading(disturb(errors, ratios, again.period, rng))
    return [replace(again, readings=each) for each in np.moveaxis(readings, 1, 0)]


def with_object(scenario: Scenario, shape: str, drawn: RandomObject) -> Scenario:
    """The scenario with another object, in the place of its own and at the same height.

    Raises:
        InputError: unless exactly one model is free.
    """
    return with_mesh(scenario, SHAPES[shape], SCALES.get(shape, 1.0), drawn)


def with_mesh(scenario: Scenario, file: str, scale: float, drawn: RandomObject) -> Scenario:
    """The scenario with the mesh of a file as its object; raises as `with_object`."""
    found = deepcopy(scenario)
    model = free_model(found)
    X_WO = model.X_PC.GetDeterministicValue()
    height = X_WO.translation()[2] + model.mesh.scale * lowest(model.file, X_WO.rotation())
    turn = RotationMatrix.MakeZRotation(np.radians(drawn.yaw_deg))
    x, y, _ = X_WO.translation() + 1e-3 * np.array([drawn.x_mm, drawn.y_mm, 0.0])
    model.file, model.mesh.scale = file, drawn.size * scale
    model.mass, model.friction = 1e-3 * drawn.mass_g, drawn.friction
    model.X_PC = Transform(RigidTransform(turn, [x, y, height - model.mesh.scale * lowest(model.file, turn)]))
    return found


def free_model(scenario: Scenario) -> ModelConfig:
    """The object that is grasped; raises as `with_object`."""
    free = [model for model in scenario.models if model.free]
    if len(free) != 1:
        raise InputError("grasp", "models", [model.name for model in free], "give one free model, the object")
    return free[0]


def lowest(file: str, rotation: RotationMatrix) -> float:
    """Height of the lowest point of a mesh file, turned, over its frame, in its unit.

    Raises:
        InputError: if it is not a mesh file.
    """
    vertices = read_scene(model_path(file)).convex_hull.vertices
    return float(np.min(vertices @ rotation.matrix()[2]))
