"""The pressure of every finger, step by step."""

import numpy as np
import pytest
from pydrake.systems.analysis import Simulator
from refusals import refused

from soft_gripper.diagrams.wiring.drive import StepSource, pressure_steps
from soft_gripper.scenario.schema import PressureConfig, Scenario, SensorConfig


def scenario(**steps):
    """Steps of 0.5 s."""
    return Scenario(pressure=PressureConfig(steps=steps, settle=0.3, hold_samples=10), sensor=SensorConfig(period=0.02))


def test_a_finger_has_its_own_steps_or_those_of_all():
    both = scenario(all=[1.0, 2.0], left=[3.0, 4.0])
    assert pressure_steps(both.pressure, "left").tolist() == [3.0, 4.0]
    assert pressure_steps(both.pressure, "right").tolist() == [1.0, 2.0]


def test_a_finger_without_steps_is_named():
    with refused("steps", "left"):
        pressure_steps(scenario(left=[1.0]).pressure, "right")


TIMES = [0.0, 0.3, 0.499, 0.5, 0.999, 1.0, 1.499, 1.5, 9.0]
VALUES = [0.1, 0.1, 0.1, -2.7, -2.7, 3.3, 3.3, 3.3, 3.3]


def value(source, context, time):
    context.SetTime(time)
    return source.get_output_port().Eval(context).item()


@pytest.mark.parametrize("begin", [0.0, 0.1, 10.0, 12.34])
def test_steps_count_from_the_beginning_of_a_run(begin):
    source = StepSource(np.array([0.1, -2.7, 3.3]), 0.5)
    simulator = Simulator(source)
    context = simulator.get_mutable_context()
    context.SetTime(begin)
    simulator.Initialize()
    np.testing.assert_array_equal([value(source, context, begin + t) for t in TIMES], VALUES)
    context.SetTime(begin + 0.7)
    Simulator(source, context).Initialize()  # goes on
    assert value(source, context, begin + 0.7) == -2.7
