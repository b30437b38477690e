"""The station of an environment: actions, observations, peak forces, and targets; it is freed with its blocks."""

import numpy as np
import pytest
from pydrake.systems.analysis import ApplySimulatorConfig, Simulator
from pydrake.systems.framework import DiagramBuilder
from pydrake.systems.primitives import ConstantVectorSource, PassThrough
from refusals import refused

from soft_gripper.diagrams.private_run import Pruning
from soft_gripper.diagrams.simulation import solver_config
from soft_gripper.extras.learning import station as module
from soft_gripper.extras.learning.config import ActionConfig, ObservedConfig, load_environment
from soft_gripper.extras.learning.station import (
    MAX_OBSERVED,
    TipTarget,
    add_action,
    add_observation,
    home,
    make_learning_station,
    scaled,
)
from soft_gripper.fingers.kinematics import as_points, forward_kinematics
from soft_gripper.fingers.statics import resting_angles
from soft_gripper.truth.contact import Patch


def test_joints_begin_where_the_scenario_has_them():
    environment = load_environment("soft_pick_place", {"scenario.arm.home": [-0.1, 0.03]})
    station = make_learning_station(environment.config, environment.scenario)
    assert home(station.parts) == {"x": -0.1, "z": 0.03}
    plant = station.parts.plant
    context = plant.CreateDefaultContext()
    assert plant.GetJointByName("z").get_translation(context) == pytest.approx(0.03)


def test_an_object_stands_on_its_lowest_point(grasp_station):
    """Its frame begins at 30.01 mm, which leaves 10 um to the table."""
    assert grasp_station.object_height == pytest.approx(0.03, abs=1e-6)


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


def test_a_joint_that_is_not_there_is_refused():
    builder = DiagramBuilder()
    desired = builder.AddSystem(PassThrough(2)).get_input_port()
    with refused("joints", "z"):
        add_action(builder, CONFIG, [], desired, {"y": 0.0}, 0.01)


def observe(*observed):
    builder = DiagramBuilder()
    values = {"finger.tip_pose": [0.1, 0.2, 0.3], "finger.contact_force": [np.nan], "plant.state": [1.0]}
    signals = {name: builder.AddSystem(ConstantVectorSource(value)).get_output_port() for name, value in values.items()}
    builder.ExportOutput(add_observation(builder, observed, signals), "observation")
    diagram = builder.Build()
    return diagram.GetOutputPort("observation").Eval(diagram.CreateDefaultContext())


def test_what_is_out_of_range_is_at_its_limit_and_what_is_unknown_is_zero():
    values = scaled(np.array([[1e9, -np.inf], [np.nan, 1.0]]), np.array([1.0, 2.0]))
    np.testing.assert_array_equal(values, [[MAX_OBSERVED, -MAX_OBSERVED], [0.0, 0.5]])


@pytest.mark.parametrize(
    ("observed", "field", "value"),
    [
        (ObservedConfig("plant.state"), "signal", "plant.state"),
        (ObservedConfig("finger.true_contact_force"), "signal", "finger.true_contact_force"),
        (ObservedConfig("finger.ideal_strain"), "signal", "finger.ideal_strain"),
        (ObservedConfig("finger.strain"), "signal", "finger.strain"),
        (ObservedConfig("finger.tip_pose", [3]), "entries", [3]),
    ],
)
def test_the_truth_and_what_is_not_there_are_refused(observed, field, value):
    with refused(field, value):
        observe(observed)


def test_forces_are_along_normals_of_any_length_and_not_those_of_a_finger_on_itself(monkeypatch):
    def patch(*shapes, normal=(0.0, 0.0, 1e-4)):  # of a surface it is as long as that is large
        return Patch(shapes, np.zeros(3), np.array(normal), np.array([0.3, 0.0, -2.0]), np.zeros(3))

    found = [patch("left", "block"), patch("table", "right", normal=(5.0, 0.0, 0.0)), patch("left", "left too")]
    monkeypatch.setattr(module, "patches", lambda *_: found)
    forces = module.normal_forces(None, {"left": 0, "left too": 0, "right": 1}, 2)
    np.testing.assert_allclose(forces, [2.0, 0.3])


@pytest.fixture(scope="module")
def whole_station(grasp_environment):
    """A station of SoftGrasp-v0 with the true signals, which nothing in it reads."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(module, "remove_unread_blocks", lambda builder, signals: Pruning(dict(signals), {}))
        return module.make_learning_station(grasp_environment.config, grasp_environment.scenario)


@pytest.fixture(scope="module")
def gripped(whole_station):
    """Peak and present forces, (T, F) each, and true ones, every 50 ms of a grip that is made and loosened."""
    diagram, parts, forces = whole_station.diagram, whole_station.parts, whole_station.forces
    simulator = Simulator(diagram)
    ApplySimulatorConfig(solver_config(parts.scenario), simulator)
    context = simulator.get_mutable_context()
    own = forces.GetMyContextFromRoot(context)
    truth = [parts.signals[f"{finger.name}.normal_force"] for finger in parts.fingers]
    rows = []
    for grip in [0.3] * 16 + [-1.0] * 16:
        diagram.GetInputPort("action").FixValue(context, [grip, -1.0])
        simulator.AdvanceTo(context.get_time() + 0.05)
        known = [port.Eval(port.get_system().GetMyContextFromRoot(context))[0] for port in truth]
        rows.append((forces.GetOutputPort("peak").Eval(own), forces.GetOutputPort("force").Eval(own), known))
    return (np.array(column) for column in zip(*rows, strict=True))


def test_forces_are_the_true_ones_and_the_peak_stays(gripped):
    peak, force, truth = gripped
    np.testing.assert_allclose(force, truth, atol=1e-12)
    assert force.max() > 0.3
    assert not force[-1].any()
    assert (np.diff(peak, axis=0) >= 0).all()
    assert (peak[1:] >= force[:-1] - 1e-12).all()
    assert (peak[-1] < 1.5 * force.max(axis=0)).all()


GRAVITY = 9.81 + 0j
LIMITS = (-20e3, 120e3)


@pytest.fixture(scope="module")
def target(shipped_finger):
    return TipTarget(shipped_finger, GRAVITY, LIMITS)


def tip(finger, pressure):
    return as_points(forward_kinematics(resting_angles(finger, pressure, GRAVITY), finger.segment_length).tip)


@pytest.mark.parametrize("time", [0.0, 0.5, 1.3])
def test_it_is_where_the_tip_rests_under_the_pressure_of_that_time(target, shipped_finger, time):
    context = target.CreateDefaultContext()
    target.swing(context, 50e3, 40e3, 2.0, 0.7)
    context.SetTime(time)
    pressure = 50e3 + 40e3 * np.sin(np.pi * time + 0.7)
    np.testing.assert_allclose(target.get_output_port().Eval(context), tip(shipped_finger, pressure), atol=2e-5)
