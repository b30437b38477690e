"""A scenario varied at random: where its object stands and is reported to, how heavy, slippery and large it is."""

from copy import deepcopy
from dataclasses import dataclass

import numpy as np
from pydrake.common.schema import Transform
from pydrake.math import RigidTransform, RotationMatrix

from soft_gripper.arrays import Array
from soft_gripper.errors import InputError
from soft_gripper.scenario.mesh_object import MESH_SUFFIXES, read_scene
from soft_gripper.scenario.model_files import model_path
from soft_gripper.scenario.scenario import ModelConfig, PoseErrorConfig, Scenario, TrialsConfig


@dataclass(frozen=True)
class RandomObject:
    """What is random about an object: a shift and a turn, a mass, a friction, a factor of the size."""

    x_mm: float
    y_mm: float
    yaw_deg: float
    mass_g: float
    friction: float
    size: float


@dataclass(frozen=True)
class Variation(RandomObject):
    """How a trial differs from its scenario: the object, and the reported minus the true pose of it."""

    error_x_mm: float
    error_y_mm: float
    error_yaw_deg: float


def random_numbers(seed: int, scenario: str, trial: int) -> np.random.Generator:
    """The random numbers of one trial, whatever other trials there are."""
    return np.random.default_rng([seed, trial, *scenario.encode()])


def draw(rng: np.random.Generator, ranges: TrialsConfig) -> Variation:
    """A variation, every part of it evenly distributed."""
    x, y, yaw = rng.uniform(-1.0, 1.0, 3) * (1e3 * ranges.offset, 1e3 * ranges.offset, np.degrees(ranges.yaw))
    spans = (1e3 * np.array(ranges.mass), np.array(ranges.friction), 1 + ranges.size * np.array([-1.0, 1.0]))
    others = tuple(rng.uniform(least, most) for least, most in spans)
    offset, turn = 1e3 * ranges.offset_error, np.degrees(ranges.yaw_error)
    error = rng.uniform(-1.0, 1.0, 3) * (offset, offset, turn)
    return Variation(*map(float, (x, y, yaw, *others, *error)))


def vary(scenario: Scenario, rng: np.random.Generator) -> tuple[Scenario, Variation]:
    """A random variation of a scenario, and what was drawn; see `varied`. Sensors with errors have their own, too."""
    _object(scenario)
    assert scenario.task is not None
    variation = draw(rng, scenario.task.trials)
    found = varied(scenario, variation)
    found.sensor.seed = int(rng.integers(2**31))
    return found, variation


def varied(scenario: Scenario, variation: Variation) -> Scenario:
    """The scenario with another object, and a pose reported of it. Its lowest point keeps its height, at both ends.

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
    error = (1e-3 * variation.error_x_mm, 1e-3 * variation.error_y_mm, float(np.radians(variation.error_yaw_deg)))
    task.pose_error = PoseErrorConfig(*error)
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
