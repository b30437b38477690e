"""The wiring of a station, port by port."""

import pytest
from pydrake.geometry import Meshcat, Role
from pydrake.systems.framework import DiagramBuilder

from soft_gripper.diagrams.station import add_station, make_station
from soft_gripper.scenario.scenario_file import load_scenario

FINGERS = ("left_finger", "right_finger")
CONTACT, NO_CONTACT = "estimator.contact_threshold=2.5e-3", "estimator.contact_threshold=null"


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
    assert readers == {"object_width_error"}
    assert not any("object_width_error" in found for found in sources.values())


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
