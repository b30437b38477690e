"""One trial of pick and place, judged by what was recorded of it."""

from dataclasses import asdict, dataclass

import numpy as np
from pydrake.math import RotationMatrix

from soft_gripper.control.task_phases import Outcome
from soft_gripper.diagrams.recording.recording import Recording
from soft_gripper.diagrams.station_parts import Station
from soft_gripper.runs.trials.trial_run import TrialRun
from soft_gripper.runs.trials.variation import Variation


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
