"""LowSelector, alone and between two PIDs of which one takes over from the other."""

from typing import NamedTuple

import numpy as np
import pytest
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import DiagramBuilder
from pydrake.systems.primitives import (
    ConstantVectorSource,
    FirstOrderLowPassFilter,
    LogVectorOutput,
    TrajectorySource,
    ZeroOrderHold,
)
from pydrake.trajectories import PiecewisePolynomial

from soft_gripper.arrays import Array
from soft_gripper.control.grip import LowSelector
from soft_gripper.control.pid_controller import PidController, PidGains

T = 0.01  # s
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
