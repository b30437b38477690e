"""Joints of third-party URDF files: one actuator each, with the limits of the file, or a message that names them."""

import xml.etree.ElementTree as ET
from pathlib import Path

import pytest
from pydrake.multibody.parsing import Parser
from pydrake.multibody.plant import MultibodyPlant

from soft_gripper.errors import InputError
from soft_gripper.scenario.arm_file import actuate, check_limits, movable_joints

FILE = Path("arm.urdf")
LIMIT = "<limit lower='-1' upper='2' velocity='3' effort='{}'/>"
SEVEN = LIMIT.format(7)
LINK = "<link name='{}'><inertial><mass value='1'/><inertia ixx='1' iyy='1' izz='1'/></inertial></link>"


def joint(name, kind="revolute", limit=SEVEN):
    """A joint from the link `base` to a link of the joint's name with an l before."""
    ends = f"<parent link='base'/><child link='l{name}'/>"
    return f"{LINK.format(f'l{name}')}<joint name='{name}' type='{kind}'>{ends}<axis xyz='0 0 1'/>{limit}</joint>"


def transmission(joints, motors, kind="transmission_interface/SimpleTransmission", inside=""):
    parts = "".join(f"<joint name='{name}'><hardwareInterface>Position</hardwareInterface></joint>" for name in joints)
    parts += "".join(f"<actuator name='{name}'>{inside}</actuator>" for name in motors)
    return f"<transmission name='t'><type>{kind}</type>{parts}</transmission>"


def robot(text):
    return ET.fromstring(f"<robot name='r' xmlns:drake='http://drake.mit.edu'>{LINK.format('base')}{text}</robot>")


def actuators(text):
    """The actuators that Drake gives a robot with these joints: name -> (joint, effort limit, gear ratio)."""
    element = robot(text)
    actuate(element)
    plant = MultibodyPlant(0.0)
    Parser(plant).AddModelsFromString(ET.tostring(element, encoding="unicode"), "urdf")
    plant.Finalize()
    found = [plant.get_joint_actuator(index) for index in plant.GetJointActuatorIndices()]
    return {a.name(): (a.joint().name(), a.effort_limit(), a.default_gear_ratio()) for a in found}


def test_every_movable_joint_has_an_actuator_with_its_effort_limit():
    kinds = {"a": "revolute", "b": "prismatic", "c": "continuous"}
    joints = "".join(joint(name, kind, LIMIT.format(effort)) for effort, (name, kind) in enumerate(kinds.items(), 5))
    made = actuators(joints + joint("d", "fixed", "") + joint("e", "floating", ""))
    assert sorted(made.values()) == [("a", 5, 1), ("b", 6, 1), ("c", 7, 1)]


def test_a_transmission_that_drake_understands_is_kept():
    geared = transmission(["a"], ["motor"], inside="<drake:gear_ratio value='50'/>")
    assert actuators(joint("a") + joint("b") + geared) == {"motor": ("a", 7, 50), "b_actuator": ("b", 7, 1)}


@pytest.mark.parametrize(
    "unfit",
    [
        transmission(["a"], ["motor"], "transmission_interface/DifferentialTransmission"),
        transmission(["a", "b"], ["motor"]),
        transmission(["a"], ["motor", "other"]),
        transmission(["a"], []),
        transmission(["nosuch"], ["motor"]),
        transmission(["f"], ["motor"]),
        "<transmission/>",
    ],
    ids=["other kind", "two joints", "two motors", "no motor", "no such joint", "fixed joint", "empty"],
)
def test_a_transmission_that_drake_leaves_aside_or_refuses_is_replaced(unfit, capfd):
    made = actuators(joint("a") + joint("b") + joint("f", "fixed", "") + unfit)
    assert sorted(name for name, _, _ in made.values()) == ["a", "b"]
    assert capfd.readouterr() == ("", "")


def test_a_joint_has_one_actuator_and_an_actuator_one_joint():
    twice = transmission(["a"], ["motor"]) + transmission(["a"], ["spare"]) + transmission(["b"], ["motor"])
    assert actuators(joint("a") + joint("b") + twice) == {"motor": ("a", 7, 1), "b_actuator": ("b", 7, 1)}


def test_the_kind_of_a_transmission_may_be_an_attribute():
    old = "<transmission type='pr2_mechanism_model/SimpleTransmission' name='t'>"
    assert list(actuators(joint("a") + f"{old}<actuator name='motor'/><joint name='a'/></transmission>")) == ["motor"]


def check(text):
    for element in movable_joints(robot(text)):
        check_limits(FILE, element)


@pytest.mark.parametrize(
    ("kind", "limit"),
    [
        ("revolute", LIMIT.format(1)),
        ("prismatic", "<limit upper='0.04' velocity='1' effort='1'/>"),  # from 0
        ("continuous", "<limit velocity='1' effort='1'/>"),
        ("fixed", ""),
    ],
)
def test_limits_that_do(kind, limit):
    check(joint("a", kind, limit))


@pytest.mark.parametrize(
    ("kind", "limit", "complaint"),
    [
        ("revolute", "", "limit = None: is missing; write <limit lower="),
        ("continuous", "", "limit = None: is missing; write <limit lower="),
        ("revolute", LIMIT.format(0), "limit.effort = '0': give what the joint can do at most; write <limit"),
        ("revolute", LIMIT.format(-3), "limit.effort = '-3': give what"),
        ("revolute", LIMIT.format("inf"), "limit.effort = 'inf': give what"),
        ("revolute", LIMIT.format("nan"), "limit.effort = 'nan': give a number"),
        ("revolute", LIMIT.format("much"), "limit.effort = 'much': give a number"),
        ("prismatic", "<limit lower='0' upper='1' velocity='1'/>", "limit.effort = None: give what"),
        ("continuous", "<limit effort='1'/>", "limit.velocity = None: give what"),
        ("revolute", "<limit velocity='1' effort='1'/>", "limit.upper = None: give a range from limit.lower"),
        ("revolute", "<limit lower='1' upper='-1' velocity='1' effort='1'/>", "limit.upper = '-1': give a range"),
        ("revolute", "<limit lower='0' upper='inf' velocity='1' effort='1'/>", "limit.upper = 'inf': give a range"),
    ],
)
def test_limits_that_do_not(kind, limit, complaint):
    with pytest.raises(InputError) as caught:
        check(joint("good") + joint("elbow", kind, limit))
    assert str(caught.value).startswith(f"arm.urdf: joint 'elbow': {complaint}")
    assert "\n" not in str(caught.value)
