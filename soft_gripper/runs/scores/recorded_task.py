"""The ground truth of a task's result, from its recording: what the task achieved, and why it failed.

Another measure is a field of `Judged` and its value in `judged`; another reason of a failure, a `TaskCriterion` in
`task_criteria`.
"""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from pydrake.math import RigidTransform, RotationMatrix

from soft_gripper.arrays import Array
from soft_gripper.control.task import Outcome
from soft_gripper.diagrams.recording import Recording
from soft_gripper.diagrams.station_parts import Station
from soft_gripper.runs.scores.recorded_object import RecordedObject
from soft_gripper.scenario.schema import TaskConfig

Flags = NDArray[np.bool_]
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
    slip_mm: see `RecordedObject.slip`; from the start of the first phase that holds the object to the end of the last
        phase but one, since the last one puts it down.
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


class TaskRun:
    """The ground truth and the estimates of one recorded task."""

    def __init__(self, station: Station, recording: Recording):
        """`station` has a task and contact detection; `recording` is the recording of its run."""
        assert station.task is not None
        assert station.scenario.task is not None
        self.task = station.scenario.task
        self._station, self._recording = station, recording
        self._phases = station.task.phases
        self._time = recording.values("time")
        self._phase = recording.values("task.phase").astype(int)
        outcomes = recording.values("task.outcome").astype(int)
        self.outcome = Outcome(outcomes[-1])
        self.outcomes = np.append(outcomes[1:], outcomes[-1])  # outcome after each sample

    def when(self, sample: int) -> str:
        """The time and the phase of a sample, as text."""
        phase = self._phase[sample]
        name = f" in '{self._phases[phase].name}'" if phase < len(self._phases) else ""
        return f"at {self._time[sample]:.2f} s{name}"

    @property
    def placed_offset(self) -> Array:
        """Vector from the goal to the final object frame, (3,) m in the world."""
        return np.asarray(self.final_pose.translation() - self._goal_pose.translation())

    @property
    def placed_rotation(self) -> RotationMatrix:
        """Final orientation of the object in the goal frame."""
        return self._goal_pose.rotation().inverse() @ self.final_pose.rotation()

    @cached_property
    def final_pose(self) -> RigidTransform:
        """Final pose of the object frame in the world."""
        return RigidTransform(self._object.poses[-1])

    @cached_property
    def _object(self) -> RecordedObject:
        return RecordedObject(self._station, self._recording, str(self.task.object))

    @property
    def _goal_pose(self) -> RigidTransform:
        return self.task.X_WGoal.GetDeterministicValue()

    @cached_property
    def dropped(self) -> int | None:
        """The sample at which the object was lost although it should be held; None: it was not dropped."""
        is_held = np.isin(self._phase, self._holding) & (self.outcomes == Outcome.RUNNING)
        losses = np.flatnonzero((is_held & (self._normal == 0).all(axis=0)) | (self.outcomes == Outcome.OBJECT_LOST))
        return int(losses[0]) if len(losses) else None

    @cached_property
    def peak_force(self) -> float:
        """Largest normal force of a finger, N."""
        return float(self._normal.max())

    @cached_property
    def squeeze(self) -> float:
        """Largest squeeze of a soft object while a finger touches it, m; NaN of a rigid one."""
        if f"{self.task.object}.squeeze" not in self._recording:
            return NAN
        is_touched = (self._normal > 0).any(axis=0)
        return float(self._object.values("squeeze").max(where=is_touched, initial=0.0))

    @cached_property
    def slips(self) -> Array:
        """Slip of the object along the fingers since they lift it, (T,) m; NaN where they do not lift or carry it."""
        carrying_phases = self._holding[:-1] or self._holding
        samples = np.flatnonzero(np.isin(self._phase, carrying_phases))
        slips = np.full(len(self._phase), NAN)
        slips[samples] = self._object.slip(samples)
        return slips

    @cached_property
    def slip(self) -> float:
        """The largest slip, m."""
        known_slips = self.slips[np.isfinite(self.slips)]
        return float(known_slips.max()) if len(known_slips) else NAN

    @cached_property
    def detection_delay(self) -> float:
        """The largest detection delay of all fingers, s; NaN if none touched anything."""
        delays = [detection_delay(self._time, *contact) for contact in self._contacts.values()]
        return max((delay for delay in delays if not np.isnan(delay)), default=NAN)

    @cached_property
    def false_alarm(self) -> str:
        """The finger and the time of a false contact alarm; empty if there was none."""
        for finger, contact in self._contacts.items():
            if (sample := false_alarm(*contact)) is not None:
                return f"false alarm of {finger} {self.when(sample)}"
        return ""

    @cached_property
    def size_error(self) -> float:
        """Error of the estimated width, m, at the end of the phase that closes the fingers."""
        closing = [i for i, phase in enumerate(self._phases) if phase.until == "grasped"]
        samples = np.flatnonzero(np.isin(self._phase, closing))
        error = self._recording.values("grip.object_width") - self._recording.values("grip.true_object_width")
        return abs(float(error[samples[-1]])) if len(samples) else NAN

    @cached_property
    def duration(self) -> float:
        """Time until the task or the recording ended, s."""
        end_samples = np.flatnonzero(self._phase == len(self._phases))
        return float(self._time[end_samples[0] if len(end_samples) else -1])

    @property
    def _holding(self) -> list[int]:
        """Numbers of the phases that hold the object."""
        return [i for i, phase in enumerate(self._phases) if phase.holds]

    @cached_property
    def _normal(self) -> Array:
        """Normal forces of the fingers, (F, T) N."""
        return np.stack([self._recording.values(f"{finger.name}.normal_force") for finger in self._station.fingers])

    @cached_property
    def _contacts(self) -> dict[str, tuple[Flags, Flags]]:
        """Whether each finger is in contact, detected and true, at each sample."""
        names = [finger.name for finger in self._station.fingers]
        detections = (self._recording.values(f"{name}.contact") > 0.5 for name in names)
        return dict(zip(names, zip(detections, self._normal > 0, strict=True), strict=True))


def detection_delay(time: Array, detected: Flags, true: Flags) -> float:
    """Delay from the first true to the first detected contact, s; NaN without contact, infinite if none is detected."""
    if not true.any():
        return NAN
    return float(time[np.argmax(detected)] - time[np.argmax(true)]) if detected.any() else float("inf")


def false_alarm(detected: Flags, true: Flags) -> int | None:
    """First sample of a detected contact with no true contact since the previous detection; None if there is none."""
    edges = np.flatnonzero(np.diff(detected.astype(int), prepend=0))
    ends = [0, *edges[1::2]]
    return next((int(b) for b, end in zip(edges[::2], ends, strict=False) if not true[end : b + 1].any()), None)


def judged(station: Station, recording: Recording) -> Judged:
    """The ground truth of a task's result, from its recording."""
    run = TaskRun(station, recording)
    cause = failure(run)
    return Judged(
        success=not cause,
        placed_error_mm=1e3 * float(np.linalg.norm(run.placed_offset)),
        placed_angle_deg=float(np.degrees(angle(run.placed_rotation))),
        dropped=run.dropped is not None,
        peak_force_n=run.peak_force,
        squeeze_mm=1e3 * run.squeeze,
        slip_mm=1e3 * run.slip,
        detection_delay_ms=1e3 * run.detection_delay,
        size_error_mm=1e3 * run.size_error,
        duration_s=run.duration,
        cause=cause,
    )


def failure(run: TaskRun) -> str:
    """The cause of a failure, as a phrase; empty for a success."""
    return next((cause for criterion in task_criteria(run.task) if (cause := criterion.failure(run))), "")


@dataclass(frozen=True)
class TaskCriterion:
    """A condition for the success of a task, and how a run fails it: a phrase, empty if it does not."""

    text: str
    failure: Callable[[TaskRun], str]


def task_criteria(task: TaskConfig) -> list[TaskCriterion]:
    """The conditions for the success of a task. The likely root cause of a failure comes first."""
    limits = []
    if task.force_limit is not None:
        limits.append(TaskCriterion(f"no finger presses with more than {task.force_limit:g} N", _pressed))
    if task.squeeze_limit is not None:
        limits.append(TaskCriterion(f"the object is squeezed by at most {1e3 * task.squeeze_limit:g} mm", _squeezed))
    return [
        TaskCriterion("the object is never dropped", _dropped),
        TaskCriterion("the task reports that it is done", _unfinished),
        TaskCriterion("no contact is detected where there is none", lambda run: run.false_alarm),
        TaskCriterion("every contact is detected", _undetected),
        *limits,
        TaskCriterion(f"the object slips by at most {MAX_SLIP:g} mm while it is lifted and carried", _slipped),
        TaskCriterion(f"the object is placed within {MAX_PLACED_ERROR:g} mm of the goal", _misplaced),
        TaskCriterion(f"the object is turned to within {MAX_PLACED_ANGLE:g} degrees of the goal", _misturned),
    ]


def _dropped(run: TaskRun) -> str:
    return "" if run.dropped is None else f"dropped {run.when(run.dropped)}"


def _unfinished(run: TaskRun) -> str:
    if run.outcome == Outcome.RUNNING:
        return f"not over {run.when(-1)}"
    end = run.when(int(np.argmax(run.outcomes != Outcome.RUNNING)))
    return "" if run.outcome == Outcome.DONE else f"{run.outcome.words} {end}"


def _undetected(run: TaskRun) -> str:
    return "contact not detected" if np.isinf(run.detection_delay) else ""


def _pressed(run: TaskRun) -> str:
    limit = run.task.force_limit
    return f"force of {run.peak_force:.2f} N, above {limit:g} N" if limit is not None and run.peak_force > limit else ""


def _squeezed(run: TaskRun) -> str:
    limit = run.task.squeeze_limit
    if limit is None or not run.squeeze > limit:
        return ""
    return f"squeezed by {1e3 * run.squeeze:.2f} mm, above {1e3 * limit:g} mm"


def _slipped(run: TaskRun) -> str:
    slip_mm = 1e3 * run.slip
    return "" if slip_mm <= MAX_SLIP else f"slip of {slip_mm:.2f} mm, above {MAX_SLIP:g} mm"


def _misplaced(run: TaskRun) -> str:
    error = 1e3 * float(np.linalg.norm(run.placed_offset))
    return "" if error <= MAX_PLACED_ERROR else f"placed {error:.1f} mm from the goal, above {MAX_PLACED_ERROR:g} mm"


def _misturned(run: TaskRun) -> str:
    turn_angle, tilt_angle = (float(np.degrees(measure(run.placed_rotation))) for measure in (angle, tilt))
    limit = MAX_PLACED_ANGLE
    ends = f"tilted by {tilt_angle:.1f}, above {limit:g} degrees"
    return "" if turn_angle <= limit else f"placed {turn_angle:.1f} degrees from the goal, {ends}"


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
    turn = 2 * np.arctan2(quaternion.z(), quaternion.w())
    return float(np.arctan2(np.sin(turn), np.cos(turn)))
