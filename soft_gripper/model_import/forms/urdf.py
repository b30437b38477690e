"""URDF, made ready for Drake; fingers in it are expanded before."""

import xml.etree.ElementTree as ET

from soft_gripper.files.notes import LEFT_OUT
from soft_gripper.files.xml_text import number, take
from soft_gripper.model_import.imported_model import Form, ImportedModel, ImportOptions
from soft_gripper.model_import.links_and_joints import (
    JOINTED,
    convert_meshes,
    drop_others,
    mend_joints,
    mend_links,
    plain,
    remove_links,
    scale_inertias,
)
from soft_gripper.model_import.model_file import ModelFile

# What a robot may have, by the element around it; all else is for other programs.
_CHILD_TAGS = {
    ".": ("link", "joint", "material", "transmission", "frame"),
    "link": ("inertial", "visual", "collision"),
    "joint": ("parent", "child", "origin", "axis", "limit", "dynamics", "mimic"),
}


def read(robot: ModelFile, options: ImportOptions) -> ImportedModel:
    """Raises an InputError if it is unexpanded xacro, a mesh is missing, or it contradicts itself or the options."""
    remove_links(robot, options.without)
    drop_others(robot, _CHILD_TAGS)
    for limit in robot.root.findall("joint[@type='continuous']/limit"):  # ignored by the specification, not by Drake
        limit.attrib.pop("lower", None)
        limit.attrib.pop("upper", None)
    for link in robot.root.findall("link"):
        link.attrib.pop("type", None)
    for element in robot.root.iter():
        macros = [value for value in element.attrib.values() if "${" in value or "$(" in value]
        if isinstance(element.tag, str) and "xacro" in element.tag:
            macros.insert(0, plain(element.tag))
        if macros:
            robot.refuse("xacro", macros[0], f"is not expanded; run: xacro {robot.path.name} -o arm.urdf")
    mimics = mend_joints(robot, options)
    if options.is_arm:
        actuate(robot)
    else:
        used_names: set[str | None] = set()  # of actuators
        for transmission in robot.root.findall("transmission"):
            names = {motor.get("name") for motor in transmission.findall("actuator")}
            if names & used_names:
                robot.root.remove(transmission)
                name = f"<transmission> '{transmission.get('name')}'"
                robot.note(LEFT_OUT, name, ", ".join(map(str, names)), "another has an actuator of this name")
            used_names |= names
    mend_links(robot, options)
    _set_colors(robot)
    convert_meshes(robot, options.is_arm)
    return ImportedModel(ET.tostring(robot.root, encoding="unicode"), ".urdf", mimics)


FORM = Form("URDF", ("robot",), read, scale_inertias)


def actuate(robot: ModelFile) -> None:
    """Gives every movable joint one actuator; those of transmissions that Drake understands are kept."""
    idle_joints: list[str] = []  # that move and have an effort: Drake knows no actuator of zero effort
    for joint in robot.root.findall("joint"):
        effort = number(f"{robot.path}: joint '{joint.get('name')}'", joint.find("limit"), "effort", "inf")
        if joint.get("type") in JOINTED and effort > 0:
            idle_joints.append(joint.get("name", ""))
    used_names: set[str] = set()
    for transmission in robot.root.findall("transmission"):
        joints, motors = ([part.get("name", "") for part in transmission.findall(tag)] for tag in ("joint", "actuator"))
        one_each = len(joints) == len(motors) == 1
        is_simple = "SimpleTransmission" in transmission.findtext("type", transmission.get("type", ""))
        if is_simple and one_each and joints[0] in idle_joints and motors[0] not in used_names:
            idle_joints.remove(joints[0])
            used_names.add(motors[0])
            for parent in [transmission, *transmission.findall("actuator")]:
                for reduction in take(parent, "mechanicalReduction"):
                    if (value := (reduction.text or "").strip()) not in ("1", "1.0"):
                        name = f"<transmission> '{transmission.get('name')}': mechanicalReduction"
                        robot.note(LEFT_OUT, name, value, "limits of joints are those after the gears")
        else:
            robot.root.remove(transmission)
            if not is_simple:
                name = f"<transmission> '{transmission.get('name')}'"
                robot.note(LEFT_OUT, name, ", ".join(joints), "every joint has an actuator of its own")
    for joint_name in idle_joints:
        transmission = ET.SubElement(robot.root, "transmission", name=f"{joint_name}_transmission")
        ET.SubElement(transmission, "type").text = "transmission_interface/SimpleTransmission"
        ET.SubElement(transmission, "joint", name=joint_name)
        ET.SubElement(transmission, "actuator", name=f"{joint_name}_actuator")


def _set_colors(robot: ModelFile) -> None:
    """Replaces named colours by their values: Drake wants each name defined exactly once, which files do not do."""
    colors: dict[str | None, ET.Element] = {}
    for material in robot.root.iter("material"):
        if (color := material.find("color")) is not None:
            colors.setdefault(material.get("name"), color)
    take(robot.root, "material")
    for link in robot.root.findall("link"):
        for visual in link.findall("visual"):
            for material in take(visual, "material"):
                own, name = material.find("color"), material.get("name")
                if (color := colors.get(name) if own is None else own) is not None:
                    ET.SubElement(visual, "material").append(color)
                elif name or len(material):
                    place = f"link '{link.get('name')}': material"
                    robot.note(LEFT_OUT, place, name, "the file gives no colour for it")
