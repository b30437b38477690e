"""LogSource: every sample at its time, and the last one from then on."""

import numpy as np
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import DiagramBuilder

from soft_gripper.diagrams.recording import add_logs, read_logs
from soft_gripper.extras.hardware.replay.arm_estimation import LogSource


def test_samples_at_their_times():
    samples = np.arange(300.0).reshape(100, 3)
    builder = DiagramBuilder()
    source = builder.AddSystem(LogSource("wires", samples, 0.02, "m", wire=range(3)))
    logs = add_logs(builder, {"wires": source.get_output_port()}, 0.02)
    simulator = Simulator(builder.Build())
    simulator.AdvanceTo(2.5)
    recording = read_logs(logs, simulator.get_context())
    # A logged value is what a reader finds at that time: the sample before.
    expected = samples[np.minimum(np.maximum(np.arange(126) - 1, 0), 99)]
    np.testing.assert_array_equal(recording["wires"].values, expected)
    assert recording["wires"].attrs["units"] == "m"
