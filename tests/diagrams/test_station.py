"""The wiring of a station, port by port."""

import numpy as np
import pytest
from pydrake.geometry import Meshcat, Role
from pydrake.systems.framework import DiagramBuilder

from soft_gripper.diagrams.simulation import simulate
from soft_gripper.diagrams.station import add_station, make_station
from soft_gripper.scenario.scenario_file import load_scenario
from soft_gripper.scenario.shipped import scenario_names
from soft_gripper.signals import signal_of

FINGERS = ("left_finger", "right_finger")
CONTACT, NO_CONTACT = "estimator.contact_threshold=2.5e-3", "estimator.contact_threshold=null"


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
def pick_and_place():
    """An arm that carries the gripper and leads it through a task; contact is looked for."""
    return make_station(load_scenario("pick_and_place_box", [CONTACT]))


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
