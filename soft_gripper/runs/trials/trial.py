"""One trial of pick and place, and its score from the recording."""

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
from soft_gripper.runs.scores.grasp import UNKNOWN, Grasp
from soft_gripper.runs.trials.trial_run import TrialRun
from soft_gripper.scenario.mesh_object import MESH_SUFFIXES, read_scene
from soft_gripper.scenario.model_files import model_path
from soft_gripper.scenario.schema import ModelConfig, PoseErrorConfig, Scenario, TrialsConfig


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
class Variation(RandomObject):
    """The differences of a trial from its scenario: the object, and its reported minus its true pose."""

    error_x_mm: float
    error_y_mm: float
    error_yaw_deg: float


def random_numbers(seed: int, scenario: str, trial: int) -> np.random.Generator:
    """The random generator of one trial, independent of the other trials."""
    return np.random.default_rng([seed, trial, *scenario.encode()])


def draw(rng: np.random.Generator, ranges: TrialsConfig) -> Variation:
    """A variation with uniformly distributed components."""
    x, y, yaw = rng.uniform(-1.0, 1.0, 3) * (1e3 * ranges.offset, 1e3 * ranges.offset, np.degrees(ranges.yaw))
    spans = (1e3 * np.array(ranges.mass), np.array(ranges.friction), 1 + ranges.size * np.array([-1.0, 1.0]))
    others = tuple(rng.uniform(least, most) for least, most in spans)
    offset, turn = 1e3 * ranges.offset_error, np.degrees(ranges.yaw_error)
    error = rng.uniform(-1.0, 1.0, 3) * (offset, offset, turn)
    return Variation(*map(float, (x, y, yaw, *others, *error)))


def vary(scenario: Scenario, rng: np.random.Generator) -> tuple[Scenario, Variation]:
    """A random variation of a scenario, and the draw; see `varied`. Sensor errors are redrawn as well."""
    _object(scenario)
    assert scenario.task is not None
    variation = draw(rng, scenario.task.trials)
    found = varied(scenario, variation)
    found.sensor.seed = int(rng.integers(2**31))
    return found, variation


def varied(scenario: Scenario, variation: Variation) -> Scenario:
    """The scenario with another object and reported pose. The lowest point keeps its height at start and goal.

    Raises:
        InputError: if the object of the task is not a bare mesh.
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
    """The model handled by the task."""
    name = None if scenario.task is None else scenario.task.object
    for model in scenario.models:
        if model.name == name and model_path(model.file).suffix.lower() in MESH_SUFFIXES:
            return model
    raise InputError("grasp trials", "task.object", name, f"give the model of a bare mesh ({', '.join(MESH_SUFFIXES)})")


def _lifted(X_WO: RigidTransform, vertices: Array, growth: float) -> RigidTransform:
    """A pose that keeps the lowest point's height when each unit of the vertices (N, 3) has grown by `growth` m."""
    below = float(np.min(vertices @ X_WO.rotation().matrix()[2]))
    return RigidTransform(X_WO.rotation(), X_WO.translation() - [0.0, 0.0, growth * below])


def angle(R_GO: RotationMatrix) -> float:
    """Angle of the rotation from the goal's orientation to the object's, rad, 0 to pi."""
    return abs(float(R_GO.ToAngleAxis().angle()))


def tilt(R_GO: RotationMatrix) -> float:
    """Angle between the z axes, rad, 0 to pi; unaffected by rotation of the object about its own z axis."""
    x, y, z = R_GO.col(2)
    return float(np.arctan2(np.hypot(x, y), z))


def yaw(R_GO: RotationMatrix) -> float:
    """Angle of the remaining rotation about z after the z axes are aligned, rad, -pi to pi."""
    quaternion = R_GO.ToQuaternion()
    turned = 2 * np.arctan2(quaternion.z(), quaternion.w())
    return float(np.arctan2(np.sin(turned), np.cos(turned)))


MAX_PLACED_ERROR = 10.0  # mm from the goal, within which an object counts as placed
MAX_PLACED_ANGLE = 10.0  # degrees from the orientation of the goal, likewise
MAX_SLIP = 2.0  # mm, allowed slip of a held object
NAN = float("nan")


@dataclass(frozen=True)
class Judged:
    """The ground truth of a task's result; NaN if there was nothing to measure.

    success: nothing went wrong, see `failure`.
    placed_error_mm: distance of the object's frame from that of the goal at the end.
    placed_angle_deg: angle between the orientations of the two, even for round objects.
    dropped: no finger touched the object while it should be held, or the task reported that it was lost.
    peak_force_n: largest normal force of a finger.
    squeeze_mm: largest squeeze of a soft object by the fingers; NaN of a rigid one.
    slip_mm: see `slip`; from the start of the first phase that holds the object to the end of the last phase but one,
        since the last one puts it down.
    detection_delay_ms: from a finger's first contact to its first detection, for the slowest finger.
    size_error_mm: error of the estimated object width when the fingers have closed.
    duration_s: time until the task ends.
    cause: cause of a failure; empty if there was none.
    """

    success: bool
    placed_error_mm: float
    placed_angle_deg: float
    dropped: bool
    peak_force_n: float
    squeeze_mm: float
    slip_mm: float
    detection_delay_ms: float
    size_error_mm: float
    duration_s: float
    cause: str


@dataclass(frozen=True)
class TrialNumber:
    """The trial that a row belongs to."""

    scenario: str
    trial: int


@dataclass(frozen=True)
class TrialRow(Judged, TrialNumber):
    """The result of one trial."""


@dataclass(frozen=True)
class DetailRow(Variation, TrialNumber):
    """The random draw of a trial, see Variation, and the final pose of its object; NaN: unknown.

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
class GraspRow(Grasp, TrialNumber):
    """The grasp of a trial until its object is put down, see `Grasp`."""


@dataclass(frozen=True)
class Trial:
    """The result of a trial, its random draw, and its grasp."""

    row: TrialRow
    details: DetailRow
    grasp: Grasp = UNKNOWN

    @property
    def rows(self) -> tuple[TrialRow, DetailRow, GraspRow]:
        """A row for each table."""
        return self.row, self.details, GraspRow(self.row.scenario, self.row.trial, **vars(self.grasp))


def failed_row(scenario: str, trial: int, cause: str) -> TrialRow:
    """The row of a trial without a recording."""
    return TrialRow(scenario, trial, False, NAN, NAN, False, NAN, NAN, NAN, NAN, NAN, NAN, cause)


def trial_row(scenario: str, trial: int, station: Station, recording: Recording) -> TrialRow:
    """The row of a trial from its recording."""
    return TrialRow(scenario, trial, **asdict(judged(station, recording)))


def judged(station: Station, recording: Recording) -> Judged:
    """The ground truth of a task's result, from its recording."""
    run = TrialRun(station, recording)
    cause = failure(run)
    return Judged(
        success=not cause,
        placed_error_mm=1e3 * float(np.linalg.norm(run.placed)),
        placed_angle_deg=float(np.degrees(angle(run.turned))),
        dropped=run.dropped is not None,
        peak_force_n=run.peak_force,
        squeeze_mm=1e3 * run.squeeze,
        slip_mm=1e3 * run.slip,
        detection_delay_ms=1e3 * run.detection_delay,
        size_error_mm=1e3 * run.size_error,
        duration_s=run.duration,
        cause=cause,
    )


def failure(run: TrialRun) -> str:
    """The cause of a failure, as a phrase; empty for a success. The likely root cause comes first."""
    limit, squeezed, placed_error = run.force_limit, run.squeeze_limit, 1e3 * float(np.linalg.norm(run.placed))
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
        return "contact not detected"
    if limit is not None and run.peak_force > limit:
        return f"force of {run.peak_force:.2f} N, above {limit:g} N"
    if squeezed is not None and run.squeeze > squeezed:
        return f"squeezed by {1e3 * run.squeeze:.2f} mm, above {1e3 * squeezed:g} mm"
    if not 1e3 * run.slip <= MAX_SLIP:
        return f"slip of {1e3 * run.slip:.2f} mm, above {MAX_SLIP:g} mm"
    if not placed_error <= MAX_PLACED_ERROR:
        return f"placed {placed_error:.1f} mm from the goal, above {MAX_PLACED_ERROR:g} mm"
    if not placed_angle <= MAX_PLACED_ANGLE:
        tilted, most = float(np.degrees(tilt(run.turned))), MAX_PLACED_ANGLE
        return f"placed {placed_angle:.1f} degrees from the goal, tilted by {tilted:.1f}, above {most:g} degrees"
    return ""
