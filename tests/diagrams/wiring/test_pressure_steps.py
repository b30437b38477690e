"""The pressure of every finger, step by step."""

import numpy as np
import pytest
from refusals import refused

from soft_gripper.diagrams.wiring.drive import pressure_steps, step_source
from soft_gripper.scenario.schema import PressureConfig, Scenario, SensorConfig


def scenario(**steps):
    """Steps of 0.5 s."""
    return Scenario(pressure=PressureConfig(steps=steps, settle=0.3, hold_samples=10), sensor=SensorConfig(period=0.02))


def test_a_finger_has_its_own_steps_or_those_of_all():
    both = scenario(all=[1.0, 2.0], left=[3.0, 4.0])
    assert pressure_steps(both.pressure, "left").tolist() == [3.0, 4.0]
    assert pressure_steps(both.pressure, "right").tolist() == [1.0, 2.0]


def test_a_short_list_holds_its_last_value():
    longest = scenario(all=[5.0, 6.0], left=[1.0, 2.0, 3.0])
    assert longest.steps == 3
    assert longest.duration == pytest.approx(1.5)
    assert pressure_steps(longest.pressure, "right").tolist() == [5.0, 6.0, 6.0]


def test_a_finger_without_steps_is_named():
    with refused("steps", "left"):
        pressure_steps(scenario(left=[1.0]).pressure, "right")


def test_source_changes_at_the_end_of_each_step():
    source = step_source(np.array([1.0, -2.0, 3.0]), 0.5)
    context = source.CreateDefaultContext()

    def at(time):
        context.SetTime(time)
        return source.get_output_port().Eval(context).item()

    times = [0.0, 0.499, 0.5, 0.999, 1.0, 1.499, 1.5, 9.0]
    np.testing.assert_array_equal([at(t) for t in times], [1, 1, -2, -2, 3, 3, 3, 3])
