"""What an action sets."""

import numpy as np
import pytest
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import DiagramBuilder
from pydrake.systems.primitives import PassThrough
from refusals import refused

from soft_gripper.extras.learning.config import ActionConfig
from soft_gripper.extras.learning.station import add_action, resting_action

CONFIG = ActionConfig(range=[-20e3, 100e3], rest=10e3, joints={"z": [0.0, 0.2]}, settling=0.1)
HOME = {"x": 0.3, "z": 0.05}


@pytest.fixture
def diagram():
    """An action with sinks for the grip and the joints x and z, and its simulator."""
    builder = DiagramBuilder()
    grip, desired = builder.AddNamedSystem("grip", PassThrough(1)), builder.AddNamedSystem("desired", PassThrough(4))
    add_action(builder, CONFIG, [grip.get_input_port()], desired.get_input_port(), HOME, 0.01)
    builder.ExportOutput(grip.get_output_port(), "grip")
    builder.ExportOutput(desired.get_output_port(), "desired")
    return builder.Build()


def begun(diagram, action):
    simulator = Simulator(diagram)
    diagram.GetInputPort("action").FixValue(simulator.get_mutable_context(), action)
    simulator.Initialize()
    return simulator, simulator.get_context()


@pytest.mark.parametrize(("number", "pressure"), [(-1, -20e3), (0, 40e3), (1, 100e3)])
def test_the_grip_follows_at_once(diagram, number, pressure):
    _, context = begun(diagram, [number, 0.0])
    assert diagram.GetOutputPort("grip").Eval(context) == pytest.approx(pressure)


def test_joints_go_to_their_set_points_critically_damped(diagram):
    """From rest: q = r - (r - q0) (1 + t / T) exp(-t / T), with its derivative; a joint without a number stays."""
    simulator, context = begun(diagram, [0.0, 1.0])
    for time in (0.1, 0.25, 0.6):
        simulator.AdvanceTo(time)
        fade = time / 0.1
        position = 0.2 - 0.15 * (1 + fade) * np.exp(-fade)
        velocity = 0.15 * fade * np.exp(-fade) / 0.1
        np.testing.assert_allclose(
            diagram.GetOutputPort("desired").Eval(context), [0.3, position, 0.0, velocity], atol=1e-9
        )


def test_the_resting_action_moves_nothing(diagram):
    simulator, context = begun(diagram, resting_action(CONFIG, HOME))
    simulator.AdvanceTo(0.5)
    np.testing.assert_allclose(diagram.GetOutputPort("desired").Eval(context), [0.3, 0.05, 0, 0], atol=1e-12)
    assert diagram.GetOutputPort("grip").Eval(context) == pytest.approx(10e3)


def test_a_joint_that_is_not_there_is_refused():
    builder = DiagramBuilder()
    desired = builder.AddSystem(PassThrough(2)).get_input_port()
    with refused("joints", "z"):
        add_action(
            builder,
            CONFIG,
            [],
            desired,
            {
                "y": 0.0,
            },
            0.01,
        )


def test_a_home_beyond_what_actions_reach_rests_at_the_limit():
    np.testing.assert_array_equal(resting_action(CONFIG, {"x": 0.3, "z": 0.25}), [-0.5, 1.0])
