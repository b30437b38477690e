"""The drive of fingers: pressures step by step, their torques, laws and creep."""

import numpy as np
import pytest
from pydrake.multibody.parsing import Parser
from pydrake.multibody.plant import AddMultibodyPlantSceneGraph
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import DiagramBuilder
from refusals import refused

from soft_gripper.diagrams.loaded_model import add_fingers
from soft_gripper.diagrams.wiring.drive import StepSource, add_pressure_drive, pressure_steps
from soft_gripper.models import DIRECTORY
from soft_gripper.scenario.schema import PressureConfig, Scenario, SensorConfig
from soft_gripper.signals import signal_of

COMMANDS = {"left_finger": 40e3, "right_finger": -20e3}  # Pa
STIFFER = '<elastic_law angle="-0.2 0.2" base_torque="-0.5 0.5" tip_torque="-0.5 0.5"/>'

FURTHER = '<pressure_law pressure="0 2e4 1e5" effective="0 4e4 3.6e5"/>'


class Driven:
    """A gripper with its drive, the joints bent by so much, rad."""

    def __init__(self, file, config=None, bend=0.0, time_step=0.004):
        builder = DiagramBuilder()
        plant, _ = AddMultibodyPlantSceneGraph(builder, time_step)
        self.fingers = add_fingers(Parser(plant), file)
        plant.WeldFrames(plant.world_frame(), plant.GetFrameByName("palm"))
        plant.Finalize()
        self.drive = add_pressure_drive(builder, self.fingers, config)
        for name, command in self.drive.commands.items():
            builder.ExportInput(command, name)
        self.diagram = builder.Build()
        self.root = self.diagram.CreateDefaultContext()
        self.plant, self.context = plant, plant.GetMyMutableContextFromRoot(self.root)
        plant.SetPositions(self.context, np.full(plant.num_positions(), bend))
        for name, pressure in COMMANDS.items():
            self.diagram.GetInputPort(name).FixValue(self.root, [pressure])

    def value(self, port):
        return port.Eval(port.get_system().GetMyContextFromRoot(self.root))

    def torques(self, finger):
        """On the joints of a finger, as they enter the plant, N m."""
        return finger.actuator_selector() @ self.plant.get_actuation_input_port(finger.model).Eval(self.context)


NO_LAG = PressureConfig(time_constant=0.0)
GRIPPER = "package://soft_gripper/grippers/two_finger.urdf"


def test_pressures_are_torques_of_the_fingers_own_joints():
    driven = Driven(GRIPPER, NO_LAG)
    for finger in driven.fingers:
        assert driven.value(driven.drive.pressures[finger.name]) == [COMMANDS[finger.name]]
        np.testing.assert_allclose(driven.torques(finger), COMMANDS[finger.name] * finger.finger.pressure_gain)


def test_limits_and_lag_are_those_of_the_config():
    """With a lag, as by default, nothing has come yet."""
    limited = PressureConfig(minimum=-10e3, maximum=30e3, time_constant=0.0)
    for config, expected in ((limited, [30e3, -10e3]), (None, [0, 0])):
        driven = Driven(GRIPPER, config)
        assert [driven.value(port)[0] for port in driven.drive.pressures.values()] == expected


@pytest.fixture
def stiff_file(tmp_path):
    """The gripper, whose left finger has an elastic law."""
    text = (DIRECTORY / "grippers/two_finger.urdf").read_text()
    path = tmp_path / "gripper.urdf"
    path.write_text(text.replace("</finger>", f"{STIFFER}</finger>", 1))
    return path


def test_actuation_is_what_the_plant_takes_in(stiff_file):
    for file in (GRIPPER, stiff_file):
        driven = Driven(file, NO_LAG, bend=0.1)
        ((model, port),) = driven.drive.actuations.items()
        assert model == "two_finger"
        taken = driven.plant.get_actuation_input_port(driven.fingers[0].model).Eval(driven.context)
        np.testing.assert_array_equal(driven.value(port), taken)
        assert np.abs(taken).min() > 0
        assert signal_of(port).unit == "N m"
        assert len(signal_of(port).axes["actuator"]) == 24


def test_an_elastic_law_takes_the_place_of_the_springs(stiff_file):
    """2.5 N m/rad at every joint: together with the springs of the chain the finger is as stiff as that."""
    driven = Driven(stiff_file, NO_LAG, bend=0.1)
    left, right = driven.fingers
    added = driven.torques(left) - COMMANDS["left_finger"] * left.finger.pressure_gain
    np.testing.assert_allclose(added, (left.finger.stiffness - 2.5) * 0.1, rtol=1e-9)
    np.testing.assert_allclose(driven.torques(right), COMMANDS["right_finger"] * right.finger.pressure_gain)


def test_pressures_bend_by_the_law_of_their_finger(tmp_path):
    """The left finger bends by twice the pressure up to 20 kPa and four times beyond, the right one as the pressure."""
    text = (DIRECTORY / "grippers/two_finger.urdf").read_text()
    path = tmp_path / "gripper.urdf"
    path.write_text(text.replace("</finger>", f"{FURTHER}</finger>", 1))
    driven = Driven(path, NO_LAG)
    for finger, effective in zip(driven.fingers, (120e3, -20e3), strict=True):
        assert driven.value(driven.drive.pressures[finger.name]) == [COMMANDS[finger.name]]
        np.testing.assert_allclose(driven.torques(finger), effective * finger.finger.pressure_gain)
        np.testing.assert_allclose(driven.torques(finger), finger.finger.pressure_torque(COMMANDS[finger.name]))


def test_a_finger_that_creeps_drives_itself_on(tmp_path):
    """By nothing where it was bent just now, by a fifth of its stiffness where it has been bent for long."""
    text = (DIRECTORY / "grippers/two_finger.urdf").read_text()
    path = tmp_path / "gripper.urdf"
    path.write_text(text.replace("</finger>", '<creep share="0.2" time="0.3"/></finger>', 1))
    driven = Driven(path, NO_LAG, bend=0.1)
    left, right = driven.fingers
    creep = driven.diagram.GetSubsystemByName("left_finger.creep")
    for angle in (0.0, 0.1):
        creep.set_internal_angles(
            creep.GetMyMutableContextFromRoot(driven.root), np.full((1, 12), angle), np.full(12, 0.1)
        )
        added = driven.torques(left) - COMMANDS["left_finger"] * left.finger.pressure_gain
        np.testing.assert_allclose(added, 0.2 * left.finger.stiffness * angle, atol=1e-12)
    np.testing.assert_allclose(driven.torques(right), COMMANDS["right_finger"] * right.finger.pressure_gain)
    assert not driven.diagram.HasSubsystemNamed("right_finger.creep")


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
    source = StepSource({"left": np.array([[0.1], [-2.7], [3.3]])}, 0.5)
    simulator = Simulator(source)
    context = simulator.get_mutable_context()
    context.SetTime(begin)
    simulator.Initialize()
    np.testing.assert_array_equal([value(source, context, begin + t) for t in TIMES], VALUES)
    context.SetTime(begin + 0.7)
    Simulator(source, context).Initialize()  # goes on
    assert value(source, context, begin + 0.7) == -2.7
