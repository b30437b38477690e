"""Poses of the base: samples of bodies that move, and a pose that stays and that nothing computes anew."""

import numpy as np
import pytest
from pydrake.math import RigidTransform, RollPitchYaw, RotationMatrix
from pydrake.multibody.parsing import Parser
from pydrake.multibody.plant import MultibodyPlant
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import DiagramBuilder, LeafSystem

from soft_gripper.sensors.base_pose import BasePoseSensor, FixedBasePose
from soft_gripper.signals import signal_of

T = 0.01  # s
WHEEL = """<robot name="wheel"><link name="base"/>
<link name="rim"><inertial><mass value="1"/>
<inertia ixx="0.1" iyy="0.1" izz="0.1" ixy="0" ixz="0" iyz="0"/></inertial></link>
<joint name="axle" type="continuous"><parent link="base"/><child link="rim"/><origin xyz="0.1 0.2 0.3"/>
<axis xyz="0 1 0"/></joint></robot>"""
SPIN = 3.0  # rad/s


def assert_pose(entries, expected, tolerance):
    """The entries are the matrix [R | p], row after row."""
    np.testing.assert_allclose(entries, expected.GetAsMatrix34().ravel(), rtol=0, atol=tolerance)


@pytest.mark.parametrize("time_step", [T, T / 5, 0.0])
def test_body_of_a_plant(time_step):
    """A wheel that turns evenly is where it was at the last sample."""
    builder = DiagramBuilder()
    plant = builder.AddSystem(MultibodyPlant(time_step))
    Parser(plant).AddModelsFromString(WHEEL, "urdf")
    plant.WeldFrames(plant.world_frame(), plant.GetFrameByName("base"))
    if time_step:
        plant.SetUseSampledOutputPorts(False)
    plant.Finalize()
    sensor = builder.AddSystem(BasePoseSensor(plant.GetBodyByName("rim").index(), T))
    builder.Connect(plant.get_body_poses_output_port(), sensor.get_input_port())
    simulator = Simulator(builder.Build())
    context = simulator.get_mutable_context()
    plant.SetVelocities(plant.GetMyMutableContextFromRoot(context), [SPIN])
    simulator.Initialize()
    for sample in range(20):
        simulator.AdvanceTo((sample + 0.5) * T)
        X_WB = sensor.get_output_port().Eval(sensor.GetMyContextFromRoot(context))
        turned = RigidTransform(RotationMatrix.MakeYRotation(SPIN * sample * T), [0.1, 0.2, 0.3])
        assert_pose(X_WB, turned, 1e-9)


FIXED = RigidTransform(RollPitchYaw(0.1, 0.2, 0.3), [1, 2, 3])


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
    source, reader = builder.AddSystem(FixedBasePose(FIXED)), builder.AddSystem(Reader())
    builder.Connect(source.get_output_port(), reader.get_input_port())
    simulator = Simulator(builder.Build())
    simulator.AdvanceTo(1.0)
    assert reader.calls == 1
    pose = source.get_output_port().Eval(source.GetMyContextFromRoot(simulator.get_context()))
    np.testing.assert_array_equal(pose.reshape(3, 4), FIXED.GetAsMatrix34())
    assert signal_of(source.get_output_port()).unit == ("1", "1", "1", "m")
