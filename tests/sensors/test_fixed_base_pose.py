"""FixedBasePose: a pose that stays, and that nothing computes anew."""

import numpy as np
from pydrake.math import RigidTransform, RollPitchYaw
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import DiagramBuilder, LeafSystem

from soft_gripper.sensors.base_pose import FixedBasePose
from soft_gripper.signals import signal_of

X_WB = RigidTransform(RollPitchYaw(0.1, 0.2, 0.3), [1, 2, 3])


class Reader(LeafSystem):
    """Counts how often what follows from a pose is computed."""

    def __init__(self):
        super().__init__()
        self.calls = 0
        self.pose = self.DeclareVectorInputPort("X_WB", 12)
        self.port = self.DeclareVectorOutputPort("place", 1, self._calc, {self.pose.ticket()})
        self.DeclarePeriodicPublishEvent(0.1, 0.0, lambda context: self.port.Eval(context) and None)

    def _calc(self, context, output):
        self.calls += 1
        output.SetAtIndex(0, self.pose.Eval(context)[3])


def test_what_follows_from_it_is_computed_once():
    builder = DiagramBuilder()
    source, reader = builder.AddSystem(FixedBasePose(X_WB)), builder.AddSystem(Reader())
    builder.Connect(source.get_output_port(), reader.get_input_port())
    simulator = Simulator(builder.Build())
    simulator.AdvanceTo(1.0)
    assert reader.calls == 1
    pose = source.get_output_port().Eval(source.GetMyContextFromRoot(simulator.get_context()))
    np.testing.assert_array_equal(pose.reshape(3, 4), X_WB.GetAsMatrix34())
    assert signal_of(source.get_output_port()).unit == ("1", "1", "1", "m")
