"""The wiring of a station, port by port."""

import numpy as np
import pytest
from pydrake.common.schema import Transform
from pydrake.math import RigidTransform
from pydrake.systems.framework import Diagram

from soft_gripper.diagrams.recording import describe
from soft_gripper.diagrams.scenario import ModelConfig, Scenario
from soft_gripper.diagrams.scenario_file import load_scenario, scenario_names
from soft_gripper.diagrams.signals import CONTACT_SIGNALS, FINGER_SIGNALS, GRIP_SIGNALS, TASK_SIGNALS, WIDTH_SIGNALS
from soft_gripper.diagrams.simulation import simulate
from soft_gripper.diagrams.station import make_station

FINGERS = ("left_finger", "right_finger")
CONTACT = "sensor.contact_threshold=2.5e-3"

# block of a finger: input ports, output ports
SENSING_BLOCKS = {
    "strain_sensor": (["joint_angles"], ["sampled_joint_angles", "extension_ratio", "strain"]),
    "arc_pose_estimator": (
        ["strain", "X_WB"],
        ["theta", "kappa", "arcs", "joint_positions", "tip_pose", "joint_positions_world"],
    ),
    "pose_error": (
        ["sampled_joint_angles", "joint_positions", "tip_pose"],
        ["pose_error", "fingertip_error"],
    ),
    "force_estimator": (["theta", "pressure", "X_WB"], ["free_bending_angles", "external_torque"]),
}
OF_BLOCKS = [port for _, outputs in SENSING_BLOCKS.values() for port in outputs]
OF_SENSING = [*OF_BLOCKS, "sampled_pressure", "true_external_torque", "external_torque_error"]
OF_A_FINGER = ["pressure_command", "pressure", *OF_SENSING]


def of_each_finger(names):
    return [f"{finger}.{name}" for finger in FINGERS for name in names]


def blocks(station):
    return sorted(system.get_name() for system in station.diagram.GetSystems())


def ports(system):
    """Names of the input and of the output ports."""
    inputs = [system.get_input_port(i).get_name() for i in range(system.num_input_ports())]
    outputs = [system.get_output_port(i).get_name() for i in range(system.num_output_ports())]
    return inputs, outputs


@pytest.fixture(scope="module")
def free_bending():
    """Two models of one finger each."""
    return make_station(load_scenario("free_bending"))


@pytest.fixture(scope="module")
def box_grasp():
    """One model of two fingers, and a free object."""
    return make_station(load_scenario("box_grasp"))


@pytest.fixture(scope="module")
def pick_and_place():
    """An arm that carries the gripper and leads it through a task; contact is looked for."""
    return make_station(load_scenario("pick_and_place_box", [CONTACT]))


def test_ports_of_the_stations(free_bending, box_grasp):
    inputs, outputs = ports(free_bending.diagram)
    assert inputs == []
    assert sorted(outputs) == sorted([*of_each_finger(OF_A_FINGER), "plant.state"])
    inputs, outputs = ports(box_grasp.diagram)
    assert inputs == []
    assert sorted(outputs) == sorted([*of_each_finger(OF_A_FINGER), "plant.state", "box.contact_force"])


def test_ports_of_the_closed_loop():
    diagram = make_station(load_scenario("tip_distance_steps")).diagram
    of_grip = [f"grip.{signal}" for signal in GRIP_SIGNALS]
    assert sorted(ports(diagram)[1]) == sorted([*of_each_finger(OF_A_FINGER), *of_grip, "plant.state"])
    measured = [f"{which}_{signal}" for signal in ("tip_pose", "external_torque") for which in ("first", "second")]
    control = diagram.GetSubsystemByName("grip_control")
    assert ports(control) == (["set_point", *measured], ["pressure", "distance", "torque"])


def test_ports_of_a_task(pick_and_place):
    inputs, outputs = ports(pick_and_place.diagram)
    of_grip = [f"grip.{signal}" for signal in (*GRIP_SIGNALS, *WIDTH_SIGNALS)]
    of_fingers = of_each_finger([*OF_A_FINGER, *CONTACT_SIGNALS])
    of_task = [f"task.{signal}" for signal in TASK_SIGNALS]
    assert inputs == []
    assert sorted(outputs) == sorted([*of_fingers, *of_grip, *of_task, "plant.state", "box.contact_force"])


def test_blocks_of_the_station(free_bending):
    of_each = ("pressure_drive", "pressure_steps", "joint_angles", "contact_torque", "base_pose")
    assert blocks(free_bending) == sorted(["plant", "scene_graph", "logs", *FINGERS, *of_each_finger(of_each)])


def test_blocks_of_a_task(pick_and_place):
    of_each = ("joint_angles", "contact_torque", "base_pose", "contact_detector")
    of_arm = [f"arm.{name}" for name in ("gravity_compensation", "torque", "desired")]
    of_contact = ("true_contact", "object_width", "minus_true_width", "object_width_error")
    others = ("plant", "scene_graph", "logs", "gripper.pressure_drive", "grip_control", "task")
    assert blocks(pick_and_place) == sorted([*others, *of_arm, *of_contact, *FINGERS, *of_each_finger(of_each)])
    assert pick_and_place.task is pick_and_place.diagram.GetSubsystemByName("task")


def test_wires_of_a_task(pick_and_place):
    """The task hears what the grip control estimates, and tells arm and grip control what to do."""
    wires = {
        (
            f"{target.get_name()}: {target.get_input_port(into).get_name()}",
            f"{source.get_name()}: {source.get_output_port(out).get_name()}",
        )
        for (target, into), (source, out) in pick_and_place.diagram.connection_map().items()
    }
    assert {
        ("task: distance", "grip_control: distance"),
        ("task: torque", "grip_control: torque"),
        ("grip_control: set_point", "task: set_point"),
        ("arm.desired: u0", "task: desired_state"),
        ("arm.gravity_compensation: state", "plant: arm_state"),
        *(
            (f"grip_control: {which}_{signal}", f"{finger}: {signal}")
            for which, finger in zip(("first", "second"), FINGERS, strict=True)
            for signal in ("tip_pose", "external_torque")
        ),
        *((f"gripper.pressure_drive: {finger}.pressure_command", "grip_control: pressure") for finger in FINGERS),
    } <= wires


def test_an_arm_without_a_task_stays_at_home():
    station = make_station(load_scenario("pick_and_place_box", ["task.phases=[]"]))
    assert station.task is None
    assert {"arm.home", "arm.gravity_compensation", "gripper.pressure_drive"} <= set(blocks(station))
    assert not {"task", "grip_control"} & set(blocks(station))


@pytest.mark.parametrize(("name", "is_moving"), [("free_bending", False), ("pick_and_place_box", True)])
def test_the_pose_of_a_base_is_sampled_where_it_moves(name, is_moving):
    diagram = make_station(load_scenario(name)).diagram
    for finger in FINGERS:
        base = diagram.GetSubsystemByName(f"{finger}.base_pose")
        assert (type(base).__name__ == "BasePoseSensor") == is_moving


def test_the_torque_limit_adds_a_pid_and_a_selector():
    own = {"torque_pid", "torque_limit", "selector"}
    for name, is_limited in (("tip_distance_steps", False), ("pick_and_place_delicate", True)):
        control = make_station(load_scenario(name)).diagram.GetSubsystemByName("grip_control")
        assert (own <= {system.get_name() for system in control.GetSystems()}) == is_limited


def test_a_single_finger_holds_nothing():
    scenario = load_scenario("free_bending", [CONTACT])
    del scenario.models[1]
    _, outputs = ports(make_station(scenario).diagram)
    signals = [f"left_finger.{name}" for name in (*OF_A_FINGER, *CONTACT_SIGNALS)]
    assert sorted(outputs) == sorted([*signals, "plant.state"])


@pytest.mark.parametrize("finger", FINGERS)
def test_ports_of_the_sensing(free_bending, finger):
    sensing = free_bending.diagram.GetSubsystemByName(finger)
    inputs, outputs = ports(sensing)
    assert sorted(inputs) == ["X_WB", "contact_torque", "joint_angles", "pressure"]
    assert sorted(outputs) == sorted(OF_SENSING)
    for block, expected in SENSING_BLOCKS.items():
        assert ports(sensing.GetSubsystemByName(block)) == expected


def test_ports_of_the_drives(free_bending, box_grasp):
    drive = free_bending.diagram.GetSubsystemByName("left_finger.pressure_drive")
    assert ports(drive) == (["left_finger.pressure_command"], ["left_finger.pressure", "actuation"])
    shared = box_grasp.diagram.GetSubsystemByName("gripper.pressure_drive")
    commands, pressures = ([f"{finger}.{name}" for finger in FINGERS] for name in ("pressure_command", "pressure"))
    assert ports(shared) == (commands, [*pressures, "actuation"])


@pytest.mark.parametrize("overrides", [[], [CONTACT]], ids=["", "contact"])
@pytest.mark.parametrize("name", scenario_names())
def test_every_signal_is_logged_and_has_a_unit_and_labels(name, overrides):
    station = make_station(load_scenario(name, overrides))
    _, outputs = ports(station.diagram)
    assert outputs == station.logs.signals == ports(station.logs)[0]
    for signal in outputs:
        meaning, labels = describe(station, signal)
        size = station.diagram.GetOutputPort(signal).size()
        assert meaning.unit
        for entries in labels.values():
            size //= len(entries)
        assert size == 1


def test_every_signal_of_a_finger_exists():
    assert sorted(FINGER_SIGNALS) == sorted(OF_A_FINGER)


def test_plant_is_a_direct_child_and_its_only_neighbours_below_are_ours(free_bending):
    assert free_bending.diagram.GetSubsystemByName("plant") is free_bending.plant
    assert free_bending.plant.get_name() == "plant"
    nested = [system for system in free_bending.diagram.GetSystems() if isinstance(system, Diagram)]
    assert {type(system).__name__ for system in nested} == {"FingerSensing", "PressureDrive", "SignalLogs"}


def test_plant_stays_a_direct_child_under_an_arm(pick_and_place):
    assert pick_and_place.diagram.GetSubsystemByName("plant") is pick_and_place.plant
    nested = {type(s).__name__ for s in pick_and_place.diagram.GetSystems() if isinstance(s, Diagram)}
    assert nested == {"FingerSensing", "PressureDrive", "SignalLogs", "GravityCompensation", "GripControl"}


def test_each_finger_of_a_model_bends_under_its_own_pressure():
    own = ("left_finger: [20.0e3]", "right_finger: [-20.0e3]")
    scenario = load_scenario("box_grasp", [f"pressure.steps={{{', '.join(own)}}}", "pressure.hold_samples=1"])
    recording = simulate(scenario)
    left, right = (recording[f"{finger}.sampled_joint_angles"][-1].values for finger in FINGERS)
    assert (left > 0).all()
    assert (right < 0).all()
    assert abs(left + right).max() < 1e-3


@pytest.mark.parametrize(("touching", "x"), [("left_finger", -0.0245), ("right_finger", 0.0245)])
def test_contact_is_that_of_the_finger_that_touches(touching, x):
    """A peg stands in the way of one finger; contact and its truth belong to that one, and nothing is held."""
    models = [
        ModelConfig("gripper", "package://soft_gripper/grippers/two_finger.urdf"),
        ModelConfig("peg", "package://soft_gripper/objects/peg.sdf", X_PC=Transform(RigidTransform([x, 0, 0.105]))),
    ]
    scenario = Scenario(models=models)
    scenario.pressure.steps = {"all": [0.0, 60e3]}
    scenario.pressure.settle, scenario.sensor.contact_threshold = 0.5, 2.5e-3
    recording = simulate(scenario)
    for finger in FINGERS:
        last = {name: recording[f"{finger}.{name}"].values[-1] for name in CONTACT_SIGNALS}
        assert bool(last["contact"]) == (finger == touching)
        assert (last["normal_force"] > 0.1) == (finger == touching)
        assert np.isfinite(last["contact_center"]).all() == (finger == touching)
    begun = recording[f"{touching}.contact_time"].values[-1]
    first = recording["time"].values[recording[f"{touching}.normal_force"].values > 0][0]
    assert 0 <= begun - first < 0.08
    assert np.abs(recording[f"{touching}.contact_center"].values[-1] - [x, 0, 0.105]).max() < 0.012
    for name in WIDTH_SIGNALS:
        assert np.isnan(recording[f"grip.{name}"].values).all()


def test_width_of_what_both_fingers_hold():
    recording = simulate(load_scenario("box_grasp", [CONTACT, "pressure.steps.all=[0, 60.0e3]"]))
    last = {name: recording[f"grip.{name}"].values[-1] for name in WIDTH_SIGNALS}
    assert last["true_object_width"] == pytest.approx(0.044, abs=5e-4)
    assert last["object_width_error"] == pytest.approx(last["object_width"] - last["true_object_width"], abs=1e-12)
    assert abs(last["object_width_error"]) < 3e-3
