"""TaskMachine: leads arm and fingers through the phases of a task."""

from collections.abc import Iterator
from dataclasses import dataclass
from enum import IntEnum
from functools import cached_property
from typing import NamedTuple

import numpy as np
from pydrake.systems.framework import Context, EventStatus
from pydrake.trajectories import Trajectory

from soft_gripper.array_block import ArrayBlock
from soft_gripper.arrays import Array
from soft_gripper.steps import TIME, same

QUIET_BAND = 5e-4  # m, the default band of the opening ...
QUIET_TIME = 0.2  # s, ... and the time within it, for fingers at rest
OPENED_BAND = 2e-3  # m, around the commanded opening: a gripper at rest within this band counts as opened
GRIP_GAP = 0.1  # s, tolerated interruption of a grip
CLOSING_ALLOWANCE = 8e-3  # m, by which the gripper may close further after grasping
# Entries of the state of a task.
_PHASE_ENTRY, _OUTCOME_ENTRY, _SET_POINT_ENTRY, _BEGIN_ENTRY = 0, 1, -2, -1


class Outcome(IntEnum):
    """Outcome of a task so far. After a failure the fingers open and the arm goes home."""

    RUNNING = 0
    DONE = 1
    NOTHING_GRASPED = 2
    OBJECT_LOST = 3
    NOT_RELEASED = 4
    NOT_OPENED = 5

    @property
    def words(self) -> str:
        """The name in plain words."""
        return self.name.lower().replace("_", " ")


NOT_REACHED = {  # failure if a phase does not end in time
    "opened": Outcome.NOT_OPENED,
    "grasped": Outcome.NOTHING_GRASPED,
    "released": Outcome.NOT_RELEASED,
}


@dataclass(frozen=True)
class Phase:
    """A motion of the arm, followed by a wait for the end of the phase."""

    name: str
    motion: Trajectory  # (n) joint positions of the arm over the time since the start of the phase, s
    opening: float  # m, set point of the gripper; NaN: the task does not command it
    follower: int  # index of the next phase; the number of phases: none
    until: str | None = None  # "opened", "grasped", "released"; None: `rest` is over
    rest: float = 0.0  # s, after the motion
    holds: bool = False  # the object is in the fingers
    rescue: int | None = None  # index of the phase after a failure; None: cannot fail

    @cached_property
    def duration(self) -> float:
        return float(self.motion.end_time())


class GripObservation(NamedTuple):
    time: float  # s
    opening: float  # m
    torque: float  # N m, opening torque on the fingers


class Progress(NamedTuple):
    """Progress of a task: its whole state between samples."""

    phase: int = 0  # the number of phases: the task is over
    outcome: int = Outcome.RUNNING
    began: float = 0.0  # s, the phase
    quiet_opening: float = np.inf  # m, opening of the resting gripper ...
    since: float = 0.0  # s, ... since then
    gripped: float = 0.0  # s, time of the last grip
    grasped: float = -np.inf  # m, opening at the end of the last grasping phase


@dataclass(frozen=True)
class Rules:
    """Rules for the end of a phase and for its successor."""

    phases: tuple[Phase, ...]
    threshold: float  # N m, torque that counts as a grip
    timeout: float  # s, maximum wait after the motion
    quiet_band: float = QUIET_BAND  # m

    def step(self, progress: Progress, observation: GripObservation) -> Progress:
        if progress.phase == len(self.phases):
            return progress
        phase = self.phases[progress.phase]
        # Values that are not finite count as motion and as no grip.
        if not abs(observation.opening - progress.quiet_opening) <= self.quiet_band:
            progress = progress._replace(quiet_opening=observation.opening, since=observation.time)
        if observation.torque > self.threshold and observation.opening > progress.grasped - CLOSING_ALLOWANCE:
            progress = progress._replace(gripped=observation.time)
        waiting_time = observation.time - progress.began - phase.duration
        is_quiet = observation.time - progress.since >= QUIET_TIME
        if progress.outcome == Outcome.RUNNING:
            is_at_rest = waiting_time >= 0 and is_quiet
            if phase.holds and observation.time - progress.gripped > GRIP_GAP:
                progress = progress._replace(outcome=Outcome.OBJECT_LOST)
            elif phase.until is not None and waiting_time > self.timeout:
                progress = progress._replace(outcome=NOT_REACHED[phase.until])
            elif phase.until == "grasped" and is_at_rest and not observation.torque > self.threshold:
                progress = progress._replace(outcome=Outcome.NOTHING_GRASPED)
        is_complete = is_quiet and self._is_complete(phase, observation)
        follower = self._follower(phase, progress.outcome, waiting_time, is_complete)
        if follower is None:
            return progress
        if follower == len(self.phases) and progress.outcome == Outcome.RUNNING:
            progress = progress._replace(outcome=Outcome.DONE)
        grasped = observation.opening if phase.until == "grasped" else progress.grasped
        begin = observation.time
        return Progress(follower, progress.outcome, begin, since=begin, gripped=begin, grasped=grasped)

    def opening(self, progress: Progress) -> float:
        """The set point of the opening, m; a failure opens the fingers at once."""
        phase = self.phases[min(progress.phase, len(self.phases) - 1)]
        if progress.outcome > Outcome.DONE and phase.rescue is not None:
            return self.phases[phase.rescue].opening
        return phase.opening

    def _follower(self, phase: Phase, outcome: int, waiting_time: float, is_complete: bool) -> int | None:
        """The phase that starts now, if any."""
        if waiting_time < 0:
            return None
        if outcome != Outcome.RUNNING and phase.rescue is not None:
            return phase.rescue
        if not phase.until:
            return phase.follower if waiting_time >= phase.rest else None
        given_up = phase.rescue is None and waiting_time > self.timeout
        return phase.follower if given_up or is_complete else None

    def _is_complete(self, phase: Phase, observation: GripObservation) -> bool:
        """Whether fingers at rest are at the commanded opening, closed on an object, or on nothing."""
        if phase.until == "opened":
            return abs(observation.opening - phase.opening) <= OPENED_BAND
        if phase.until == "grasped":
            return observation.torque > self.threshold
        return abs(observation.torque) < self.threshold


_PROGRESS_ENTRIES = slice(0, len(Progress._fields))
_DESIRED_ENTRIES = slice(_PROGRESS_ENTRIES.stop, _SET_POINT_ENTRY)


class TaskMachine(ArrayBlock):
    """State machine of a task; only the estimates of the fingers trigger its transitions.

    ::

                            +-------------+ ---> desired_state  (2 n) positions and velocities of the arm's joints
        opening (1) m ----> | TaskMachine | ---> set_point      (1) m, opening of the gripper
        torque (1) N m ---> |             | ---> phase          (1) number of the phase; the number of phases: over
                            +-------------+ ---> outcome        (1) an Outcome

    `opening` and `torque` come from a GripControl; a task that does not command the gripper leaves them unconnected.
    The gripper is opened when the tips have come to rest as far apart as commanded. An object is grasped when they have
    come to rest and the torque is above the threshold, released when it is below, either way. It is lost when, in a
    phase that holds it, the torque stays below or the gripper closes too far. After a failure the fingers open, the
    current motion is completed, and the phase `rescue` follows.
    The desired state looks one sample ahead.

    One sample after the end of the task the block ends the run, as `EventStatus.ReachedTermination` does in Drake: a
    Simulator returns from `AdvanceTo` early. Advanced again, it goes on.
    """

    takes_axes = False

    def __init__(self, rules: Rules, period: float):
        """Follows the phases of `rules`; samples every `period` s."""
        super().__init__(period)
        self.rules, self._period, self._over = rules, period, len(rules.phases)
        for name in ("opening", "torque"):
            self.take(name, 1, optional=True)
        first = rules.phases[0]
        begin = np.array([*Progress(), *_desired_state(first, 0.0), first.opening, 0.0])
        self.remember(
            *("state", same),
            begin=begin,
            begin_of=(lambda time: np.append(begin[:_BEGIN_ENTRY], time), TIME),
            keep=self._next_state,
            kept=("opening", "torque", TIME),
            at_first=True,
        )
        desired = range(len(begin[_DESIRED_ENTRIES]))
        self.put_out("desired_state", lambda state: state[..., _DESIRED_ENTRIES], "state", state=desired)
        self.put_out("set_point", lambda state: state[..., _SET_POINT_ENTRY], "state", unit="m")
        phases = [*(phase.name for phase in rules.phases), "over"]
        self.put_out("phase", lambda state: state[..., _PHASE_ENTRY], "state", meanings=phases)
        outcomes = [outcome.words for outcome in Outcome]
        self.put_out("outcome", lambda state: state[..., _OUTCOME_ENTRY], "state", meanings=outcomes)
        self.DeclarePeriodicPublishEvent(period, 0.0, self._end_run)

    @property
    def phases(self) -> tuple[Phase, ...]:
        """The phases of the task, including rescues."""
        return self.rules.phases

    def progress(self, context: Context) -> Progress:
        return _progress(self._read["state"](context))

    def is_over(self, context: Context) -> bool:
        return self.progress(context).phase == self._over

    def unobserved_motion(self, end: float) -> Iterator[tuple[float, Array]]:
        """Times, s, and the desired states from then on, (2 n), where no phase waits for the gripper.

        The last one is where the task is over, or `end`.
        """
        progress = Progress()
        for time in self._period * np.arange(int(end / self._period) + 1):
            progress = self.rules.step(progress, GripObservation(float(time), np.nan, np.nan))
            if progress.phase < len(self.phases):
                desired = _desired_state(self.phases[progress.phase], time + self._period - progress.began)
            yield float(time), desired
            if progress.phase == len(self.phases):
                break

    def _next_state(self, state: Array, opening: Array | None, torque: Array | None, times: Array) -> Array:
        """Progress, desired state, set point and begin of the run after a sample; the inputs may be unconnected."""
        before = _progress(state)
        begin = float(state[_BEGIN_ENTRY])
        time = float(times[0]) - begin
        observation = GripObservation(time, *(np.nan if u is None else float(u[0]) for u in (opening, torque)))
        progress = self.rules.step(before, observation)
        if progress.phase == self._over:
            return np.concatenate([progress, state[_PROGRESS_ENTRIES.stop :]])
        desired = _desired_state(self.phases[progress.phase], time + self._period - progress.began)
        return np.concatenate([progress, desired, [self.rules.opening(progress), begin]])

    def _end_run(self, context: Context) -> EventStatus | None:
        state = self._read["state"](context)
        if state[_PHASE_ENTRY] < self._over:
            return None
        since_end = context.get_time() - state[_BEGIN_ENTRY] - _progress(state).began
        return EventStatus.ReachedTermination(self, "the task is over") if since_end < 1.5 * self._period else None


def _progress(state: Array) -> Progress:
    phase, outcome, *numbers = state[_PROGRESS_ENTRIES].tolist()
    return Progress(int(phase), int(outcome), *numbers)


def _desired_state(phase: Phase, since: float) -> Array:
    """Positions and velocities of the joints `since` s after the phase began; they stay at rest after the motion."""
    if since >= phase.duration:
        positions = phase.motion.value(phase.duration)[:, 0]
        return np.concatenate([positions, np.zeros_like(positions)])
    return np.concatenate([phase.motion.value(since)[:, 0], phase.motion.EvalDerivative(since, 1)[:, 0]])
