"""TaskMachine: leads arm and fingers through the phases of a task."""

from collections.abc import Iterator
from dataclasses import dataclass
from enum import IntEnum
from functools import cached_property
from typing import NamedTuple

import numpy as np
from pydrake.systems.framework import Context, DiscreteValues, EventStatus, InputPort, LeafSystem
from pydrake.trajectories import Trajectory

from soft_gripper.arrays import Array
from soft_gripper.run_begin import since_begin
from soft_gripper.signals import describe

QUIET_BAND = 5e-4  # m, the default band of the opening ...
QUIET_TIME = 0.2  # s, ... and the time within it, for fingers at rest
OPENED_BAND = 2e-3  # m, around the commanded opening: a gripper at rest within this band counts as opened
GRIP_GAP = 0.1  # s, tolerated interruption of a grip
CLOSING_ALLOWANCE = 8e-3  # m, by which the gripper may close further after grasping


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
        """Duration of the motion, s."""
        return float(self.motion.end_time())


class GripObservation(NamedTuple):
    """One sample of the estimates."""

    time: float  # s
    opening: float  # m
    torque: float  # N m, opening torque on the fingers


class Progress(NamedTuple):
    """Progress of a task: its whole state between samples."""

    phase: int = 0  # the number of phases: the task is over
    outcome: int = Outcome.RUNNING
    began: float = 0.0  # s, the phase
    around: float = np.inf  # m, the opening near which the gripper has stayed ...
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

    def step(self, progress: Progress, observed: GripObservation) -> Progress:
        """The progress after one more sample."""
        if progress.phase == len(self.phases):
            return progress
        phase, progress = self.phases[progress.phase], self._noted(progress, observed)
        if progress.outcome == Outcome.RUNNING:
            progress = progress._replace(outcome=self._judge(phase, progress, observed))
        follower = self._follower(phase, progress, observed)
        if follower is None:
            return progress
        if follower == len(self.phases) and progress.outcome == Outcome.RUNNING:
            progress = progress._replace(outcome=Outcome.DONE)
        grasped = observed.opening if phase.until == "grasped" else progress.grasped
        began = observed.time
        return Progress(follower, progress.outcome, began, since=began, gripped=began, grasped=grasped)

    def opening(self, progress: Progress) -> float:
        """The set point of the opening, m; a failure opens the fingers at once."""
        phase = self.phases[min(progress.phase, len(self.phases) - 1)]
        if progress.outcome > Outcome.DONE and phase.rescue is not None:
            return self.phases[phase.rescue].opening
        return phase.opening

    def _noted(self, progress: Progress, observed: GripObservation) -> Progress:
        """Updates rest and grip; values that are not finite count as motion and as no grip."""
        if not abs(observed.opening - progress.around) <= self.quiet_band:
            progress = progress._replace(around=observed.opening, since=observed.time)
        held = observed.torque > self.threshold and observed.opening > progress.grasped - CLOSING_ALLOWANCE
        return progress._replace(gripped=observed.time) if held else progress

    def _judge(self, phase: Phase, progress: Progress, observed: GripObservation) -> Outcome:
        """Whether the phase has failed."""
        if phase.holds and observed.time - progress.gripped > GRIP_GAP:
            return Outcome.OBJECT_LOST
        waited = observed.time - progress.began - phase.duration
        if phase.until is not None and waited > self.timeout:
            return NOT_REACHED[phase.until]
        at_rest = waited >= 0 and self._is_quiet(progress, observed)
        empty = phase.until == "grasped" and at_rest and not observed.torque > self.threshold
        return Outcome.NOTHING_GRASPED if empty else Outcome.RUNNING

    def _follower(self, phase: Phase, progress: Progress, observed: GripObservation) -> int | None:
        """The phase that starts now, if any."""
        waited = observed.time - progress.began - phase.duration
        if waited < 0:
            return None
        if progress.outcome != Outcome.RUNNING and phase.rescue is not None:
            return phase.rescue
        if not phase.until:
            return phase.follower if waited >= phase.rest else None
        given_up = phase.rescue is None and waited > self.timeout
        return phase.follower if given_up or self._reached(phase, progress, observed) else None

    def _reached(self, phase: Phase, progress: Progress, observed: GripObservation) -> bool:
        """Whether the fingers are at rest: at the commanded opening, closed on an object, or closed on nothing."""
        if not self._is_quiet(progress, observed):
            return False
        if phase.until == "opened":
            return abs(observed.opening - phase.opening) <= OPENED_BAND
        if phase.until == "grasped":
            return observed.torque > self.threshold
        return abs(observed.torque) < self.threshold

    def _is_quiet(self, progress: Progress, observed: GripObservation) -> bool:
        return observed.time - progress.since >= QUIET_TIME


_PROGRESS, _DESIRED, _SET_POINT, _PHASE, _OUTCOME = range(5)  # groups of the discrete state


class Outputs(NamedTuple):
    """Values of the outputs of a `TaskMachine`."""

    desired_state: Array  # (2 n)
    set_point: Array  # (1) m
    phase: Array  # (1)
    outcome: Array  # (1)


class TaskMachine(LeafSystem):
    """A state machine whose transitions depend only on the estimates of the fingers.

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

    def __init__(self, rules: Rules, period: float):
        """Follows the phases of `rules`; samples every `period` s."""
        super().__init__()
        self.rules, self.period, self._over = rules, period, len(rules.phases)
        self._opening = self.DeclareVectorInputPort("opening", 1)
        self._torque = self.DeclareVectorInputPort("torque", 1)
        self.DeclareDiscreteState(np.array(Progress(), dtype=float))
        ports = {
            name: self.DeclareStateOutputPort(name, self.DeclareDiscreteState(value))
            for name, value in self.first_outputs._asdict().items()
        }
        self._since_begin = since_begin(self)
        describe(ports["set_point"], "m")
        describe(ports["phase"], meanings=[*(phase.name for phase in rules.phases), "over"])
        describe(ports["outcome"], meanings=[outcome.words for outcome in Outcome])
        self.DeclarePeriodicDiscreteUpdateEvent(period, 0.0, self._update)
        self.DeclarePeriodicPublishEvent(period, 0.0, self._end_run)

    @property
    def phases(self) -> tuple[Phase, ...]:
        """The phases of the task, including rescues."""
        return self.rules.phases

    def progress(self, context: Context) -> Progress:
        """Progress of the task, from the context of this block."""
        phase, outcome, *others = context.get_discrete_state(_PROGRESS).value()
        return Progress(int(phase), int(outcome), *others)

    def is_over(self, context: Context) -> bool:
        """Whether the task is finished, from the context of this block."""
        return self.progress(context).phase == self._over

    def unobserved(self, end: float) -> Iterator[tuple[float, Array]]:
        """Times, s, and the desired states from then on, (2 n), where no phase waits for the gripper.

        The last one is where the task is over, or `end`.
        """
        progress = Progress()
        for time in self.period * np.arange(int(end / self.period) + 1):
            progress = self.rules.step(progress, GripObservation(float(time), np.nan, np.nan))
            if progress.phase < len(self.phases):
                desired = _desired_state(self.phases[progress.phase], time + self.period - progress.began)
            yield float(time), desired
            if progress.phase == len(self.phases):
                break

    @property
    def first_outputs(self) -> Outputs:
        """The outputs when a run begins."""
        first = self.phases[0]
        return Outputs(_desired_state(first, 0.0), np.array([first.opening]), np.zeros(1), np.zeros(1))

    def outputs(self, progress: Progress, time: float, before: Outputs) -> Outputs:
        """The outputs after a sample, from those before it; `time` since the begin of the run, s."""
        desired, set_point = before.desired_state, before.set_point
        if progress.phase < len(self.phases):
            desired, set_point = self._desired(progress, time), np.array([self.rules.opening(progress)])
        return Outputs(desired, set_point, np.array([float(progress.phase)]), np.array([float(progress.outcome)]))

    def _desired(self, progress: Progress, time: float) -> Array:
        """The desired state in the sample after a time, s."""
        return _desired_state(self.phases[progress.phase], time + self.period - progress.began)

    def _update(self, context: Context, values: DiscreteValues) -> None:
        time, before = self._since_begin(context), self.progress(context)
        observed = GripObservation(time, _value(self._opening, context), _value(self._torque, context))
        progress = self.rules.step(before, observed)
        if progress != before:
            values.set_value(_PROGRESS, np.array(progress, dtype=float))
        changed = (progress.phase, progress.outcome) != (before.phase, before.outcome)
        if changed:
            values.set_value(_PHASE, [progress.phase])
            values.set_value(_OUTCOME, [progress.outcome])
        if progress.phase < self._over:
            values.set_value(_DESIRED, self._desired(progress, time))
            if changed:
                values.set_value(_SET_POINT, [self.rules.opening(progress)])

    def _end_run(self, context: Context) -> EventStatus | None:
        if context.get_discrete_state(_PHASE).value()[0] < self._over:
            return None
        since_end = self._since_begin(context) - self.progress(context).began
        return EventStatus.ReachedTermination(self, "the task is over") if since_end < 1.5 * self.period else None


def _value(port: InputPort, context: Context) -> float:
    return float(port.Eval(context)[0]) if port.HasValue(context) else np.nan


def _desired_state(phase: Phase, since: float) -> Array:
    """Positions and velocities of the joints `since` s after the phase began; they stay at rest after the motion."""
    if since >= phase.duration:
        positions = phase.motion.value(phase.duration)[:, 0]
        return np.concatenate([positions, np.zeros_like(positions)])
    return np.concatenate([phase.motion.value(since)[:, 0], phase.motion.EvalDerivative(since, 1)[:, 0]])
