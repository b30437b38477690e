"""One trial of pick and place: its random draw, and the rows of its result.

Another variation is a field of `TrialsConfig` and of `TrialVariation`, a number in `draw`, and its effect in `varied`.
"""

from collections.abc import Sequence
from copy import deepcopy
from dataclasses import dataclass
from typing import cast

import numpy as np
from pydrake.common.schema import Transform
from pydrake.math import RigidTransform, RotationMatrix

from soft_gripper.arrays import Array
from soft_gripper.errors import InputError
from soft_gripper.extras.grasps.adds import TrialsConfig, Varied
from soft_gripper.files.row_table import cells, row_from_cells
from soft_gripper.model_import.forms.mesh import SUFFIXES as MESH_SUFFIXES
from soft_gripper.model_import.mesh_files import read_scene
from soft_gripper.runs.scores.grasp import UNKNOWN, Grasp
from soft_gripper.runs.scores.recorded_task import Judged
from soft_gripper.scenario.model_files import model_path
from soft_gripper.scenario.schema import ModelConfig, PoseErrorConfig, Scenario

NAN = float("nan")


@dataclass(frozen=True)
class RandomObject:
    """The random properties of an object: shift, rotation, mass, friction and scale factor."""

    x_mm: float
    y_mm: float
    yaw_deg: float
    mass_g: float
    friction: float
    size: float


@dataclass(frozen=True)
class TrialVariation(RandomObject):
    """The differences of a trial from its scenario: the object, and its reported minus its true pose."""

    error_x_mm: float
    error_y_mm: float
    error_yaw_deg: float


def random_numbers(seed: int, scenario: str, trial: int) -> np.random.Generator:
    """The random generator of one trial, independent of the other trials."""
    return np.random.default_rng([seed, trial, *scenario.encode()])


def draw(rng: np.random.Generator, ranges: TrialsConfig) -> TrialVariation:
    """Draws a variation with uniformly distributed components."""
    x, y, yaw = rng.uniform(-1.0, 1.0, 3) * (1e3 * ranges.offset, 1e3 * ranges.offset, np.degrees(ranges.yaw))
    spans = (1e3 * np.array(ranges.mass), np.array(ranges.friction), 1 + ranges.size * np.array([-1.0, 1.0]))
    properties = tuple(rng.uniform(low, high) for low, high in spans)
    max_offset_error = 1e3 * ranges.offset_error
    max_yaw_error = np.degrees(ranges.yaw_error)
    error = rng.uniform(-1.0, 1.0, 3) * (max_offset_error, max_offset_error, max_yaw_error)
    return TrialVariation(*map(float, (x, y, yaw, *properties, *error)))


def vary(scenario: Scenario, rng: np.random.Generator) -> tuple[Scenario, TrialVariation]:
    """Draws a random variation of a scenario; see `varied`. Sensor errors are redrawn as well."""
    _object(scenario)
    variation = draw(rng, cast(Varied, scenario.task).trials)
    variant = varied(scenario, variation)
    variant.sensor.seed = int(rng.integers(2**31))
    return variant, variation


def varied(scenario: Scenario, variation: TrialVariation) -> Scenario:
    """A scenario with another object and reported pose. The lowest point keeps its height at start and goal.

    Raises:
        InputError: if the object of the task is not a bare mesh.
    """
    variant = deepcopy(scenario)
    model = _object(variant)
    task = variant.task
    assert task is not None
    vertices = read_scene(model_path(model.file)).convex_hull.vertices
    growth = (variation.size - 1) * model.mesh.scale
    begin, goal = (_keep_height(X.GetDeterministicValue(), vertices, growth) for X in (model.X_PC, task.X_WGoal))
    yaw_rotation = RotationMatrix.MakeZRotation(np.radians(variation.yaw_deg))
    place = begin.translation() + 1e-3 * np.array([variation.x_mm, variation.y_mm, 0.0])
    model.X_PC, task.X_WGoal = Transform(RigidTransform(yaw_rotation @ begin.rotation(), place)), Transform(goal)
    model.mesh.scale += growth
    model.mass, model.friction = 1e-3 * variation.mass_g, variation.friction
    error = (1e-3 * variation.error_x_mm, 1e-3 * variation.error_y_mm, float(np.radians(variation.error_yaw_deg)))
    task.pose_error = PoseErrorConfig(*error)
    return variant


def _object(scenario: Scenario) -> ModelConfig:
    """The model handled by the task."""
    name = None if scenario.task is None else scenario.task.object
    for model in scenario.models:
        if model.name == name and model_path(model.file).suffix.lower() in MESH_SUFFIXES:
            return model
    expected = f"give the model of a bare mesh ({', '.join(MESH_SUFFIXES)})"
    raise InputError("grasp trials", "task.object", name, expected)


def _keep_height(X_WO: RigidTransform, vertices: Array, growth: float) -> RigidTransform:
    """Shifts a pose to keep the height of the lowest vertex (N, 3), whose unit has grown by `growth` m."""
    lowest_z = float(np.min(vertices @ X_WO.rotation().matrix()[2]))
    return RigidTransform(X_WO.rotation(), X_WO.translation() - [0.0, 0.0, growth * lowest_z])


@dataclass(frozen=True)
class Details(TrialVariation):
    """The random draw of a trial, see TrialVariation, and the final pose of its object; NaN: unknown.

    x_mm, y_mm, yaw_deg: true initial pose of the object, relative to that in the scenario.
    reported_...: pose reported to the task, relative to the same; error_...: reported minus true pose.
    placed_...: final pose of the object, relative to the goal: position in the world, rotation about its own z axis,
        tilt of that axis.
    """

    reported_x_mm: float
    reported_y_mm: float
    reported_yaw_deg: float
    placed_x_mm: float = NAN
    placed_y_mm: float = NAN
    placed_yaw_deg: float = NAN
    placed_tilt_deg: float = NAN


@dataclass(frozen=True)
class Trial:
    """The result of a trial of a scenario, its random draw, and its grasp until the object is put down.

    The columns of its tables are the name of the scenario and the number of the trial, then those of one of PARTS.
    """

    scenario: str
    trial: int
    result: Judged
    details: Details
    grasp: Grasp = UNKNOWN

    @property
    def rows(self) -> list[list[str]]:
        """Cells of the trial in each table."""
        rows = self.result, self.details, self.grasp
        return [[self.scenario, str(self.trial), *cells(row)] for row in rows]

    @classmethod
    def from_rows(cls, rows: Sequence[Sequence[str]]) -> "Trial":
        """Reads a trial from its cells in each table."""
        scenario, number, *_ = rows[0]
        result, details, grasp = (row[len(KEYS) :] for row in rows)
        parts = row_from_cells(result, Judged), row_from_cells(details, Details), row_from_cells(grasp, Grasp)
        return cls(scenario, int(number), *parts)


KEYS, PARTS = ("scenario", "trial"), (Judged, Details, Grasp)
