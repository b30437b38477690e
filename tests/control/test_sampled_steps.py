"""SampledSteps: one value after the other, changing with the samples only."""

import pytest
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import DiagramBuilder, LeafSystem

from soft_gripper.control.grip import SampledSteps

PERIOD = 0.01  # s
VALUES = (3.0, -1.0, 4.0, -1.5)


class Follower(LeafSystem):
    """Python code behind the source, which counts how often it is called."""

    def __init__(self):
        super().__init__()
        self.calls = 0
        self.port = self.DeclareVectorInputPort("value", 1)
        ticket = {self.port.ticket()}
        self.DeclareVectorOutputPort("value", 1, self._calc, ticket)

    def _calc(self, context, output):
        self.calls += 1
        output.SetFromVector(self.port.Eval(context))


class Run:
    """A source that a follower reads, under way."""

    def __init__(self, values, duration):
        builder = DiagramBuilder()
        source = builder.AddSystem(SampledSteps(values, duration, PERIOD))
        self.follower = builder.AddSystem(Follower())
        builder.Connect(source.GetOutputPort("value"), self.follower.get_input_port())
        self.simulator = Simulator(builder.Build())
        self.simulator.Initialize()

    def read(self, time):
        self.simulator.AdvanceTo(time)
        context = self.follower.GetMyContextFromRoot(self.simulator.get_context())
        (value,) = self.follower.get_output_port().Eval(context)
        return value


@pytest.mark.parametrize("samples", [1, 3, 7, 29])
def test_every_value_lasts_so_many_samples_and_the_last_for_ever(samples):
    run = Run(VALUES, samples * PERIOD)
    read = [run.read((k + 0.5) * PERIOD) for k in range(6 * samples)]
    assert read == [VALUES[min(k // samples, 3)] for k in range(6 * samples)]


def test_what_follows_is_called_once_a_sample():
    run = Run(VALUES, 3 * PERIOD)
    for tenth in range(1, 100):
        run.read(0.1 * tenth * PERIOD)
    assert run.follower.calls == 10
