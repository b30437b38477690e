"""Links and joints of URDF and SDFormat, mended alike for Drake, whatever they describe.

What Drake does not use is removed before anything is checked. What had an effect there is not removed in silence.
"""

import math
import xml.etree.ElementTree as ET
from collections.abc import Mapping, Sequence
from pathlib import Path

from soft_gripper.errors import InputError
from soft_gripper.files.notes import LEFT_OUT
from soft_gripper.files.xml_text import DRAKE, MOST, finite_numbers, joint_end, number
from soft_gripper.model_import.imported_model import ImportOptions, Mimic
from soft_gripper.model_import.link_inertia import massless, repair_inertia
from soft_gripper.model_import.mesh_checks import check_mesh_file
from soft_gripper.model_import.mesh_names import is_known_package, mesh_file
from soft_gripper.model_import.model_file import ModelFile

JOINTED = ("revolute", "continuous", "prismatic")
_IGNORED_TAGS = ("calibration", "property", "arg")  # without any effect; the last two of xacro
_WITHOUT_AXIS = ("fixed", "floating", "ball")
_AXIS_TAGS = ("axis", "axis2", "limit", "dynamics", "mimic")
_DRAKE_READS = (".obj", ".gltf", ".vtk")  # meshes


def drop_others(model: ModelFile, tags_by_parent: Mapping[str, Sequence[str]]) -> None:
    """Removes elements for other programs: those not in `tags_by_parent`, by path of the parent; "." is the model."""
    for path, tags in tags_by_parent.items():
        for parent in model.root.findall(path):
            for element in [element for element in parent if _is_other(element, tags)]:
                drop(model, parent, element)


def drop(model: ModelFile, parent: ET.Element, element: ET.Element) -> None:
    """Removes an element that is for other programs."""
    parent.remove(element)
    tag = plain(element.tag)
    if tag in _IGNORED_TAGS:
        return
    name = element.get("name") or element.get("reference") or parent.get("name", "")
    value = (element.text or "").strip() or element.get("filename", "")
    model.note(LEFT_OUT, f"<{tag}> of '{name}'", value, "it is for other programs")


def plain(tag: str) -> str:
    """A tag without its namespace."""
    return tag.rpartition("}")[2]


def _is_other(element: ET.Element, valid_tags: Sequence[str]) -> bool:
    tag = element.tag
    is_macro = isinstance(tag, str) and "xacro" in tag and plain(tag) not in _IGNORED_TAGS
    return isinstance(tag, str) and tag not in valid_tags and not tag.startswith(DRAKE) and not is_macro


def drop_unused(model: ModelFile) -> None:
    """Removes elements that are unused by a joint's type."""
    for joint in model.root.findall("joint"):
        for tag in _AXIS_TAGS if joint.get("type") in _WITHOUT_AXIS else ():
            for element in joint.findall(tag):
                joint.remove(element)


def mend_joints(model: ModelFile, options: ImportOptions) -> list[Mimic]:
    """Converts joints to kinds of Drake, and takes couplings out of a model; raises an InputError if it cannot."""
    mimics = _take_mimics(model)
    _drop_friction(model)
    _check_ranges(model)
    _free_from_world(model, options.free, options.child)
    return mimics


def _take_mimics(model: ModelFile) -> list[Mimic]:
    """Takes the couplings out of a model.

    Raises:
        InputError: if a joint follows one that does not exist, cannot be followed, or follows it in turn.
    """
    mimics: dict[str, Mimic] = {}
    kinds = {joint.get("name", ""): joint.get("type", "") for joint in model.root.findall("joint")}
    for joint in model.root.findall("joint"):
        for parent in [joint, *joint.findall("axis")]:
            for element in parent.findall("mimic"):
                parent.remove(element)
                mimic = _mimic(model, joint.get("name", ""), element)
                if kinds.get(mimic.leader) not in JOINTED:
                    joint_names = ", ".join(name for name, kind in kinds.items() if kind in JOINTED)
                    expected = f"no joint with one degree of freedom has this name; known: {joint_names}"
                    raise InputError(f"{model.path}: joint '{mimic.joint}'", "mimic.joint", mimic.leader, expected)
                mimics[mimic.joint] = mimic
    check_chains(model.path, list(mimics.values()))
    return list(mimics.values())


def check_chains(path: Path, mimics: Sequence[Mimic]) -> None:
    """Raises an InputError if a joint follows itself through others."""
    leaders = {mimic.joint: mimic.leader for mimic in mimics}
    for name in leaders:
        leader = leaders[name]
        for _ in leaders:
            leader = leaders[leader] if leader in leaders and leader != name else leader
        if leader in leaders:
            raise InputError(f"{path}: joint '{name}'", "mimic.joint", leaders[name], "follows it in turn")


def _mimic(model: ModelFile, name: str, element: ET.Element) -> Mimic:
    place = f"{model.path}: joint '{name}'"
    multiplier, offset, reference = (
        finite_numbers(place, f"mimic.{key}", str(number(place, element, key, default)), 1)[0]
        for key, default in (("multiplier", "1"), ("offset", "0"), ("reference", "0"))
    )
    return Mimic(name, element.get("joint", ""), multiplier, offset - multiplier * reference)


def _drop_friction(model: ModelFile) -> None:
    for joint in model.root.findall("joint"):
        for dynamics in [*joint.findall("dynamics"), *joint.findall("axis/dynamics")]:
            place = f"joint '{joint.get('name')}'"
            friction = number(f"{model.path}: {place}", dynamics, "friction")
            dynamics.attrib.pop("friction", None)
            for element in dynamics.findall("friction"):
                dynamics.remove(element)
            if friction:
                model.note(LEFT_OUT, f"{place}: dynamics.friction", friction, "Drake's joints have damping only")


def _check_ranges(model: ModelFile) -> None:
    """Gives limits of URDF the end that they leave out, which is 0 if the other one is given.

    Raises:
        InputError: if a lower limit is above the upper one.
    """
    for joint in model.root.findall("joint"):
        place = f"{model.path}: joint '{joint.get('name')}'"
        for limit in [*joint.findall("limit"), *joint.findall("axis/limit")]:
            ends = {end for end in ("lower", "upper") if limit.get(end) is not None}
            if len(ends) == 1:
                limit.set(({"lower", "upper"} - ends).pop(), "0")
            lower, upper = (number(place, limit, end, text) for end, text in (("lower", "-inf"), ("upper", "inf")))
            for end, value in (("lower", lower), ("upper", upper)):
                if abs(value) > MOST and limit.get(end) is not None:
                    limit.set(end, repr(math.copysign(MOST, value)))  # as good as none
                for element in limit.findall(end) if abs(value) > MOST else ():
                    element.text = repr(math.copysign(MOST, value))  # 1e16 by default in SDFormat
            if lower > upper:
                raise InputError(place, "limit.upper", upper, f"must be at least limit.lower, {lower:g}")


def _free_from_world(model: ModelFile, free: bool, child: str | None) -> None:
    """Lets a scenario place a model that its file joins to the world.

    The world of the file becomes the first link of the model, `{model}_world`: where nothing else is said, the model
    stays where its file puts it. A free model loses the joint that fixes it.

    Raises:
        InputError: if a free model, or one that is welded at `child`, hangs on a joint to the world that moves.
    """
    fix_if_static(model.root)
    joints = [joint for joint in model.root.findall("joint") if joint_end(joint, "parent") == "world"]
    links = [link for link in model.root.findall("link") if link.get("name") == "world"]
    moving_joints = [joint for joint in joints if joint.get("type") not in ("fixed", "floating")]
    if moving_joints and (free or child is not None):
        field, value = ("free", True) if free else ("child", child)
        expected = f"leave it out: joint '{moving_joints[0].get('name')}' of the file joins the model to the world"
        model.refuse(field, value, expected)
    for joint in [joint for joint in joints if free or joint.get("type") == "floating"]:
        model.root.remove(joint)
        joints.remove(joint)
        if joint.get("type") == "fixed":
            model.note(LEFT_OUT, f"joint '{joint.get('name')}'", "world", "the scenario has the model free")
    anchor = f"{model.root.get('name')}_world"
    for joint in joints:
        _name_end(joint, "parent", anchor)
    for link in links:
        link.set("name", anchor)
    if free and links and not joints and len(model.root.findall("link")) > 1:
        model.root.remove(links[0])
    elif joints and not links:
        first_link = next((i for i, element in enumerate(model.root) if element.tag == "link"), 0)
        model.root.insert(first_link, massless(ET.Element("link", name=anchor), model.root.tag == "model"))
    children = {joint_end(joint, "child") for joint in model.root.findall("joint")}
    for root in (link for link in model.root.findall("link") if (free or links) and link.get("name") not in children):
        model.root.remove(root)  # the first link is the one whose place is that of the object
        model.root.insert(0, root)


def fix_if_static(model: ET.Element) -> None:
    """Replaces the mark of a static model by the joints that it stands for."""
    marks = model.findall("static")
    for mark in marks:
        model.remove(mark)
    if any((mark.text or "").strip() in ("true", "1") for mark in marks):
        children = {joint_end(joint, "child") for joint in model.findall("joint")}
        for name in [link.get("name", "") for link in model.findall("link")]:
            if name not in children:
                joint = ET.SubElement(model, "joint", name=f"{name}_to_world", type="fixed")
                ET.SubElement(joint, "parent").text, ET.SubElement(joint, "child").text = "world", name


def _name_end(joint: ET.Element, end: str, link: str) -> None:
    for element in joint.findall(end):
        if element.get("link") is None:
            element.text = link
        else:
            element.set("link", link)


def mend_links(model: ModelFile, options: ImportOptions) -> None:
    """Converts the shapes and inertias of links to those that Drake has; raises an InputError if it cannot."""
    _drop_empty_shapes(model)
    joints = [joint for joint in model.root.findall("joint") if joint.get("type") != "fixed"]
    links = [link.get("name", "") for link in model.root.findall("link")]
    repair_inertia(model, {joint_end(joint, "child") for joint in joints} | set(links[:1] if options.free else ()))


def _drop_empty_shapes(model: ModelFile) -> None:
    """Removes shapes with sizes that are all zero."""
    for link in model.root.findall("link"):
        for shape in [*link.findall("visual"), *link.findall("collision")]:
            for solid in shape.findall("geometry/*"):
                texts = [*solid.attrib.values(), *(child.text or "" for child in solid)]
                if solid.tag in ("box", "sphere", "cylinder") and texts and not any(map(_may_have_size, texts)):
                    link.remove(shape)
                    model.note(LEFT_OUT, f"link '{link.get('name')}': {shape.tag}", " ".join(texts), "it has no size")
                    break


def _may_have_size(text: str) -> bool:
    return any(word.strip("+-0.") for word in text.split())


def convert_meshes(model: ModelFile, to_convex: bool) -> None:
    """Gives all shapes mesh files that Drake reads; `to_convex`, collisions take their convex hulls, with a note.

    Raises:
        InputError: if a mesh is missing or cannot be read.
    """
    for link in model.root.findall("link"):
        for shape in [*link.findall("visual"), *link.findall("collision")]:
            for mesh in shape.findall("geometry/mesh"):
                name = _mesh_name(mesh)
                to_hull = to_convex and shape.tag == "collision" and not _is_made_for_drake(shape, mesh)
                if to_hull:
                    ET.SubElement(mesh, DRAKE + "declare_convex")
                if not is_known_package(name):
                    file, origin = _find(model, shape, mesh)
                    if to_hull:
                        from soft_gripper.model_import.convex_parts import note_hull

                        note_hull(model, link.get("name", ""), file, origin)


def _is_made_for_drake(shape: ET.Element, mesh: ET.Element) -> bool:
    is_drakes = any(isinstance(child.tag, str) and child.tag.startswith(DRAKE) for child in mesh)
    return is_drakes or shape.find(DRAKE + "proximity_properties") is not None


def _mesh_name(mesh: ET.Element) -> str:
    return (mesh.get("filename") or mesh.findtext("uri") or "").strip()


def _find(model: ModelFile, shape: ET.Element, mesh: ET.Element) -> tuple[Path, Path]:
    """Gives a mesh a file that Drake reads; returns its path and that of the file that the model names."""
    from soft_gripper.model_import.mesh_files import convert_to_obj, outward

    file = origin = mesh_file(_mesh_name(mesh), model.path)
    is_foreign = file.suffix.lower() not in _DRAKE_READS
    has_surface = shape.tag == "collision" and mesh.find(DRAKE + "declare_convex") is None
    try:
        check_mesh_file(file)
        file = convert_to_obj(file) if is_foreign else file
        file = outward(model, file, origin) if has_surface and file.suffix == ".obj" else file
    except InputError as error:
        raise error.inside(model.path) from None
    if is_foreign and file.with_suffix(".mtl").exists():
        for material in shape.findall("material"):  # Drake prefers it to the colours of the file
            shape.remove(material)
    if mesh.get("filename") is not None:
        mesh.set("filename", f"file://{file}")
    for uri in mesh.findall("uri"):
        uri.text = f"file://{file}"
    return file, origin
