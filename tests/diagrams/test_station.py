"""The wiring of a station, port by port."""

import numpy as np
import pytest
from pydrake.geometry import Meshcat, Role
from pydrake.systems.framework import Diagram, DiagramBuilder

from soft_gripper.diagrams.simulation import simulate
from soft_gripper.diagrams.station import add_station, make_station
from soft_gripper.scenario.scenario_file import load_scenario
from soft_gripper.scenario.shipped import scenario_names
from soft_gripper.signals import signal_of

FINGERS = ("left_finger", "right_finger")
CONTACT, NO_CONTACT = "estimator.contact_threshold=2.5e-3", "estimator.contact_threshold=null"

# sub-diagram of a finger: block: input ports, output ports
SHAPE = ["theta", "kappa", "arcs", "joint_positions", "tip_pose", "joint_positions_world"]
TRUE_POSE = ["true_joint_positions", "true_tip_position"]
BLOCKS = {
    "sensors": {"sensor": (["joint_angles"], ["extension_ratio", "strain"]), "sampled_pressure": (["u"], ["y"])},
    "estimation": {
        "driving_torque": (["pressure"], ["driving_torque"]),
        "estimator": (["strain", "driving_torque", "X_WB"], ["estimated_joint_angles", *SHAPE]),
        "force_estimator": (
            ["estimated_joint_angles", "driving_torque", "X_WB"],
            ["free_bending_angles", "external_torque", "torque_tolerance"],
        ),
    },
    "scoring": {"pose_error": ([*TRUE_POSE, "joint_positions", "tip_pose"], ["pose_error", "fingertip_error"])},
}
DETECTOR = (["external_torque", "torque_tolerance"], ["contact", "contact_residual", "contact_time"])
# sub-diagram: input ports, output ports
PARTS = {
    "sensors": (["joint_angles", "pressure"], ["extension_ratio", "strain", "sampled_pressure"]),
    "estimation": (
        ["pressure", "strain", "X_WB"],
        [port for _, outputs in BLOCKS["estimation"].values() for port in outputs if port != "torque_tolerance"],
    ),
    "scoring": (
        ["joint_angles", "contact_torque", *TRUE_POSE, "joint_positions", "tip_pose", "external_torque"],
        [
            *("sampled_joint_angles", "true_external_torque", "pose_error", "fingertip_error"),
            *("delayed_torque", "external_torque_error"),
        ],
    ),
}
OF_PARTS = [port for _, outputs in PARTS.values() for port in outputs if port != "delayed_torque"]
OF_TRUTH = [
    *("link_contact_force", "link_normal_force", "true_contact_force", "true_contact_total"),
    *("true_contact_arc_length", "normal_force", "contact_center", "true_contact_force_world", "true_contact_side"),
]
OF_A_FINGER = ["pressure_command", "pressure", "X_WB", *TRUE_POSE, *OF_TRUTH, *OF_PARTS]
OF_CONTACT = ["torque_tolerance", *DETECTOR[1]]
OF_GRIP, OF_WIDTH = ["set_point", "opening", "torque"], ["object_width", "object_width_error"]
TRUE_WIDTH = "grip.true_object_width"
OF_ARM = ["arm.joint_positions", "arm.joint_velocities", "arm.joint_torques"]
OF_PLANT = ["gripper.actuation", "plant.state"]
OF_GRIP_ON_BOX = ("normal_force", "friction_force", "force", "area", "pressure")
OF_BOX = ["box.pose", "box.contact_wrench", *(f"box.grip_{name}" for name in OF_GRIP_ON_BOX)]


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
    assert sorted(outputs) == sorted([*of_each_finger([*OF_A_FINGER, "actuation"]), TRUE_WIDTH, "plant.state"])
    inputs, outputs = ports(box_grasp.diagram)
    assert inputs == []
    assert sorted(outputs) == sorted([*of_each_finger(OF_A_FINGER), TRUE_WIDTH, *OF_PLANT, *OF_BOX])


def test_ports_of_the_closed_loop():
    diagram = make_station(load_scenario("tip_distance_steps")).diagram
    of_grip = [f"grip.{signal}" for signal in OF_GRIP]
    assert sorted(ports(diagram)[1]) == sorted([*of_each_finger(OF_A_FINGER), *of_grip, TRUE_WIDTH, *OF_PLANT])
    measured = [f"{finger}.{signal}" for signal in ("tip_pose", "external_torque") for finger in FINGERS]
    control = diagram.GetSubsystemByName("grip_control")
    assert ports(control) == (["set_point", *measured], ["pressure", "opening", "torque"])


def test_ports_of_a_task(pick_and_place):
    inputs, outputs = ports(pick_and_place.diagram)
    of_grip = [f"grip.{signal}" for signal in (*OF_GRIP, *OF_WIDTH)]
    of_fingers = of_each_finger([*OF_A_FINGER, *OF_CONTACT])
    of_task = [f"task.{signal}" for signal in ("phase", "outcome", "desired_state")]
    assert inputs == []
    assert sorted(outputs) == sorted([*of_fingers, *of_grip, TRUE_WIDTH, *of_task, *OF_PLANT, *OF_BOX, *OF_ARM])


def test_blocks_of_the_station(free_bending):
    of_each = (
        "pressure_drive",
        "pressure_steps",
        "joint_angles",
        "contact_torque",
        "base_pose",
        *PARTS,
    )
    others = ("plant", "scene_graph", "logs", "true_contact", "true_poses", "true_poses.state")
    assert blocks(free_bending) == sorted([*others, *of_each_finger(of_each)])


def test_blocks_of_a_task(pick_and_place):
    of_each = ("joint_angles", "contact_torque", "base_pose", *PARTS)
    of_arm = [f"arm.{name}" for name in ("gravity_compensation", "torque", "desired")]
    of_contact = ("true_contact", "true_poses", "true_poses.state", "object_width", "object_width_error")
    others = ("plant", "scene_graph", "logs", "gripper.pressure_drive", "grip_control", "task", "box.pose", *OF_ARM)
    assert blocks(pick_and_place) == sorted([*others, *of_arm, *of_contact, *of_each_finger(of_each)])
    assert pick_and_place.task is pick_and_place.diagram.GetSubsystemByName("task")


def test_wires_of_a_task(pick_and_place):
    """The task takes what the grip control estimates, and commands arm and grip control."""
    wires = {
        (
            f"{target.get_name()}: {target.get_input_port(into).get_name()}",
            f"{source.get_name()}: {source.get_output_port(out).get_name()}",
        )
        for (target, into), (source, out) in pick_and_place.diagram.connection_map().items()
    }
    assert {
        ("task: opening", "grip_control: opening"),
        ("task: torque", "grip_control: torque"),
        ("grip_control: set_point", "task: set_point"),
        ("arm.desired: u0", "task: desired_state"),
        ("arm.gravity_compensation: state", "plant: arm_state"),
        *(
            (f"grip_control: {finger}.{signal}", f"{finger}.estimation: {signal}")
            for finger in FINGERS
            for signal in ("tip_pose", "external_torque")
        ),
        *((f"gripper.pressure_drive: {finger}.pressure_command", "grip_control: pressure") for finger in FINGERS),
    } <= wires


def test_an_arm_without_a_task_stays_at_home():
    station = make_station(load_scenario("pick_and_place_box", ["task=null"]))
    assert station.task is None
    assert {"arm.home", "arm.gravity_compensation", "gripper.pressure_drive"} <= set(blocks(station))
    assert not {"task", "grip_control"} & set(blocks(station))


@pytest.mark.slow
@pytest.mark.parametrize(("name", "is_moving"), [("free_bending", False), ("pick_and_place_box", True)])
def test_the_pose_of_a_base_is_sampled_where_it_moves(name, is_moving):
    diagram = make_station(load_scenario(name)).diagram
    for finger in FINGERS:
        base = diagram.GetSubsystemByName(f"{finger}.base_pose")
        assert (type(base).__name__ == "BasePoseSensor") == is_moving


@pytest.mark.parametrize(
    ("overrides", "own"),
    [
        ([], set()),
        (["control.torque_limit=0.1", "control.torque_gains={ki: 1.0}"], {"torque_pid", "torque_limit", "selector"}),
        (
            ["control.force_limit=0.1", "control.force_gains={ki: 1.0}", "estimator.type=contact"],
            {"force_pid", "force_limit", "selector", "grip_force"},
        ),
    ],
)
def test_a_limit_adds_a_pid_and_a_selector(overrides, own):
    control = make_station(load_scenario("tip_distance_steps", overrides)).diagram.GetSubsystemByName("grip_control")
    always = {"gripper_opening", "pid", "grip_torque"}
    assert {system.get_name() for system in control.GetSystems()} == always | own


def test_a_single_finger_holds_nothing():
    scenario = load_scenario("free_bending", [CONTACT])
    del scenario.models[1]
    _, outputs = ports(make_station(scenario).diagram)
    signals = [f"left_finger.{name}" for name in (*OF_A_FINGER, *OF_CONTACT)]
    assert sorted(outputs) == sorted([*signals, "left_finger.actuation", "plant.state"])


@pytest.mark.parametrize("finger", FINGERS)
def test_ports_of_the_sensing(free_bending, finger):
    for part, expected in PARTS.items():
        diagram = free_bending.diagram.GetSubsystemByName(f"{finger}.{part}")
        assert ports(diagram) == expected
        for block, ports_of_block in BLOCKS[part].items():
            assert ports(diagram.GetSubsystemByName(block)) == ports_of_block


def test_a_detector_is_there_if_contact_is_looked_for(free_bending, pick_and_place):
    without, looking = (s.diagram.GetSubsystemByName("left_finger.estimation") for s in (free_bending, pick_and_place))
    assert not without.HasSubsystemNamed("contact_detector")
    assert ports(looking.GetSubsystemByName("contact_detector")) == DETECTOR


def test_estimates_are_made_of_measurements_and_of_nothing_else(pick_and_place):
    """The truth goes into the sensors and into the scores; from there no wire leads back."""
    sources = {}
    for (target, _), (source, _) in pick_and_place.diagram.connection_map().items():
        sources.setdefault(target.get_name(), set()).add(source.get_name())
    for finger in FINGERS:
        assert sources[f"{finger}.estimation"] == {f"{finger}.sensors", f"{finger}.base_pose"}
    scores = {name for name in sources if name.endswith(".scoring")} | {"true_contact"}
    readers = {name for name, found in sources.items() if found & scores}
    assert readers == {"logs", "object_width_error"}
    assert not any("object_width_error" in found for found in sources.values())


def test_ports_of_the_drives(free_bending, box_grasp):
    drive = free_bending.diagram.GetSubsystemByName("left_finger.pressure_drive")
    assert ports(drive) == (["left_finger.pressure_command"], ["left_finger.pressure", "actuation"])
    shared = box_grasp.diagram.GetSubsystemByName("gripper.pressure_drive")
    commands, pressures = ([f"{finger}.{name}" for finger in FINGERS] for name in ("pressure_command", "pressure"))
    assert ports(shared) == (commands, [*pressures, "actuation"])


@pytest.mark.slow
@pytest.mark.parametrize("overrides", [[NO_CONTACT, "control.force_bound=false"], [CONTACT]], ids=["", "contact"])
@pytest.mark.parametrize("name", scenario_names())
def test_every_signal_is_logged_and_has_a_unit_and_labels(name, overrides):
    station = make_station(load_scenario(name, overrides))
    _, outputs = ports(station.diagram)
    assert outputs == list(station.logs.signals) == list(station.parts.signals)
    assert len(ports(station.logs)[0]) < len(outputs)
    for signal, port in station.parts.signals.items():
        found = signal_of(port)
        assert found == station.logs.signals[signal]
        assert "entry" not in found.axes, f"{signal} is not described"
        assert np.prod([len(labels) for labels in found.axes.values()]) == port.size()
        units = [found.unit] if isinstance(found.unit, str) else found.unit
        assert all(units)


def test_plant_is_a_direct_child_and_its_only_neighbours_below_are_ours(free_bending):
    assert free_bending.diagram.GetSubsystemByName("plant") is free_bending.plant
    assert free_bending.plant.get_name() == "plant"
    nested = [system for system in free_bending.diagram.GetSystems() if isinstance(system, Diagram)]
    own = {"FingerSensors", "FingerEstimation", "FingerScoring", "PressureDrive", "SignalLogs", "StepSource"}
    assert {type(system).__name__ for system in nested} == own


def test_plant_stays_a_direct_child_under_an_arm(pick_and_place):
    assert pick_and_place.diagram.GetSubsystemByName("plant") is pick_and_place.plant
    nested = {type(s).__name__ for s in pick_and_place.diagram.GetSystems() if isinstance(s, Diagram)}
    of_fingers = {"FingerSensors", "FingerEstimation", "FingerScoring", "PressureDrive"}
    assert nested == {*of_fingers, "SignalLogs", "GravityCompensation", "GripControl"}


def seen_of(parts):
    """The number of shapes that a Meshcat or a camera sees on the links of the first finger."""
    inspector, finger = parts.scene_graph.model_inspector(), parts.fingers[0]
    frames = [finger.plant.GetBodyFrameIdOrThrow(link.index()) for link in finger.links]
    counts = {
        sum(len(inspector.GetGeometries(f, role)) for f in frames) for role in (Role.kIllustration, Role.kPerception)
    }
    (count,) = counts
    return count


def test_fingers_are_seen_only_where_something_can_look_at_them():
    scenario = load_scenario("free_bending")
    every = 13 + 10 + 2 * 3  # links, and the wedges between them, of three parts at both ends
    assert seen_of(make_station(scenario).parts) == 0
    assert seen_of(make_station(scenario, Meshcat()).parts) == every
    assert seen_of(add_station(DiagramBuilder(), scenario)) == every


def test_each_finger_of_a_model_bends_under_its_own_pressure():
    own = ("left_finger: [20.0e3]", "right_finger: [-20.0e3]")
    short = [f"pressure.steps={{{', '.join(own)}}}", "pressure.hold_samples=1"]
    scenario = load_scenario(
        "box_grasp", [*short, "gravity=[0, 0, 0]"]
    )  # weight bends a finger, and not as pressure does
    recording = simulate(scenario)
    left, right = (recording[f"{finger}.sampled_joint_angles"][-1].values for finger in FINGERS)
    assert (left > 0).all()
    assert (right < 0).all()
    assert abs(left + right).max() < 1e-3
