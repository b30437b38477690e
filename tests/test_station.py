"""The wiring of a station, port by port."""

import pytest
from pydrake.systems.framework import Diagram

from soft_gripper.diagrams.recording import describe
from soft_gripper.diagrams.scenario_file import load_scenario, scenario_names
from soft_gripper.diagrams.signals import FINGER_SIGNALS, GRIP_SIGNALS
from soft_gripper.diagrams.simulation import simulate
from soft_gripper.diagrams.station import make_station

FINGERS = ("left_finger", "right_finger")

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


def test_ports_of_the_stations(free_bending, box_grasp):
    of_fingers = [f"{finger}.{signal}" for finger in FINGERS for signal in OF_A_FINGER]
    inputs, outputs = ports(free_bending.diagram)
    assert inputs == []
    assert sorted(outputs) == sorted([*of_fingers, "plant.state"])
    inputs, outputs = ports(box_grasp.diagram)
    assert inputs == []
    assert sorted(outputs) == sorted([*of_fingers, "plant.state", "box.contact_force"])


def test_ports_of_the_closed_loop():
    diagram = make_station(load_scenario("tip_distance_steps")).diagram
    of_fingers = [f"{finger}.{signal}" for finger in FINGERS for signal in OF_A_FINGER]
    of_grip = [f"grip.{signal}" for signal in GRIP_SIGNALS]
    assert sorted(ports(diagram)[1]) == sorted([*of_fingers, *of_grip, "plant.state"])
    control = diagram.GetSubsystemByName("grip_control")
    assert ports(control) == (["set_point", "first_tip_pose", "second_tip_pose"], ["pressure", "distance"])


def test_blocks_of_the_station(free_bending):
    of_each = ("pressure_drive", "pressure_steps", "joint_angles", "contact_torque")
    expected = ["plant", "scene_graph", "logs", *FINGERS]
    expected += [f"{finger}.{block}" for finger in FINGERS for block in of_each]
    assert sorted(system.get_name() for system in free_bending.diagram.GetSystems()) == sorted(expected)


@pytest.mark.parametrize("finger", FINGERS)
def test_ports_of_the_sensing(free_bending, finger):
    sensing = free_bending.diagram.GetSubsystemByName(finger)
    inputs, outputs = ports(sensing)
    assert inputs == ["joint_angles", "pressure", "contact_torque"]
    assert sorted(outputs) == sorted(OF_SENSING)
    for block, expected in SENSING_BLOCKS.items():
        assert ports(sensing.GetSubsystemByName(block)) == expected


def test_ports_of_the_drives(free_bending, box_grasp):
    drive = free_bending.diagram.GetSubsystemByName("left_finger.pressure_drive")
    assert ports(drive) == (["left_finger.pressure_command"], ["left_finger.pressure", "actuation"])
    shared = box_grasp.diagram.GetSubsystemByName("gripper.pressure_drive")
    commands, pressures = ([f"{finger}.{name}" for finger in FINGERS] for name in ("pressure_command", "pressure"))
    assert ports(shared) == (commands, [*pressures, "actuation"])


@pytest.mark.parametrize("name", scenario_names())
def test_every_signal_is_logged_and_has_a_unit_and_labels(name):
    station = make_station(load_scenario(name))
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


def test_each_finger_of_a_model_bends_under_its_own_pressure():
    own = ("left_finger: [20.0e3]", "right_finger: [-20.0e3]")
    scenario = load_scenario("box_grasp", [f"pressure.steps={{{', '.join(own)}}}", "pressure.hold_samples=1"])
    recording = simulate(scenario)
    left, right = (recording[f"{finger}.sampled_joint_angles"][-1].values for finger in FINGERS)
    assert (left > 0).all()
    assert (right < 0).all()
    assert abs(left + right).max() < 1e-3
