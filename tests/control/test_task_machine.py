"""TaskMachine: what it puts out, and when, while it is led through a short task."""

import numpy as np
import pytest
from pydrake.systems.analysis import Simulator, SimulatorStatus
from pydrake.trajectories import PiecewisePolynomial

from soft_gripper.control.task import QUIET_TIME, Outcome, Phase, Rules, TaskMachine

T = 0.01  # s
START, OVER_THERE, HOME = np.array([0.0, 1.0]), np.array([0.3, -0.5]), np.array([-0.2, 0.4])  # rad
OPEN, NARROW = 0.1, 0.03  # m
HARD = 0.05  # N m
# Phases: there, grasp, back, and the rescue. A linear motion does not end at rest by itself.
THERE = PiecewisePolynomial.FirstOrderHold([0.0, 0.2], np.array([START, OVER_THERE]).T)
STAY = PiecewisePolynomial.FirstOrderHold([0.0, 0.1], np.array([OVER_THERE, OVER_THERE]).T)
BACK = PiecewisePolynomial.CubicWithContinuousSecondDerivatives(
    [0.0, 0.1, 0.3], np.array([OVER_THERE, START, HOME]).T, np.zeros((2, 1)), np.zeros((2, 1))
)
PHASES = (
    Phase("there", THERE, OPEN, 1, rest=0.05),
    Phase("grasp", STAY, NARROW, 2, until="grasped", rescue=3),
    Phase("back", BACK, NARROW, 4),
    Phase("let go", STAY, OPEN, 4),
)


class Run:
    """A machine in a simulator, and what is fed to it."""

    def __init__(self, machine=None):
        self.machine = machine or TaskMachine(Rules(PHASES, threshold=0.02, timeout=2.0), T)
        self.simulator = Simulator(self.machine)
        self.context = self.simulator.get_mutable_context()
        self.observe(OPEN, 0.0)

    def observe(self, opening, torque):
        self.machine.GetInputPort("opening").FixValue(self.context, [opening])
        self.machine.GetInputPort("torque").FixValue(self.context, [torque])
        return self

    def sample(self, number):
        """Advances to the middle between a sample and the next."""
        self.simulator.AdvanceTo((number + 0.5) * T)
        return self

    def __getitem__(self, port):
        value = self.machine.GetOutputPort(port).Eval(self.context).copy()
        return value if port == "desired_state" else value[0]

    @property
    def outputs(self):
        return [*self["desired_state"], self["set_point"], self["phase"], self["outcome"]]


def samples_of(duration):
    return round(duration / T)


@pytest.fixture(scope="module")
def course():
    """What is put out after every sample of a task that succeeds: sample, phase, desired state, set point."""
    run, course = Run(), []
    for number in range(samples_of(2.0)):
        course.append((number, int(run.sample(number)["phase"]), run["desired_state"], run["set_point"]))
        run.observe(NARROW, HARD if course[-1][1] else 0.0)
    assert run["outcome"] == Outcome.DONE
    return course


def test_phases_follow_one_another(course):
    phases = [phase for _, phase, *_ in course]
    assert sorted(phases) == phases
    lasting = [phases.count(number) * T for number in range(3)]
    # Motion and rest; motion and quiet; motion.
    np.testing.assert_allclose(lasting, [0.25, QUIET_TIME, 0.3], atol=2.1 * T)
    assert phases[-1] == len(PHASES)


@pytest.mark.parametrize("phase", [0, 1, 2])
def test_desired_state_is_that_of_the_end_of_the_sample(course, phase):
    motion = PHASES[phase].motion
    own = [(number, desired) for number, current, desired, _ in course if current == phase]
    began = own[0][0]
    for number, desired in own:
        since = (number - began + 1) * T
        if since < motion.end_time() - 1e-9:
            expected = [*motion.value(since)[:, 0], *motion.EvalDerivative(since)[:, 0]]
        else:
            expected = [*motion.value(motion.end_time())[:, 0], 0.0, 0.0]
        np.testing.assert_allclose(desired, expected, atol=1e-9)
    assert np.abs([desired for _, desired in own]).max() > 0.3


def test_the_arm_rests_where_the_task_ends(course):
    for _, phase, desired, _ in course:
        if phase == len(PHASES):
            np.testing.assert_allclose(desired, [*HOME, 0.0, 0.0], atol=1e-12)


def test_set_points_are_those_of_the_phases_and_the_last_one_stays(course):
    for _, phase, _, set_point in course:
        assert set_point == PHASES[min(phase, 2)].opening


def test_a_failure_opens_the_fingers_and_is_put_out():
    run = Run().sample(samples_of(0.27))
    assert (run["phase"], run["set_point"]) == (1, NARROW)
    run.observe(NARROW, 0.0).sample(samples_of(0.27 + QUIET_TIME + 2 * T))
    assert (run["phase"], run["set_point"], run["outcome"]) == (3, OPEN, Outcome.NOTHING_GRASPED)
    assert not run.machine.is_over(run.context)
    run.sample(samples_of(1.0))
    assert (run["phase"], run["outcome"]) == (len(PHASES), Outcome.NOTHING_GRASPED)
    assert run.machine.is_over(run.context)


def test_a_simulator_ends_with_the_task_and_goes_on_when_it_is_advanced_again():
    run = Run()
    status = run.simulator.AdvanceTo(10.0)
    assert status.reason() == SimulatorStatus.ReturnReason.kReachedTerminationCondition
    assert "the task is over" in status.FormatMessage()
    assert run["phase"] == len(PHASES)
    end = run.context.get_time()
    assert end == pytest.approx(run.machine.progress(run.context).began + T)
    assert run.simulator.AdvanceTo(10.0).reason() == SimulatorStatus.ReturnReason.kReachedBoundaryTime


def test_a_task_that_does_not_command_the_gripper_needs_no_inputs():
    machine = TaskMachine(Rules((Phase("there", THERE, np.nan, 1), Phase("back", BACK, np.nan, 2)), 0.02, 2.0), T)
    simulator = Simulator(machine)
    simulator.AdvanceTo(1.0)
    context = simulator.get_context()
    assert machine.GetOutputPort("outcome").Eval(context) == [Outcome.DONE]
    assert np.isnan(machine.GetOutputPort("set_point").Eval(context)).all()
    np.testing.assert_allclose(machine.GetOutputPort("desired_state").Eval(context), [*HOME, 0.0, 0.0], atol=1e-12)
