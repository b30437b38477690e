"""One trial of pick and place, judged by what was recorded of it."""

from copy import deepcopy
from dataclasses import asdict, dataclass

import numpy as np
from pydrake.common.schema import Transform
from pydrake.math import RigidTransform, RotationMatrix

from soft_gripper.arrays import Array
from soft_gripper.control.task import Outcome
from soft_gripper.diagrams.recording import Recording
from soft_gripper.diagrams.station_parts import Station
from soft_gripper.errors import InputError
from soft_gripper.runs.trials.trial_run import TrialRun
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


def angle(R_GO: RotationMatrix) -> float:
    """Of the one rotation that leads from the goal's orientation to the object's, rad, 0 to pi."""
    return abs(float(R_GO.ToAngleAxis().angle()))


def tilt(R_GO: RotationMatrix) -> float:
    """Between the z axes, rad, 0 to pi; a turn of the object about its own z axis does not change it."""
    x, y, z = R_GO.col(2)
    return float(np.arctan2(np.hypot(x, y), z))


def yaw(R_GO: RotationMatrix) -> float:
    """Of the turn about the z axis that is left when the z axes are brought together, rad, -pi to pi."""
    quaternion = R_GO.ToQuaternion()
    turned = 2 * np.arctan2(quaternion.z(), quaternion.w())
    return float(np.arctan2(np.sin(turned), np.cos(turned)))


MAX_PLACED_ERROR = 10.0  # mm, within which of the goal an object counts as placed
MAX_PLACED_ANGLE = 10.0  # degrees, from the orientation of the goal, likewise
MAX_SLIP = 2.0  # mm, that a held object may slip
NAN = float("nan")


@dataclass(frozen=True)
class Judged:
    """What became of a task in truth; NaN where there was nothing to measure.

    success: nothing went wrong, see `failure`.
    placed_error_mm: distance of the object's frame from that of the goal at the end.
    placed_angle_deg: angle between the orientations of the two, of round objects too.
    dropped: no finger touched the object while it was to be held, or the task reported that it was lost.
    peak_force_n: largest normal force of a finger.
    slip_mm: see `slip`; from the beginning of the first phase that holds the object to the end of the last but one,
        since the last puts it down.
    detection_delay_ms: from a finger's first contact to the first that it detects, of the slowest finger.
    size_error_mm: of the estimated width of the object as the fingers have closed.
    duration_s: until the task is over.
    cause: of a failure; empty: none.
    """

    success: bool
    placed_error_mm: float
    placed_angle_deg: float
    dropped: bool
    peak_force_n: float
    slip_mm: float
    detection_delay_ms: float
    size_error_mm: float
    duration_s: float
    cause: str


@dataclass(frozen=True)
class TrialNumber:
    """Which trial a row belongs to."""

    scenario: str
    trial: int


@dataclass(frozen=True)
class TrialRow(Judged, TrialNumber):
    """What came of one trial."""


@dataclass(frozen=True)
class DetailRow(Variation, TrialNumber):
    """What was drawn for a trial, see Variation, and where its object ended; NaN: unknown.

    x_mm, y_mm, yaw_deg: true pose in which the object begins, from that in the scenario.
    reported_...: pose that is reported to the task, from the same; error_...: this minus the true one.
    placed_...: pose of the object at the end, from the goal: place in the world, turn about its own z axis, tilt of
        that axis.
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
    """What came of a trial, and what led to it."""

    row: TrialRow
    details: DetailRow


def failed_row(scenario: str, trial: int, cause: str) -> TrialRow:
    """The row of a trial that left no recording."""
    return TrialRow(scenario, trial, False, NAN, NAN, False, NAN, NAN, NAN, NAN, NAN, cause)


def trial_row(scenario: str, trial: int, station: Station, recording: Recording) -> TrialRow:
    """The row of a trial from its recording."""
    return TrialRow(scenario, trial, **asdict(judged(station, recording)))


def judged(station: Station, recording: Recording) -> Judged:
    """What became of a task, from its recording."""
    run = TrialRun(station, recording)
    cause = failure(run)
    return Judged(
        success=not cause,
        placed_error_mm=1e3 * float(np.linalg.norm(run.placed)),
        placed_angle_deg=float(np.degrees(angle(run.turned))),
        dropped=run.dropped is not None,
        peak_force_n=run.peak_force,
        slip_mm=1e3 * run.slip,
        detection_delay_ms=1e3 * run.detection_delay,
        size_error_mm=1e3 * run.size_error,
        duration_s=run.duration,
        cause=cause,
    )


def failure(run: TrialRun) -> str:
    """What went wrong, in a phrase; empty if nothing did. What is likely to have led to the rest comes first."""
    limit, placed_error = run.force_limit, 1e3 * float(np.linalg.norm(run.placed))
    placed_angle = float(np.degrees(angle(run.turned)))
    if run.dropped is not None:
        return f"dropped {run.when(run.dropped)}"
    if run.outcome == Outcome.RUNNING:
        return f"not over {run.when(-1)}"
    if run.outcome != Outcome.DONE:
        words = Outcome(run.outcome).words
        return f"{words} {run.when(int(np.argmax(run.outcomes != Outcome.RUNNING)))}"
    if run.false_alarm:
        return run.false_alarm
    if np.isinf(run.detection_delay):
        return "contact that was not detected"
    if limit is not None and run.peak_force > limit:
        return f"force of {run.peak_force:.2f} N, above {limit:g} N"
    if not 1e3 * run.slip <= MAX_SLIP:
        return f"slip of {1e3 * run.slip:.2f} mm, above {MAX_SLIP:g} mm"
    if not placed_error <= MAX_PLACED_ERROR:
        return f"placed {placed_error:.1f} mm from the goal, above {MAX_PLACED_ERROR:g} mm"
    if not placed_angle <= MAX_PLACED_ANGLE:
        tilted, most = float(np.degrees(tilt(run.turned))), MAX_PLACED_ANGLE
        return f"placed {placed_angle:.1f} degrees from the goal, tilted by {tilted:.1f}, above {most:g} degrees"
    return ""
