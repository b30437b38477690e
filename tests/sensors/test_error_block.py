"""ErrorBlock and ReadingErrorBlock: the same numbers as for a recording, without a sample of delay of their own."""

import numpy as np
import pytest
from pydrake.common import RandomDistribution, RandomGenerator
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import DiagramBuilder
from pydrake.systems.primitives import LogVectorOutput, RandomSource, TrajectorySource
from pydrake.trajectories import PiecewisePolynomial

from soft_gripper.sensors.response_curve import ResponseCurve
from soft_gripper.sensors.sensor_block import SensorBlock
from soft_gripper.sensors.sensor_layout import SensorLayout
from soft_gripper.sensors.strain_errors import RUN_DRAWS, Draws, ReadingErrorBlock, StrainErrors, disturb

PERIOD, SAMPLES = 0.01, 60
ERRORS = StrainErrors(
    *(0.1, 0.3, 0.02, 0.01, 1e-3, 1e-3, 1e-3, 2.0, 2e-3), (0.9, 1.09), 1e-4, 2, dropout=0.1, dead=(1,)
)


@pytest.fixture
def layout(shipped_finger):
    return SensorLayout(shipped_finger, 3, response=ResponseCurve(((0.9, -0.3), (1.0, 0.0), (1.1, 0.2))))


def disturbed_ramp(layout, errors, seed):
    """Ideal and disturbed readings of steadily moved joints between the samples, (T, R) each, and the draws."""
    builder = DiagramBuilder()
    motion = PiecewisePolynomial.FirstOrderHold([0.0, 1.0], np.linspace([0.0] * 12, [0.3] * 12, 2).T)
    source = builder.AddSystem(TrajectorySource(motion))
    sensor = builder.AddSystem(SensorBlock(layout, PERIOD))
    block = builder.AddSystem(ReadingErrorBlock(layout, errors, PERIOD))
    normal = block.GetInputPort("standard_normal")
    random = builder.AddSystem(RandomSource(RandomDistribution.kGaussian, normal.size(), PERIOD))
    builder.Connect(source.get_output_port(), sensor.get_input_port())
    builder.Connect(sensor.GetOutputPort("strain"), block.GetInputPort("ideal_strain"))
    builder.Connect(random.get_output_port(), normal)
    ports = sensor.GetOutputPort("strain"), block.GetOutputPort("strain"), random.get_output_port()
    logs = [LogVectorOutput(port, builder, PERIOD) for port in ports]
    simulator = Simulator(builder.Build())
    context = simulator.get_mutable_context()
    random.SetRandomContext(random.GetMyMutableContextFromRoot(context), RandomGenerator(seed))
    simulator.Initialize()
    simulator.AdvanceTo(PERIOD * (SAMPLES + 0.5))
    # A log at a time still shows the sample before: the first one twice.
    strain, disturbed, draws = (log.FindLog(context).data().T for log in logs)
    return strain[1:], disturbed[1:], draws.reshape(len(draws), -1, layout.readings)


def test_a_block_gives_what_a_recording_does(layout):
    strain, disturbed, draws = disturbed_ramp(layout, ERRORS, seed=1)
    used = Draws(draws[0, :RUN_DRAWS], np.concatenate([draws[:1], draws[2:]])[:, RUN_DRAWS:])
    expected = layout.response.reading(disturb(ERRORS, layout.response.ratio(strain), PERIOD, used))
    assert len(strain) == SAMPLES
    assert np.isnan(expected[:, 1]).all()
    assert np.isfinite(np.delete(expected, 1, axis=1)).mean() > 0.8
    np.testing.assert_allclose(disturbed, expected, rtol=0, atol=1e-12)
