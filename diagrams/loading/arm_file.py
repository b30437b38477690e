"""URDF files of real arms, made such that Drake simulates them."""

import xml.etree.ElementTree as ET
from pathlib import Path

from soft_gripper.diagrams.loading.arm_joints import actuate, check_limits, movable_joints
from soft_gripper.diagrams.loading.arm_shapes import convert_meshes, set_colors
from soft_gripper.diagrams.loading.link_inertia import repair_inertia
from soft_gripper.errors import InputError
from soft_gripper.fingers.finger_links import DRAKE
from soft_gripper.fingers.urdf import expand_urdf

_FOREIGN = (
    (".", "gazebo"),
    (".", "ros2_control"),
    ("joint", "safety_controller"),
    ("joint", "calibration"),
    ("joint", "mimic"),
    ("transmission/actuator", "mechanicalReduction"),
)
_FOREIGN_ATTRIBUTES = (
    ("link", "type"),
    ("joint/dynamics", "friction"),
    ("joint[@type='continuous']/limit", "lower"),  # to be left aside by the URDF specification, but not by Drake
    ("joint[@type='continuous']/limit", "upper"),
)
_HARMLESS_XACRO = ("}property", "}arg")


def arm_urdf(path: Path, text: str | None = None) -> str:
    """URDF text with which Drake simulates an arm; what Drake understands already stays as it is.

    Args:
        path: the file, to which relative names in it refer.
        text: what is in it, if it has been read.

    Raises:
        InputError: if it is no URDF or unexpanded xacro, a mesh is missing, or a joint has no limits.
    """
    robot = ET.fromstring(expand_urdf(path).text if text is None else text)
    _drop_foreign(robot)
    _refuse_xacro(path, robot)
    _free_from_world(robot)
    joints = movable_joints(robot)
    for joint in joints:
        check_limits(path, joint)
    actuate(robot)
    repair_inertia(path, robot, {child.get("link", "") for joint in joints for child in joint.findall("child")})
    set_colors(robot)
    convert_meshes(path, robot)
    _filter_self_collisions(robot)
    return ET.tostring(robot, encoding="unicode")


def _drop_foreign(robot: ET.Element) -> None:
    """Takes out what Drake warns of or leaves aside, and couplings: either joint has an actuator that holds it."""
    for path, tag in _FOREIGN:
        for parent in robot.findall(path):
            for child in parent.findall(tag):
                parent.remove(child)
    for path, attribute in _FOREIGN_ATTRIBUTES:
        for element in robot.findall(path):
            element.attrib.pop(attribute, None)


def _refuse_xacro(path: Path, robot: ET.Element) -> None:
    for element in robot.iter():
        macros = [value for value in element.attrib.values() if "${" in value or "$(" in value]
        if "xacro" in element.tag and not element.tag.endswith(_HARMLESS_XACRO):
            macros.insert(0, element.tag.rpartition("}")[2])
        if macros:
            raise InputError(path, "xacro", macros[0], f"is not expanded; run: xacro {path.name} -o arm.urdf")


def _free_from_world(robot: ET.Element) -> None:
    """Lets a scenario place the arm by its first link: that is the root, and not the world to Drake."""
    for link in [*robot.findall("link"), *robot.findall("joint/parent")]:
        key = "name" if link.tag == "link" else "link"
        if link.get(key) == "world":
            link.set(key, f"{robot.get('name')}_world")
    children = {child.get("link") for child in robot.findall("joint/child")}
    for root in (link for link in robot.findall("link") if link.get("name") not in children):
        robot.remove(root)
        robot.insert(0, root)


def _filter_self_collisions(robot: ET.Element) -> None:
    """Neighbouring links of most arms overlap, which is not contact."""
    tag = DRAKE + "collision_filter_group"
    if robot.find(tag) is None:
        group = ET.SubElement(robot, tag, name="arm_links")
        for link in robot.findall("link"):
            ET.SubElement(group, DRAKE + "member", link=link.get("name", ""))
        ET.SubElement(group, DRAKE + "ignored_collision_filter_group", name="arm_links")
