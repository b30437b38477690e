"""URDF and SDFormat files as they are found, made ready for Drake: mended alike, whatever they describe.

What Drake does not use is removed before anything is checked. What had an effect there is not removed in silence.
"""

import math
import xml.etree.ElementTree as ET
from collections.abc import Sequence
from pathlib import Path
from typing import NamedTuple

from soft_gripper.control.couplings import Mimic
from soft_gripper.errors import InputError
from soft_gripper.files.notes import LEFT_OUT, note
from soft_gripper.files.xml_text import DRAKE, MOST, check_counts, finite_numbers, joint_end, number
from soft_gripper.fingers.urdf import remove_links
from soft_gripper.scenario.convex_parts import note_hull
from soft_gripper.scenario.link_inertia import massless, repair_inertia
from soft_gripper.scenario.mesh_checks import check_mesh_file
from soft_gripper.scenario.mesh_names import is_known_package, mesh_file
from soft_gripper.scenario.mesh_object import converted, outward
from soft_gripper.scenario.nested_models import fix_if_static, flatten

# What a URDF may have, by the element around it; all else is for other programs.
_URDF = {
    ".": ("link", "joint", "material", "transmission", "frame"),
    "link": ("inertial", "visual", "collision"),
    "joint": ("parent", "child", "origin", "axis", "limit", "dynamics", "mimic"),
}
_SDF = {
    "link": (
        *("pose", "inertial", "collision", "visual", "gravity", "enable_wind", "self_collide", "kinematic"),
        *("must_be_base_link", "velocity_decay"),
    ),
    "link/collision": ("pose", "geometry", "surface", "max_contacts", "laser_retro", "density", "auto_inertia_params"),
    "link/visual": (
        *("pose", "geometry", "material", "cast_shadows", "laser_retro", "transparency", "visibility_flags", "meta"),
    ),
    "joint": (
        *("parent", "child", "pose", "axis", "axis2", "physics"),
        *("gearbox_ratio", "gearbox_reference_body", "thread_pitch", "screw_thread_pitch"),
    ),
}
_SDF_ATTRIBUTES = {"link": ("name",), "collision": ("name",), "visual": ("name",), "joint": ("name", "type")}
_OTHER_IN_SDF = (
    *("plugin", "sensor", "light", "projector", "battery", "particle_emitter", "audio_source", "audio_sink", "script"),
)
_UNUSED = ("calibration", "property", "arg")  # without any effect; the last two of xacro
_WITHOUT_AXIS = ("fixed", "floating", "ball")
_JOINTED = ("revolute", "continuous", "prismatic")
_OF_AXIS = ("axis", "axis2", "limit", "dynamics", "mimic")


class Ready(NamedTuple):
    """Text that Drake reads, the couplings of its joints, and pairs of groups of bodies that never touch each other."""

    text: str
    mimics: tuple[Mimic, ...]
    apart: tuple[tuple[list[str], list[str]], ...] = ()


def ready(
    path: Path,
    root: ET.Element,
    is_arm: bool = False,
    free: bool = False,
    child: str | None = None,
    without: Sequence[str] = (),
) -> Ready:
    """A model with which Drake can simulate an arm, a gripper or an object; what Drake understands already is kept.

    Args:
        path: the file, to which relative names in it refer.
        root: its root element, <robot> or <sdf>, which is changed.
        is_arm: its joints get actuators, its meshes become convex for contact.
        free: the model is not welded to anything.
        child: the frame at which it is welded; None: its first link.
        without: links that are left out, see `remove_links`.

    Raises:
        InputError: if it is unexpanded xacro, a mesh is missing, or it contradicts itself or `free` or `child`.
    """
    mimics: list[Mimic] = []
    if root.tag == "sdf":
        flatten(path, root)
        check_counts(path, root)
    for model in models_of(root):
        remove_links(path, model, without)
        _drop_others(path, model)
        _refuse_xacro(path, model)
        mimics += _take_mimics(path, model)
        _drop_friction(path, model)
        _check_ranges(path, model)
        _free_from_world(path, model, free, child)
        if model.tag == "robot":
            actuate(path, model) if is_arm else _drop_doubles(path, model)
        _drop_empty_shapes(path, model)
        repair_inertia(path, model, _moving(model, free))
        if model.tag == "robot":
            set_colors(path, model)
        convert_meshes(path, model, is_arm)
    return Ready(ET.tostring(root, encoding="unicode"), tuple(mimics))


def models_of(root: ET.Element) -> list[ET.Element]:
    """The models of a file: its only one, the root, in URDF."""
    return [root] if root.tag == "robot" else [*root.findall("model"), *root.findall("world/model")]


def _drop_others(path: Path, model: ET.Element) -> None:
    """Removes what is for other programs, and what a joint of a kind does not use."""
    is_urdf = model.tag == "robot"
    for around, known in (_URDF if is_urdf else _SDF).items():
        for parent in [model] if around == "." else model.findall(around):
            for element in [element for element in parent if _is_other(element, known)]:
                _remove(path, parent, element)
    for parent in () if is_urdf else list(model.iter()):
        for element in [element for element in parent if element.tag in _OTHER_IN_SDF]:
            _remove(path, parent, element)
        _drop_attributes(path, parent)
    for link in () if is_urdf else model.findall("link"):
        for tag in ("collision", "visual"):
            _tell_apart(link.findall(tag))
    for joint in model.findall("joint"):
        for tag in _OF_AXIS if joint.get("type") in _WITHOUT_AXIS else ():
            for element in joint.findall(tag):
                joint.remove(element)
    for limit in model.findall("joint[@type='continuous']/limit"):  # ignored by URDF's specification, not by Drake
        limit.attrib.pop("lower", None)
        limit.attrib.pop("upper", None)
    for link in model.findall("link") if is_urdf else ():
        link.attrib.pop("type", None)


def _tell_apart(shapes: Sequence[ET.Element]) -> None:
    """Gives shapes of the same name, which SDFormat does not allow, names of their own."""
    taken: set[str | None] = set()
    for place, shape in enumerate(shapes):
        if shape.get("name") in taken:
            shape.set("name", f"{shape.get('name')}_{place}")
        taken.add(shape.get("name"))


def _drop_attributes(path: Path, element: ET.Element) -> None:
    known = _SDF_ATTRIBUTES.get(element.tag)
    for name in [name for name in element.attrib if known and name not in known and not name.startswith(DRAKE)]:
        value = element.attrib.pop(name)
        note(LEFT_OUT, path, f"{element.tag} '{element.get('name')}': {name}", value, "SDFormat has no such attribute")


def _is_other(element: ET.Element, known: tuple[str, ...]) -> bool:
    tag = element.tag
    is_macro = isinstance(tag, str) and "xacro" in tag and _plain(tag) not in _UNUSED
    return isinstance(tag, str) and tag not in known and not tag.startswith(DRAKE) and not is_macro


def _plain(tag: str) -> str:
    return tag.rpartition("}")[2]


def _remove(path: Path, parent: ET.Element, element: ET.Element) -> None:
    parent.remove(element)
    tag = _plain(element.tag)
    if tag in _UNUSED:
        return
    name = element.get("name") or element.get("reference") or parent.get("name", "")
    value = (element.text or "").strip() or element.get("filename", "")
    note(LEFT_OUT, path, f"<{tag}> of '{name}'", value, "it is for other programs")


def _refuse_xacro(path: Path, model: ET.Element) -> None:
    for element in model.iter() if model.tag == "robot" else ():
        macros = [value for value in element.attrib.values() if "${" in value or "$(" in value]
        if isinstance(element.tag, str) and "xacro" in element.tag:
            macros.insert(0, _plain(element.tag))
        if macros:
            raise InputError(path, "xacro", macros[0], f"is not expanded; run: xacro {path.name} -o arm.urdf")


def _moving(model: ET.Element, free: bool) -> set[str]:
    """The links that have degrees of freedom of their own: those on joints that move, and the first of a free model."""
    joints = [joint for joint in model.findall("joint") if joint.get("type") != "fixed"]
    links = [link.get("name", "") for link in model.findall("link")]
    return {joint_end(joint, "child") for joint in joints} | set(links[:1] if free else ())


def _drop_empty_shapes(path: Path, model: ET.Element) -> None:
    """Removes shapes whose sizes are all zero."""
    for link in model.findall("link"):
        for shape in [*link.findall("visual"), *link.findall("collision")]:
            for solid in shape.findall("geometry/*"):
                texts = [*solid.attrib.values(), *(child.text or "" for child in solid)]
                if solid.tag in ("box", "sphere", "cylinder") and texts and not any(map(_may_have_size, texts)):
                    link.remove(shape)
                    note(LEFT_OUT, path, f"link '{link.get('name')}': {shape.tag}", " ".join(texts), "it has no size")
                    break


def _may_have_size(text: str) -> bool:
    return any(word.strip("+-0.") for word in text.split())


def _drop_friction(path: Path, model: ET.Element) -> None:
    for joint in model.findall("joint"):
        for dynamics in [*joint.findall("dynamics"), *joint.findall("axis/dynamics")]:
            place = f"joint '{joint.get('name')}'"
            friction = number(f"{path}: {place}", dynamics, "friction")
            dynamics.attrib.pop("friction", None)
            for element in dynamics.findall("friction"):
                dynamics.remove(element)
            if friction:
                note(LEFT_OUT, path, f"{place}: dynamics.friction", friction, "Drake's joints have damping only")


def _check_ranges(path: Path, model: ET.Element) -> None:
    """Gives limits of URDF the end that they leave out, which is 0 if the other one is given.

    Raises:
        InputError: if a lower limit is above the upper one.
    """
    for joint in model.findall("joint"):
        where = f"{path}: joint '{joint.get('name')}'"
        for limit in [*joint.findall("limit"), *joint.findall("axis/limit")]:
            ends = {which for which in ("lower", "upper") if limit.get(which) is not None}
            if len(ends) == 1:
                limit.set(({"lower", "upper"} - ends).pop(), "0")
            lower, upper = (number(where, limit, which, far) for which, far in (("lower", "-inf"), ("upper", "inf")))
            for which, value in (("lower", lower), ("upper", upper)):
                if abs(value) > MOST and limit.get(which) is not None:
                    limit.set(which, repr(math.copysign(MOST, value)))  # as good as none
                for element in limit.findall(which) if abs(value) > MOST else ():
                    element.text = repr(math.copysign(MOST, value))  # 1e16 by default in SDFormat
            if lower > upper:
                raise InputError(where, "limit.upper", upper, f"must be at least limit.lower, {lower:g}")


def _take_mimics(path: Path, model: ET.Element) -> list[Mimic]:
    """Takes the couplings out of a model.

    Raises:
        InputError: if a joint follows one that does not exist, cannot be followed, or follows it in turn.
    """
    mimics: dict[str, Mimic] = {}
    kinds = {joint.get("name", ""): joint.get("type", "") for joint in model.findall("joint")}
    for joint in model.findall("joint"):
        for parent in [joint, *joint.findall("axis")]:
            for element in parent.findall("mimic"):
                parent.remove(element)
                found = _mimic(path, joint.get("name", ""), element)
                if kinds.get(found.leader) not in _JOINTED:
                    known = ", ".join(name for name, kind in kinds.items() if kind in _JOINTED)
                    expected = f"no joint with one degree of freedom has this name; known: {known}"
                    raise InputError(f"{path}: joint '{found.joint}'", "mimic.joint", found.leader, expected)
                mimics[found.joint] = found
    check_chains(path, list(mimics.values()))
    return list(mimics.values())


def check_chains(path: Path, mimics: Sequence[Mimic]) -> None:
    """Raises an InputError if a joint follows itself by way of others."""
    leaders = {mimic.joint: mimic.leader for mimic in mimics}
    for name in leaders:
        leader = leaders[name]
        for _ in leaders:
            leader = leaders[leader] if leader in leaders and leader != name else leader
        if leader in leaders:
            raise InputError(f"{path}: joint '{name}'", "mimic.joint", leaders[name], "follows it in turn")


def _mimic(path: Path, name: str, element: ET.Element) -> Mimic:
    where = f"{path}: joint '{name}'"
    multiplier, offset, reference = (
        finite_numbers(where, f"mimic.{key}", str(number(where, element, key, default)), 1)[0]
        for key, default in (("multiplier", "1"), ("offset", "0"), ("reference", "0"))
    )
    return Mimic(name, element.get("joint", ""), multiplier, offset - multiplier * reference)


def _free_from_world(path: Path, model: ET.Element, free: bool, child: str | None) -> None:
    """Lets a scenario place a model that its file joins to the world.

    The world of the file becomes the first link of the model, `{model}_world`: where nothing else is said, the model
    stays where its file puts it. A free model loses the joint that fixes it.

    Raises:
        InputError: if a free model, or one that is welded at `child`, hangs on a joint to the world that moves.
    """
    fix_if_static(model)
    joints = [joint for joint in model.findall("joint") if joint_end(joint, "parent") == "world"]
    links = [link for link in model.findall("link") if link.get("name") == "world"]
    moving = [joint for joint in joints if joint.get("type") not in ("fixed", "floating")]
    if moving and (free or child is not None):
        field, value = ("free", True) if free else ("child", child)
        expected = f"leave it out: joint '{moving[0].get('name')}' of the file joins the model to the world"
        raise InputError(path, field, value, expected)
    for joint in [joint for joint in joints if free or joint.get("type") == "floating"]:
        model.remove(joint)
        joints.remove(joint)
        if joint.get("type") == "fixed":
            note(LEFT_OUT, path, f"joint '{joint.get('name')}'", "world", "the scenario has the model free")
    anchor = f"{model.get('name')}_world"
    for joint in joints:
        _name_end(joint, "parent", anchor)
    for link in links:
        link.set("name", anchor)
    if free and links and not joints and len(model.findall("link")) > 1:
        model.remove(links[0])
    elif joints and not links:
        at = next((i for i, element in enumerate(model) if element.tag == "link"), 0)
        model.insert(at, massless(ET.Element("link", name=anchor), model.tag == "model"))
    children = {joint_end(joint, "child") for joint in model.findall("joint")}
    for root in (link for link in model.findall("link") if (free or links) and link.get("name") not in children):
        model.remove(root)  # the first link is the one whose place is that of the object
        model.insert(0, root)


def _name_end(joint: ET.Element, which: str, link: str) -> None:
    for element in joint.findall(which):
        if element.get("link") is None:
            element.text = link
        else:
            element.set("link", link)


def actuate(path: Path, robot: ET.Element) -> None:
    """Gives every movable joint one actuator; those of transmissions that Drake understands are kept."""
    idle = [joint.get("name", "") for joint in robot.findall("joint") if _can_push(path, joint)]
    taken: set[str] = set()
    for transmission in robot.findall("transmission"):
        joints, motors = ([part.get("name", "") for part in transmission.findall(tag)] for tag in ("joint", "actuator"))
        one_each = len(joints) == len(motors) == 1
        if _is_simple(transmission) and one_each and joints[0] in idle and motors[0] not in taken:
            idle.remove(joints[0])
            taken.add(motors[0])
            _drop_reduction(path, transmission)
        else:
            robot.remove(transmission)
            if not _is_simple(transmission):
                name = f"<transmission> '{transmission.get('name')}'"
                note(LEFT_OUT, path, name, ", ".join(joints), "every joint has an actuator of its own")
    robot.extend(_transmission(name) for name in idle)


def _drop_doubles(path: Path, robot: ET.Element) -> None:
    """Removes transmissions whose actuators have names that others have."""
    taken: set[str | None] = set()
    for transmission in robot.findall("transmission"):
        names = {motor.get("name") for motor in transmission.findall("actuator")}
        if names & taken:
            robot.remove(transmission)
            name = f"<transmission> '{transmission.get('name')}'"
            note(LEFT_OUT, path, name, ", ".join(map(str, names)), "another has an actuator of this name")
        taken |= names


def _can_push(path: Path, joint: ET.Element) -> bool:
    """Whether a joint moves and its file does not give it an effort of zero, for which Drake knows no actuator."""
    effort = number(f"{path}: joint '{joint.get('name')}'", joint.find("limit"), "effort", "inf")
    return joint.get("type") in _JOINTED and effort > 0


def _is_simple(transmission: ET.Element) -> bool:
    kind = transmission.findtext("type", transmission.get("type", ""))
    return "SimpleTransmission" in kind


def _drop_reduction(path: Path, transmission: ET.Element) -> None:
    for parent in [transmission, *transmission.findall("actuator")]:
        for reduction in parent.findall("mechanicalReduction"):
            parent.remove(reduction)
            if (value := (reduction.text or "").strip()) not in ("1", "1.0"):
                name = f"<transmission> '{transmission.get('name')}': mechanicalReduction"
                note(LEFT_OUT, path, name, value, "limits of joints are those after the gears")


def _transmission(joint: str) -> ET.Element:
    transmission = ET.Element("transmission", name=f"{joint}_transmission")
    ET.SubElement(transmission, "type").text = "transmission_interface/SimpleTransmission"
    ET.SubElement(transmission, "joint", name=joint)
    ET.SubElement(transmission, "actuator", name=f"{joint}_actuator")
    return transmission


_DRAKE_READS = (".obj", ".gltf", ".vtk")


def convert_meshes(path: Path, model: ET.Element, to_convex: bool) -> None:
    """Gives all shapes mesh files that Drake reads; `to_convex`, collisions take their convex hulls, with a note.

    Args:
        path: of the file of the model, to which relative names refer.

    Raises:
        InputError: if a mesh is missing or cannot be read.
    """
    for link in model.findall("link"):
        for shape in [*link.findall("visual"), *link.findall("collision")]:
            for mesh in shape.findall("geometry/mesh"):
                name = _mesh_name(mesh)
                to_hull = to_convex and shape.tag == "collision" and not _is_made_for_drake(shape, mesh)
                if to_hull:
                    ET.SubElement(mesh, DRAKE + "declare_convex")
                if not is_known_package(name):
                    file, origin = _find(path, shape, mesh)
                    if to_hull:
                        note_hull(path, link.get("name", ""), file, origin)


def _is_made_for_drake(shape: ET.Element, mesh: ET.Element) -> bool:
    is_drakes = any(isinstance(child.tag, str) and child.tag.startswith(DRAKE) for child in mesh)
    return is_drakes or shape.find(DRAKE + "proximity_properties") is not None


def _mesh_name(mesh: ET.Element) -> str:
    return (mesh.get("filename") or mesh.findtext("uri") or "").strip()


def _find(path: Path, shape: ET.Element, mesh: ET.Element) -> tuple[Path, Path]:
    """Gives a mesh of a shape a file that Drake reads, and returns it and the one that the model names."""
    file = origin = mesh_file(_mesh_name(mesh), path)
    is_foreign = file.suffix.lower() not in _DRAKE_READS
    has_surface = shape.tag == "collision" and mesh.find(DRAKE + "declare_convex") is None
    try:
        check_mesh_file(file)
        file = converted(file) if is_foreign else file
        file = outward(file, origin) if has_surface and file.suffix == ".obj" else file
    except InputError as error:
        raise error.inside(path) from None
    if is_foreign and file.with_suffix(".mtl").exists():
        for material in shape.findall("material"):  # Drake prefers it to the colours of the file
            shape.remove(material)
    if mesh.get("filename") is not None:
        mesh.set("filename", f"file://{file}")
    for uri in mesh.findall("uri"):
        uri.text = f"file://{file}"
    return file, origin


def set_colors(path: Path, robot: ET.Element) -> None:
    """Replaces named colours by their values: Drake wants each name defined exactly once, which files do not do."""
    colors: dict[str | None, ET.Element] = {}
    for material in robot.iter("material"):
        if (color := material.find("color")) is not None:
            colors.setdefault(material.get("name"), color)
    for material in robot.findall("material"):
        robot.remove(material)
    for link in robot.findall("link"):
        for visual in link.findall("visual"):
            for material in visual.findall("material"):
                visual.remove(material)
                own, name = material.find("color"), material.get("name")
                if (color := colors.get(name) if own is None else own) is not None:
                    ET.SubElement(visual, "material").append(color)
                elif name or len(material):
                    place = f"link '{link.get('name')}': material"
                    note(LEFT_OUT, path, place, name, "the file gives no colour for it")
