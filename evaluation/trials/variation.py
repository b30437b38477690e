"""A scenario varied at random: where its object stands, how heavy, how slippery and how large it is."""

from copy import deepcopy
from dataclasses import dataclass

import numpy as np
from pydrake.common.schema import Transform
from pydrake.math import RigidTransform, RotationMatrix

from soft_gripper.arrays import Array
from soft_gripper.diagrams.loading.mesh_cache import read_scene
from soft_gripper.diagrams.loading.mesh_object import MESH_SUFFIXES
from soft_gripper.diagrams.loading.model_files import model_path
from soft_gripper.diagrams.schema.scenario import ModelConfig, Scenario
from soft_gripper.errors import InputError

OFFSET = 30.0  # mm, from where the scenario puts the object, along x and along y
YAW = 45.0  # degrees, about its own z axis, from the scenario's
MASS = (20.0, 60.0)  # g
FRICTION = (0.5, 0.9)
SIZE = 0.1  # of the scenario's


@dataclass(frozen=True)
class Variation:
    """How a trial differs from its scenario: a shift and a turn, a mass, a friction, and a factor of the size."""

    x_mm: float
    y_mm: float
    yaw_deg: float
    mass_g: float
    friction: float
    size: float


def random_numbers(seed: int, scenario: str, trial: int) -> np.random.Generator:
    """The random numbers of one trial, whatever other trials there are."""
    return np.random.default_rng([seed, trial, *scenario.encode()])


def draw(rng: np.random.Generator) -> Variation:
    """A variation, every part of it evenly distributed."""
    x, y, yaw = rng.uniform(-1.0, 1.0, 3) * (OFFSET, OFFSET, YAW)
    others = (rng.uniform(*MASS), rng.uniform(*FRICTION), rng.uniform(1 - SIZE, 1 + SIZE))
    return Variation(*map(float, (x, y, yaw, *others)))


def vary(scenario: Scenario, rng: np.random.Generator) -> tuple[Scenario, Variation]:
    """A random variation of a scenario, and what was drawn; see `varied`."""
    variation = draw(rng)
    return varied(scenario, variation), variation


def varied(scenario: Scenario, variation: Variation) -> Scenario:
    """The scenario with another object. Its lowest point keeps its height, where it begins and at the goal.

    Raises:
        InputError: if the object of the task is no bare mesh.
    """
    found = deepcopy(scenario)
    model, task = _object(found), found.task
    assert task is not None
    vertices, growth = read_scene(model_path(model.file)).convex_hull.vertices, (variation.size - 1) * model.mesh.scale
    begin, goal = (_lifted(X.GetDeterministicValue(), vertices, growth) for X in (model.X_PC, task.X_WGoal))
    turn = RotationMatrix.MakeZRotation(np.radians(variation.yaw_deg))
    place = begin.translation() + 1e-3 * np.array([variation.x_mm, variation.y_mm, 0.0])
    model.X_PC, task.X_WGoal = Transform(RigidTransform(turn @ begin.rotation(), place)), Transform(goal)
    model.mesh.scale += growth
    model.mesh.mass, model.mesh.friction = 1e-3 * variation.mass_g, variation.friction
    return found


def _object(scenario: Scenario) -> ModelConfig:
    """The model that the task handles."""
    name = None if scenario.task is None else scenario.task.object
    for model in scenario.models:
        if model.name == name and model_path(model.file).suffix.lower() in MESH_SUFFIXES:
            return model
    raise InputError("grasp trials", "task.object", name, f"give the model of a bare mesh ({', '.join(MESH_SUFFIXES)})")


def _lifted(X_WO: RigidTransform, vertices: Array, growth: float) -> RigidTransform:
    """Where an object stands as high as before when every unit of its vertices (N, 3) has grown by `growth` m."""
    below = float(np.min(vertices @ X_WO.rotation().matrix()[2]))
    return RigidTransform(X_WO.rotation(), X_WO.translation() - [0.0, 0.0, growth * below])
