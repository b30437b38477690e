"""What a grip control is given: torque, force and bound of the fingers, and values that change at samples."""

import numpy as np
import pytest
from finger_plants import built_at
from pydrake.multibody.parsing import Parser
from pydrake.multibody.plant import MultibodyPlant
from pydrake.multibody.tree import JacobianWrtVariable
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import DiagramBuilder, LeafSystem

from soft_gripper.control.grip import GripForce, GripForceBound, GripTorque, SampledSteps
from soft_gripper.fingers.finger_links import joint_name, link_name
from soft_gripper.fingers.urdf import expand_urdf
from soft_gripper.models import DIRECTORY
from soft_gripper.signals import signal_of

FINGERS = ("left_finger", "right_finger")
FORCE = 0.7  # N


@pytest.fixture(scope="module")
def gripper():
    """The shipped gripper in a plant of pydrake alone, its fingers straight."""
    plant = MultibodyPlant(0.0)
    Parser(plant).AddModelsFromString(expand_urdf(DIRECTORY / "grippers/two_finger.urdf").text, "urdf")
    plant.WeldFrames(plant.world_frame(), plant.GetFrameByName("palm"))
    plant.Finalize()
    return plant


def grip_torque(*torques):
    """What the block says of the torques at the joints of some fingers, N m."""
    block = GripTorque({f"f{i}": len(of_finger) for i, of_finger in enumerate(torques)})
    context = block.CreateDefaultContext()
    for i, of_finger in enumerate(torques):
        block.GetInputPort(f"f{i}.external_torque").FixValue(context, of_finger)
    (torque,) = block.GetOutputPort("torque").Eval(context)
    return torque


def by_finger(plant, forces):
    """Generalized forces, (nv), as torques at the joints of both fingers, each (12) N m."""
    joints = ([plant.GetJointByName(joint_name(finger, i)) for i in range(12)] for finger in FINGERS)
    return [forces[[joint.velocity_start() for joint in of_finger]] for of_finger in joints]


def pushed(plant, forces_W):
    """Torques of forces on the tips, one a finger, (3,) N."""
    context, total = plant.CreateDefaultContext(), 0.0
    for finger, force in zip(FINGERS, forces_W, strict=True):
        link = plant.GetFrameByName(link_name(finger, 12))
        p_WTip = plant.GetFrameByName(link_name(finger, 0)).CalcPoseInWorld(context) @ np.array([0, 0, 0.12])
        p_LinkTip = link.CalcPoseInWorld(context).inverse() @ p_WTip
        world = plant.world_frame()
        by_v = JacobianWrtVariable.kV
        total += plant.CalcJacobianTranslationalVelocity(context, by_v, link, p_LinkTip, world, world).T @ force
    return by_finger(plant, total)


def test_a_thing_between_the_tips(gripper):
    """It pushes both apart, with the lever from the tip to the joint in the middle of the first of 12 segments."""
    torque = grip_torque(*pushed(gripper, ([-FORCE, 0, 0], [FORCE, 0, 0])))
    assert torque == pytest.approx(FORCE * (0.12 - 0.005), rel=1e-9)


def swung(plant, acceleration):
    """Torques at the joints of both fingers when the palm swings; it acts on them as gravity does, m/s^2."""
    plant.mutable_gravity_field().set_gravity_vector(acceleration)
    return by_finger(plant, plant.CalcGravityGeneralizedForces(plant.CreateDefaultContext()))


@pytest.mark.parametrize("swing", [[6.0, 0, 0], [0, 6.0, 0], [-6.0, 2.0, 0]])
def test_a_swing_of_the_palm_cancels_out(gripper, swing):
    first, second = swung(gripper, swing)
    assert (abs(first[0]) > 1e-3) == (abs(swing[0]) > 0)
    assert grip_torque(first, second) == pytest.approx(0, abs=1e-9)


def test_what_acts_along_the_fingers_turns_both_alike(gripper, shipped_finger):
    """Their mass lies outside of their neutral axes; a swing across that comes with it cancels out all the same."""
    s, width = np.linspace(0.005, 0.12, 1001), 0.02  # m, from the first joint to the tip
    thickness, chamber = np.interp(s, [0, 0.12], [0.02, 0.019]), np.interp(s, [0, 0.12], [10e-3, 9.5e-3])
    area = width * thickness - 9e-3 * chamber
    neutral_axis = np.array([built_at(shipped_finger, place).neutral_axis for place in s])
    outside = neutral_axis - 9e-3 * chamber * 0.1 * chamber / area  # the chamber moves the mass inward
    expected = 9.81 * np.trapezoid(1070 * area * outside, s)
    assert expected > 3e-3
    assert grip_torque(*swung(gripper, [-6.0, 2.0, -9.81])) == pytest.approx(expected, rel=1e-4)


def test_a_new_reading_is_a_new_torque():
    block = GripTorque({"left": 1, "right": 1})
    context = block.CreateDefaultContext()
    for name in ("left", "right"):
        block.GetInputPort(f"{name}.external_torque").FixValue(context, [0.0])
    block.get_output_port().Eval(context)
    block.GetInputPort("right.external_torque").FixValue(context, [-0.2])
    assert block.get_output_port().Eval(context) == [0.1]
    assert signal_of(block.get_output_port()).unit == "N m"


def grip_force(*forces):
    """What the block makes of the closing forces of some fingers, N."""
    block = GripForce([f"f{i}" for i in range(len(forces))])
    context = block.CreateDefaultContext()
    for i, force in enumerate(forces):
        block.GetInputPort(f"f{i}.contact_force_vector").FixValue(context, [-force, 5.0, -7.0])
    (found,) = block.GetOutputPort("force").Eval(context)
    return found


def test_a_force_that_is_not_known_leaves_it_unknown():
    assert np.isnan(grip_force(0.5, np.nan))


def grip_force_bound(*fingers):
    """What the block makes of the intervals, N, and contact of some fingers."""
    block = GripForceBound([f"f{i}" for i in range(len(fingers))])
    context = block.CreateDefaultContext()
    for i, (interval, contact) in enumerate(fingers):
        block.GetInputPort(f"f{i}.contact_force_interval").FixValue(context, interval)
        block.GetInputPort(f"f{i}.contact").FixValue(context, [contact])
    (found,) = block.GetOutputPort("force").Eval(context)
    return found


UNKNOWN = 3 * [np.nan]


@pytest.mark.parametrize(
    ("fingers", "expected"),
    [
        ([([0.2, 0.5, 0.8], 1.0), ([0.3, 0.4, 0.6], 1.0)], 0.7),
        ([([0.2, 0.5, 0.8], 1.0), ([0.3, 0.4, 6.0], 0.0)], 0.4),  # one is free, and moved
        ([([0.2, 0.5, 2.5], 0.0), (UNKNOWN, 0.0)], 0.0),
        ([([0.2, 0.5, 0.8], 1.0), (UNKNOWN, 1.0)], np.nan),
    ],
)
def test_the_bound_counts_where_contact_is_detected(fingers, expected):
    assert grip_force_bound(*fingers) == pytest.approx(expected, nan_ok=True)


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
