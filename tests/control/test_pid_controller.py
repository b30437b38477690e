"""The PID controller against closed forms, and the lower of two."""

from typing import NamedTuple

import numpy as np
import pytest
from pydrake.systems import controllers
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import DiagramBuilder
from pydrake.systems.primitives import (
    ConstantVectorSource,
    FirstOrderLowPassFilter,
    LogVectorOutput,
    Multiplexer,
    Sine,
    TrajectorySource,
    ZeroOrderHold,
)
from pydrake.trajectories import PiecewisePolynomial

from soft_gripper.arrays import Array
from soft_gripper.control.grip import LowSelector
from soft_gripper.control.pid_controller import PidController, PidGains

T = 0.01
NAN = np.nan


def outputs(gains, set_points, measurements, initial_output=0.0, limit=1e3, applied=()):
    """The output at every sample; `applied` of every sample, if anything is to be connected there."""
    pid = PidController(gains, T, -limit, limit, initial_output)
    simulator = Simulator(pid)
    context = simulator.get_mutable_context()
    given = []
    for sample, (set_point, measurement) in enumerate(np.broadcast(set_points, measurements)):
        if len(applied):
            pid.GetInputPort("applied").FixValue(context, [applied[sample]])
        pid.GetInputPort("set_point").FixValue(context, [set_point])
        pid.GetInputPort("measurement").FixValue(context, [measurement])
        if sample == 0:
            simulator.Initialize()
        given.append(pid.GetOutputPort("output").Eval(context)[0])
        simulator.AdvanceTo((sample + 0.5) * T)
    return np.array(given)


def deviation(period):
    """Largest difference from Drake's PidController on a sine, well after the start."""
    kp, ki, kd, set_point = 2.0, 5.0, 0.3, 0.4
    gains = PidGains(kp, ki, kd, derivative_filter=0.0)
    builder = DiagramBuilder()
    sine = builder.AddSystem(Sine(1.0, 3.0, 0.0, 1))
    state = builder.AddSystem(Multiplexer(2))
    desired = builder.AddSystem(ConstantVectorSource([set_point, 0.0]))
    drake = builder.AddSystem(controllers.PidController(kp=[kp], ki=[ki], kd=[kd]))
    hold = builder.AddSystem(ZeroOrderHold(period, 1))
    ours = builder.AddSystem(PidController(gains, period, -100, 100, initial_output=kp * set_point))
    target = builder.AddSystem(ConstantVectorSource([set_point]))
    for i in range(2):
        builder.Connect(sine.get_output_port(i), state.get_input_port(i))
    builder.Connect(state.get_output_port(), drake.get_input_port_estimated_state())
    builder.Connect(desired.get_output_port(), drake.get_input_port_desired_state())
    builder.Connect(sine.get_output_port(0), hold.get_input_port())
    builder.Connect(hold.get_output_port(), ours.GetInputPort("measurement"))
    builder.Connect(target.get_output_port(), ours.GetInputPort("set_point"))
    logs = [LogVectorOutput(block.get_output_port(), builder, period) for block in (drake, ours)]
    simulator = Simulator(builder.Build())
    simulator.get_mutable_integrator().set_maximum_step_size(1e-3)
    simulator.AdvanceTo(2.0)
    drakes, own = (log.FindLog(simulator.get_context()).data()[0] for log in logs)
    return np.abs(drakes - own)[int(0.1 / period) :].max()


def test_small_samples_converge_to_drakes_pid_in_first_order():
    errors = [deviation(period) for period in (0.02, 0.01, 0.005)]
    assert errors[-1] < 0.05
    assert errors[0] / errors[1] == pytest.approx(2, rel=0.1)
    assert errors[1] / errors[2] == pytest.approx(2, rel=0.1)


@pytest.mark.parametrize("error", [0.0, 0.3, -0.3])
def test_follows_what_is_applied_instead(error):
    """What it asks for settles where back-calculation balances the error: v - applied = tracking_time ki e."""
    gains = PidGains(kp=3.0, ki=10.0, tracking_time=0.2)
    given = outputs(gains, error, np.zeros(400), applied=np.full(400, 5.0))
    assert given[-1] == pytest.approx(5 + 0.2 * 10 * error, abs=1e-6)
    # First order, by 1 - T / tracking_time a sample.
    left = np.abs(given - given[-1])
    np.testing.assert_allclose(left[1:100] / left[:99], 1 - T / 0.2, rtol=1e-6)


@pytest.mark.parametrize("gains", [PidGains(3.0, 2.0, 1.0), PidGains(-3.0, -2.0, -1.0)], ids=["direct", "reverse"])
def test_start_is_bumpless(gains):
    given = outputs(gains, 0.7, np.full(3, 0.2), initial_output=4.0)
    np.testing.assert_allclose(given, 4 + gains.ki * 0.5 * T * np.arange(3), rtol=1e-12)


def test_derivative_is_of_the_measurement_alone():
    gains = PidGains(kd=2.0, derivative_filter=0.04)
    assert not outputs(gains, [0.0, 1.0, -3.0, 5.0], 0.0).any()
    step = outputs(gains, 0.0, np.r_[0.0, np.ones(60)])
    # A first-order filter: a kick of kd / (filter + T) against the step, which decays by filter / (filter + T).
    np.testing.assert_allclose(step[1:], -2 / 0.05 * 0.8 ** np.arange(60), rtol=1e-12)


def test_without_a_measurement_the_output_is_held():
    measurements = np.r_[0.0, 0.1, 0.2, [NAN] * 5, 0.2, 0.3]
    gains = PidGains(2.0, 3.0, 0.1)
    given = outputs(gains, 1.0, measurements)
    np.testing.assert_array_equal(given[3:8], given[2])
    # Nothing of the gap is remembered: what follows is what would have followed without it.
    without = outputs(gains, 1.0, measurements[np.isfinite(measurements)])
    np.testing.assert_array_equal(given[8:], without[3:])


@pytest.mark.parametrize("port", ["set_point", "measurement", "applied"])
@pytest.mark.parametrize("hostile", [[NAN, np.inf, -np.inf], [1e308], [-1e308, 1e308]])
def test_numbers_that_are_not_finite_or_overflow_leave_nothing_behind(port, hostile):
    """The output stays within its limits, and follows from the inputs again."""
    gains = PidGains(2.0, 5.0, 10.0 * T, derivative_filter=0.0)
    signals = {"set_point": np.full(12, 0.4), "measurement": np.linspace(0, 0.1, 12), "applied": np.full(12, 0.2)}
    signals[port][4 : 4 + len(hostile)] = hostile
    found = outputs(gains, signals["set_point"], signals["measurement"], applied=signals["applied"])
    assert np.abs(found).max() <= 1e3
    assert len(set(found[-4:])) > 1


GAINS = PidGains(kp=1.0, ki=20.0, tracking_time=0.1)
LOW, LIMIT, HIGH = 0.5, 1.0, 2.0  # what the first is to follow rises slowly from below the limit and falls back
RISE, TOP, FALL, END = 2.0, 4.0, 6.0, 8.0  # s


class Course(NamedTuple):
    """Outputs of both PIDs, the lower of them, and the value that it leads to, all at every sample."""

    first: Array
    second: Array
    selected: Array
    value: Array


def override_control(is_fed_back):
    """Two PIDs command one lag. The first follows a course; the second limits the value to LIMIT."""
    builder = DiagramBuilder()
    plant = builder.AddSystem(FirstOrderLowPassFilter(0.1))
    value = builder.AddSystem(ZeroOrderHold(T, 1))
    selector = builder.AddSystem(LowSelector())
    builder.Connect(selector.get_output_port(), plant.get_input_port())
    builder.Connect(plant.get_output_port(), value.get_input_port())
    rise = [0.0, RISE, TOP, FALL, FALL + T / 2, END]
    course = PiecewisePolynomial.FirstOrderHold(rise, [[LOW, LOW, HIGH, HIGH, LOW, LOW]])
    pids = []
    for name, target in (("first", TrajectorySource(course)), ("second", ConstantVectorSource([LIMIT]))):
        pid = builder.AddSystem(PidController(GAINS, T, -10.0, 10.0))
        set_point = builder.AddSystem(target)
        builder.Connect(set_point.get_output_port(), pid.GetInputPort("set_point"))
        builder.Connect(value.get_output_port(), pid.GetInputPort("measurement"))
        builder.Connect(pid.get_output_port(), selector.GetInputPort(name))
        if is_fed_back:
            builder.Connect(selector.get_output_port(), pid.GetInputPort("applied"))
        pids.append(pid)
    logs = [LogVectorOutput(block.get_output_port(), builder, T) for block in (*pids, selector, value)]
    simulator = Simulator(builder.Build())
    simulator.AdvanceTo(END)
    return Course(*(log.FindLog(simulator.get_context()).data()[0] for log in logs))


@pytest.fixture(scope="module")
def informed():
    return override_control(is_fed_back=True)


@pytest.fixture(scope="module")
def uninformed():
    return override_control(is_fed_back=False)


def at(time):
    """Number of the last sample before a time."""
    return round(time / T) - 1


def test_each_is_heard_in_its_turn(informed):
    assert informed.value[at(RISE)] == pytest.approx(LOW, abs=1e-3)
    assert informed.value[at(FALL)] == pytest.approx(LIMIT, abs=1e-3)
    assert informed.value[-1] == pytest.approx(LOW, abs=1e-3)
    assert informed.first[at(RISE)] < informed.second[at(RISE)]
    assert informed.second[at(FALL)] < informed.first[at(FALL)]
    np.testing.assert_array_equal(informed.selected, np.minimum(informed.first, informed.second))


def test_the_one_that_is_not_heard_stays_near_what_is_applied(informed):
    """Its integral rests where back-calculation balances its error: v - u = tracking_time ki e."""
    for unheard, time, target in ((informed.second, RISE, LIMIT), (informed.first, FALL, HIGH)):
        k = at(time)
        distance = GAINS.tracking_time * GAINS.ki * (target - informed.value[k])
        assert unheard[k] - informed.selected[k] == pytest.approx(distance, rel=0.01)


def test_the_second_takes_over_without_a_bump(informed):
    """The output goes on as it went before, and the value hardly leaves the limit."""
    begin = at(RISE) + 20
    takes_over = begin + np.argmax(informed.second[begin:] < informed.first[begin:])
    assert RISE < takes_over * T < TOP
    changes = np.abs(np.diff(informed.selected))
    assert changes[takes_over - 1 :][: round(1 / T)].max() < 1.1 * changes[begin : takes_over - 1].max()
    assert informed.value[: at(FALL)].max() < 1.05 * LIMIT


def test_the_first_takes_over_again_at_once(informed, uninformed):
    for course, is_late in ((informed, False), (uninformed, True)):
        back = course.value[at(FALL) :] < LOW + 0.1 * (LIMIT - LOW)
        assert (np.argmax(back) * T > 0.4) == is_late
