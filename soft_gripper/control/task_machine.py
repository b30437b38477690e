"""TaskMachine: takes arm and fingers through the phases of a task."""

import numpy as np
from pydrake.systems.framework import Context, DiscreteValues, InputPort, LeafSystem

from soft_gripper.arrays import Array
from soft_gripper.control.task_phases import GripObservation, Outcome, Phase, Progress, Rules
from soft_gripper.signals import describe

_PROGRESS, _DESIRED, _SET_POINT, _PHASE, _OUTCOME = range(5)  # groups of the discrete state


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
    """

    def __init__(self, rules: Rules, period: float):
        """Follows the phases of `rules`; samples every `period` s."""
        super().__init__()
        self._rules, self._period = rules, period
        self._opening = self.DeclareVectorInputPort("opening", 1)
        self._torque = self.DeclareVectorInputPort("torque", 1)
        self.DeclareDiscreteState(np.array(Progress(), dtype=float))
        first = rules.phases[0]
        ports = {
            name: self.DeclareStateOutputPort(name, self.DeclareDiscreteState(value))
            for name, value in (
                ("desired_state", _desired_state(first, 0.0)),
                ("set_point", np.array([first.opening])),
                ("phase", np.zeros(1)),
                ("outcome", np.zeros(1)),
            )
        }
        describe(ports["set_point"], "m")
        describe(ports["phase"], meanings=[*(phase.name for phase in rules.phases), "over"])
        describe(ports["outcome"], meanings=[outcome.words for outcome in Outcome])
        self.DeclarePeriodicDiscreteUpdateEvent(period, 0.0, self._update)

    @property
    def phases(self) -> tuple[Phase, ...]:
        """Of the task, rescues too."""
        return self._rules.phases

    def progress(self, context: Context) -> Progress:
        """How far the task has come, from the context of this block."""
        phase, outcome, *others = context.get_discrete_state(_PROGRESS).value()
        return Progress(int(phase), int(outcome), *others)

    def is_over(self, context: Context) -> bool:
        """Whether no phase is left, from the context of this block."""
        return self.progress(context).phase == len(self.phases)

    def _update(self, context: Context, values: DiscreteValues) -> None:
        time = context.get_time()
        observed = GripObservation(time, _value(self._opening, context), _value(self._torque, context))
        progress = self._rules.step(self.progress(context), observed)
        values.set_value(_PROGRESS, np.array(progress, dtype=float))
        if progress.phase < len(self.phases):
            desired = _desired_state(self.phases[progress.phase], time + self._period - progress.began)
            values.set_value(_DESIRED, desired)
            values.set_value(_SET_POINT, [self._rules.opening(progress)])
        values.set_value(_PHASE, [progress.phase])
        values.set_value(_OUTCOME, [progress.outcome])


def _value(port: InputPort, context: Context) -> float:
    return float(port.Eval(context)[0]) if port.HasValue(context) else np.nan


def _desired_state(phase: Phase, since: float) -> Array:
    """Positions and velocities of the joints `since` s after the phase began; they rest when its motion is over."""
    if since >= phase.duration:
        positions = phase.motion.value(phase.duration)[:, 0]
        return np.concatenate([positions, np.zeros_like(positions)])
    return np.concatenate([phase.motion.value(since)[:, 0], phase.motion.EvalDerivative(since, 1)[:, 0]])
