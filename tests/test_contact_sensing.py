"""Contact sensing in a station: which signals there are, and which shapes the truth looks at."""

import pytest

from soft_gripper.contact_detector import ContactDetector
from soft_gripper.diagrams import contact_sensing
from soft_gripper.diagrams.scenario_file import load_scenario
from soft_gripper.diagrams.signals import CONTACT_SIGNALS, WIDTH_SIGNALS
from soft_gripper.diagrams.station import make_station
from soft_gripper.finger_links import joint_name, link_name
from soft_gripper.true_contact import TrueContact

ONE_FINGER, TWO_FINGERS = "obstructed_inside", "box_grasp"


def station(name, threshold):
    return make_station(load_scenario(name, [f"sensor.contact_threshold={threshold}"]))


def contact_signals(built):
    """What the station logs of contact."""
    kinds = CONTACT_SIGNALS | WIDTH_SIGNALS
    return {name for name in built.logs.signals if name.partition(".")[2] in kinds}


@pytest.mark.parametrize("name", [ONE_FINGER, TWO_FINGERS])
def test_without_a_threshold_contact_is_not_looked_for(name):
    built = station(name, 0)
    assert contact_signals(built) == set()
    assert not built.diagram.HasSubsystemNamed("true_contact")


@pytest.mark.parametrize("name", [ONE_FINGER, TWO_FINGERS])
def test_signals_of_every_finger_and_the_width_between_two(name):
    built = station(name, 2.5e-3)
    fingers = [finger.name for finger in built.fingers]
    expected = {f"{finger}.{signal}" for finger in fingers for signal in CONTACT_SIGNALS}
    if name == TWO_FINGERS:
        assert len(fingers) == 2
        expected |= {f"grip.{signal}" for signal in WIDTH_SIGNALS}
    assert contact_signals(built) == expected
    context = built.diagram.CreateDefaultContext()
    for signal in expected:
        size = built.diagram.GetOutputPort(signal).Eval(context).shape
        assert size == ((3,) if signal.endswith("contact_center") else (1,))


def test_truth_looks_at_all_shapes_of_every_finger_and_at_no_others(monkeypatch):
    """Oracle: what moves with the first joint of a finger, and its base."""
    seen = {}

    def spy(shapes):
        seen.update(shapes)
        return TrueContact(shapes)

    monkeypatch.setattr(contact_sensing, "TrueContact", spy)
    plant = station(TWO_FINGERS, 2.5e-3).plant
    assert set(seen) == {"left_finger", "right_finger"}
    for finger, shapes in seen.items():
        moved = plant.GetBodiesKinematicallyAffectedBy([plant.GetJointByName(joint_name(finger, 0)).index()])
        bodies = [plant.GetBodyByName(link_name(finger, 0)), *(plant.get_body(index) for index in moved)]
        expected = [shape for body in bodies for shape in plant.GetCollisionGeometriesForBody(body)]
        assert len(bodies) == 13
        assert len(expected) >= 13
        assert shapes == frozenset(expected)


@pytest.mark.parametrize("name", [ONE_FINGER, TWO_FINGERS])
def test_detectors_are_told_what_the_scenario_says(monkeypatch, name):
    told = []

    def spy(layout, *others):
        told.append((layout.finger.name, layout.sections, *others))
        return ContactDetector(layout, *others)

    monkeypatch.setattr(contact_sensing, "ContactDetector", spy)
    overrides = ["sensor.contact_threshold=3e-3", "sensor.sections=3", "sensor.period=0.02", "gravity=[1, 2, -3]"]
    built = make_station(load_scenario(name, overrides))
    assert [finger for finger, *_ in told] == [finger.name for finger in built.fingers]
    for _, sections, gravity, period, threshold in told:
        assert (sections, gravity.tolist(), period, threshold) == (3, [1, 2, -3], 0.02, 3e-3)
