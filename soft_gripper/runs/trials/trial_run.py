"""Measures from the recording of a trial, and the samples at which something went wrong."""

from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from pydrake.math import RigidTransform, RotationMatrix

from soft_gripper.arrays import Array
from soft_gripper.control.task import Outcome
from soft_gripper.diagrams.recording import Recording
from soft_gripper.diagrams.station_parts import Station
from soft_gripper.runs.scores.slip import recorded_poses, slip

Flags = NDArray[np.bool_]
NAN = float("nan")


class TrialRun:
    """The ground truth and the estimates of one recorded trial."""

    def __init__(self, station: Station, recording: Recording):
        """`station` has a task and contact detection; `recording` is the recording of its run."""
        assert station.task is not None
        assert station.scenario.task is not None
        self._task = station.scenario.task
        self._station, self._recording = station, recording
        self._phases = station.task.phases
        self._time = recording["time"].values
        self._phase = recording["task.phase"].values.astype(int)
        outcomes = recording["task.outcome"].values.astype(int)
        self.outcome = Outcome(outcomes[-1])
        self.outcomes = np.append(outcomes[1:], outcomes[-1])  # outcome after each sample
        self.force_limit = self._task.force_limit  # N; None: no limit
        self.squeeze_limit = self._task.squeeze_limit  # m; None: no limit

    def when(self, sample: int) -> str:
        """The time and the phase of a sample, as text."""
        phase = self._phase[sample]
        name = f" in '{self._phases[phase].name}'" if phase < len(self._phases) else ""
        return f"at {self._time[sample]:.2f} s{name}"

    @property
    def placed(self) -> Array:
        """Vector from the goal to the final object frame, (3,) m in the world."""
        found: Array = self.final_pose.translation() - self._goal_pose.translation()
        return found

    @property
    def turned(self) -> RotationMatrix:
        """Final orientation of the object in the goal frame."""
        return self._goal_pose.rotation().inverse() @ self.final_pose.rotation()

    @cached_property
    def final_pose(self) -> RigidTransform:
        """Final pose of the object frame in the world."""
        return recorded_poses(self._recording, str(self._task.object), [-1])[0]

    @property
    def _goal_pose(self) -> RigidTransform:
        return self._task.X_WGoal.GetDeterministicValue()

    @cached_property
    def dropped(self) -> int | None:
        """The sample at which the object was lost although it should be held; None: it was not dropped."""
        forces = np.array([self._of(finger, "normal_force") for finger in self._fingers])
        held = np.isin(self._phase, self._holding) & (self.outcomes == Outcome.RUNNING)
        lost = np.flatnonzero((held & (forces == 0).all(axis=0)) | (self.outcomes == Outcome.OBJECT_LOST))
        return int(lost[0]) if len(lost) else None

    @cached_property
    def peak_force(self) -> float:
        """Largest normal force of a finger, N."""
        return max(float(self._of(finger, "normal_force").max()) for finger in self._fingers)

    @cached_property
    def squeeze(self) -> float:
        """Largest squeeze of a soft object while a finger touches it, m; NaN of a rigid one."""
        signal = f"{self._task.object}.squeeze"
        if signal not in self._recording.data:
            return NAN
        touched = np.any([self._of(finger, "normal_force") > 0 for finger in self._fingers], axis=0)
        return float(self._recording[signal].values.max(where=touched, initial=0.0))

    @cached_property
    def slip(self) -> float:
        """Slip of the object along the fingers while they lift and carry it, m."""
        carrying = self._holding[:-1] or self._holding
        samples = np.flatnonzero(np.isin(self._phase, carrying))
        slips = slip(self._station, self._recording, str(self._task.object), samples)
        return float(slips.max()) if len(slips) else NAN

    @cached_property
    def detection_delay(self) -> float:
        """The largest detection delay of all fingers, s; NaN if none touched anything."""
        delays = [detection_delay(self._time, *self._contact(finger)) for finger in self._fingers]
        return max((delay for delay in delays if not np.isnan(delay)), default=NAN)

    @cached_property
    def false_alarm(self) -> str:
        """The finger and the time of a false contact alarm; empty if there was none."""
        for finger in self._fingers:
            sample = false_alarm(*self._contact(finger))
            if sample is not None:
                return f"false alarm of {finger} {self.when(sample)}"
        return ""

    @cached_property
    def size_error(self) -> float:
        """Error of the estimated width, m, at the end of the phase that closes the fingers."""
        closing = [i for i, phase in enumerate(self._phases) if phase.until == "grasped"]
        samples = np.flatnonzero(np.isin(self._phase, closing))
        error = self._recording["grip.object_width"].values - self._recording["grip.true_object_width"].values
        return abs(float(error[samples[-1]])) if len(samples) else NAN

    @cached_property
    def duration(self) -> float:
        """Time until the task or the recording ended, s."""
        over = np.flatnonzero(self._phase == len(self._phases))
        return float(self._time[over[0] if len(over) else -1])

    @property
    def _fingers(self) -> list[str]:
        return [finger.name for finger in self._station.fingers]

    @property
    def _holding(self) -> list[int]:
        """Numbers of the phases that hold the object."""
        return [i for i, phase in enumerate(self._phases) if phase.holds]

    def _of(self, finger: str, signal: str) -> Array:
        return self._recording[f"{finger}.{signal}"].values

    def _contact(self, finger: str) -> tuple[Flags, Flags]:
        """Whether a finger is in contact, detected and true, at each sample."""
        return self._of(finger, "contact") > 0.5, self._of(finger, "normal_force") > 0


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
