"""SensorBlock: samples at initialization and at its period, and holds in between."""

import numpy as np
import pytest
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import DiagramBuilder
from pydrake.systems.primitives import TrajectorySource
from pydrake.trajectories import PiecewisePolynomial

from soft_gripper.sensors.response_curve import ResponseCurve
from soft_gripper.sensors.sensor_block import SensorBlock
from soft_gripper.sensors.sensor_layout import SensorLayout, extension_ratios

PERIOD = 0.01  # s
START, RATE = np.linspace(0.1, 0.2, 12), np.linspace(-1.0, 1.0, 12)  # rad, rad/s


def angles(time):
    """Joints that move steadily, rad."""
    return START + RATE * time


@pytest.fixture
def ramp(shipped_finger):
    """A sensor on joints that move as `angles` says: its simulator, and what its ports read now."""
    curve = ResponseCurve(((0.9, -0.3), (1.0, 0.0), (1.1, 0.2)))
    layout = SensorLayout(shipped_finger, 3, response=curve)
    builder = DiagramBuilder()
    motion = PiecewisePolynomial.FirstOrderHold([0.0, 1.0], np.column_stack([angles(0), angles(1)]))
    source = builder.AddSystem(TrajectorySource(motion))
    sensor = builder.AddSystem(SensorBlock(layout, PERIOD))
    builder.Connect(source.get_output_port(), sensor.get_input_port())
    simulator = Simulator(builder.Build())

    def read():
        context = sensor.GetMyContextFromRoot(simulator.get_context())
        return [sensor.get_output_port(i).Eval(context) for i in range(2)]

    return simulator, read, layout


@pytest.mark.parametrize(
    ("time", "sampled_at"), [(0.0, 0.0), (0.0049, 0.0), (0.0099, 0.0), (0.0101, 0.01), (0.1234, 0.12)]
)
def test_samples_at_its_period_and_holds_in_between(ramp, time, sampled_at):
    simulator, read, layout = ramp
    simulator.Initialize()
    simulator.AdvanceTo(time)
    ratios, strain = read()
    np.testing.assert_allclose(ratios, extension_ratios(layout, angles(sampled_at)), rtol=0, atol=1e-13)
    np.testing.assert_array_equal(strain, layout.response.reading(ratios))
