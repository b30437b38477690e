"""URDF files of real arms, adapted so that Drake can simulate them."""

import math
import os
import re
import xml.etree.ElementTree as ET
from collections.abc import Iterator
from pathlib import Path

from soft_gripper.errors import InputError
from soft_gripper.files.xml_text import number, read_xml
from soft_gripper.fingers.finger_links import DRAKE
from soft_gripper.fingers.urdf import expand_urdf
from soft_gripper.models import package_map
from soft_gripper.scenario.drake_parsing import check_inside
from soft_gripper.scenario.mesh_object import check_mesh_file, converted
from soft_gripper.scenario.model_numbers import repair_inertia


def is_known_package(name: str) -> bool:
    """Whether a mesh is in a package that the parser finds without help."""
    package = name.removeprefix("package://").partition("/")[0]
    return name.startswith("package://") and package_map().Contains(package)


def mesh_file(name: str, urdf: Path) -> Path:
    """The file behind a mesh name in a URDF file.

    Packages are looked for above the URDF file and along ROS_PACKAGE_PATH and AMENT_PREFIX_PATH: folders with the
    package's name, or with a package.xml that gives it.

    Raises:
        InputError: if there is no such file.
    """
    uri = re.fullmatch(r"(?:package|model):/+([^/]+)/(.+)", name)
    if uri is None:
        candidates = [Path(os.path.realpath(urdf.parent)) / name.removeprefix("file://")]
    else:
        package, inside = uri.groups()
        check_inside(urdf, f"package://{package}/{inside}")
        candidates = [root / inside for root in _package_roots(package, urdf)]
        if not candidates:
            expected = (
                f"no folder '{package}', and no package.xml of that name, in any folder above the file or along "
                "ROS_PACKAGE_PATH or AMENT_PREFIX_PATH; set ROS_PACKAGE_PATH to the folder that holds the package"
            )
            raise InputError(urdf, "mesh", name, expected)
    for candidate in candidates:
        if os.path.isfile(candidate):
            return candidate
    raise InputError(urdf, "mesh", name, f"there is no file {', nor '.join(map(str, candidates))}")


def _package_roots(package: str, urdf: Path) -> Iterator[Path]:
    for folder in _search_path(urdf):
        if os.path.isdir(folder / package):
            yield folder / package
        if _package_name(folder) == package:
            yield folder


def _search_path(urdf: Path) -> list[Path]:
    ros, ament = (_folders(variable) for variable in ("ROS_PACKAGE_PATH", "AMENT_PREFIX_PATH"))
    return [*Path(os.path.realpath(urdf)).parents, *ros, *(folder / "share" for folder in ament)]


def _folders(variable: str) -> list[Path]:
    return [Path(folder) for folder in os.environ.get(variable, "").split(os.pathsep) if folder]


def _package_name(folder: Path) -> str | None:
    """What the package.xml of a folder, if it has one, calls the package."""
    try:
        return (read_xml(folder / "package.xml").findtext("name") or "").strip()
    except InputError:
        return None


_MOVABLE = ("revolute", "continuous", "prismatic")
_LIMIT = "<limit lower='...' upper='...' velocity='...' effort='...'/> in rad, rad/s and N m, or m, m/s and N"


def movable_joints(robot: ET.Element) -> list[ET.Element]:
    """The joints with one degree of freedom, in the order of the file."""
    return [joint for joint in robot.findall("joint") if joint.get("type") in _MOVABLE]


def check_limits(path: Path, joint: ET.Element) -> None:
    """Checks that a joint has the limits that an arm needs.

    Raises:
        InputError: if the limits of velocity, effort or, unless the joint is continuous, position are missing.
    """
    where, limit = f"{path}: joint '{joint.get('name')}'", joint.find("limit")
    if limit is None:
        raise InputError(where, "limit", None, f"is missing; write {_LIMIT}")
    for attribute in ("effort", "velocity"):
        if not 0 < number(where, limit, attribute) < math.inf:
            expected = f"give what the joint can do at most; write {_LIMIT}"
            raise InputError(where, f"limit.{attribute}", limit.get(attribute), expected)
    lower, upper = number(where, limit, "lower"), number(where, limit, "upper")
    if joint.get("type") != "continuous" and not -math.inf < lower < upper < math.inf:
        expected = f"give a range from limit.lower to limit.upper, or make the joint fixed; write {_LIMIT}"
        raise InputError(where, "limit.upper", limit.get("upper"), expected)


def actuate(robot: ET.Element) -> None:
    """Gives every movable joint one actuator; those of transmissions that Drake understands are kept."""
    idle = [joint.get("name", "") for joint in movable_joints(robot)]
    taken: set[str] = set()
    for transmission in robot.findall("transmission"):
        joints, motors = ([part.get("name", "") for part in transmission.findall(tag)] for tag in ("joint", "actuator"))
        one_each = len(joints) == len(motors) == 1
        if _is_simple(transmission) and one_each and joints[0] in idle and motors[0] not in taken:
            idle.remove(joints[0])
            taken.add(motors[0])
        else:
            robot.remove(transmission)
    robot.extend(_transmission(name) for name in idle)


def _is_simple(transmission: ET.Element) -> bool:
    kind = transmission.findtext("type", transmission.get("type", ""))
    return "SimpleTransmission" in kind


def _transmission(joint: str) -> ET.Element:
    transmission = ET.Element("transmission", name=f"{joint}_transmission")
    ET.SubElement(transmission, "type").text = "transmission_interface/SimpleTransmission"
    ET.SubElement(transmission, "joint", name=joint)
    ET.SubElement(transmission, "actuator", name=f"{joint}_actuator")
    return transmission


_DRAKE_READS = (".obj", ".gltf", ".vtk")


def convert_meshes(path: Path, robot: ET.Element) -> None:
    """Gives all shapes of a URDF mesh files that Drake reads, of which it takes the convex hulls for collisions.

    Args:
        path: of the URDF file, to which relative names refer.

    Raises:
        InputError: if a mesh is missing or cannot be read.
    """
    for shape in [*robot.findall("link/visual"), *robot.findall("link/collision")]:
        for mesh in shape.findall("geometry/mesh"):
            if shape.tag == "collision" and not _is_made_for_drake(shape, mesh):
                ET.SubElement(mesh, DRAKE + "declare_convex")
            if not is_known_package(mesh.get("filename", "")):
                _find(path, shape, mesh)


def _is_made_for_drake(shape: ET.Element, mesh: ET.Element) -> bool:
    return len(mesh) > 0 or shape.find(DRAKE + "proximity_properties") is not None


def _find(path: Path, shape: ET.Element, mesh: ET.Element) -> None:
    file = mesh_file(mesh.get("filename", ""), path)
    is_foreign = file.suffix.lower() not in _DRAKE_READS
    try:
        check_mesh_file(file)
        file = converted(file) if is_foreign else file
    except InputError as error:
        raise error.inside(path) from None
    if is_foreign and file.with_suffix(".mtl").exists():
        for material in shape.findall("material"):  # Drake prefers it to the colours of the file
            shape.remove(material)
    mesh.set("filename", f"file://{file}")


def set_colors(robot: ET.Element) -> None:
    """Replaces named colours by their values: Drake wants each name defined exactly once, which files do not do."""
    colors: dict[str | None, ET.Element] = {}
    for material in robot.iter("material"):
        if (color := material.find("color")) is not None:
            colors.setdefault(material.get("name"), color)
    for material in robot.findall("material"):
        robot.remove(material)
    for visual in robot.findall("link/visual"):
        for material in visual.findall("material"):
            visual.remove(material)
            own = material.find("color")
            if (color := colors.get(material.get("name")) if own is None else own) is not None:
                ET.SubElement(visual, "material").append(color)


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
    ("joint[@type='continuous']/limit", "lower"),  # ignored according to the URDF specification, but not by Drake
    ("joint[@type='continuous']/limit", "upper"),
)
_HARMLESS_XACRO = ("}property", "}arg")


def arm_urdf(path: Path, text: str | None = None) -> str:
    """URDF text with which Drake can simulate an arm; what Drake understands already is kept.

    Args:
        path: the file, to which relative names in it refer.
        text: its contents, if it has been read.

    Raises:
        InputError: if it is not a URDF or is unexpanded xacro, a mesh is missing, or a joint has no limits.
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
    """Removes what Drake warns about or ignores, and couplings: each joint has an actuator of its own that holds it."""
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
    """Lets a scenario place the arm by its first link, which must not be called `world`, Drake's name for the world."""
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
