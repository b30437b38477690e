"""Links and joints of URDF and SDFormat, mended alike for Drake, whatever they describe.

What Drake does not use is removed before anything is checked. What had an effect there is not removed in silence.
"""

import math
import xml.etree.ElementTree as ET
from collections.abc import Collection, Mapping, Sequence
from pathlib import Path

import numpy as np

from soft_gripper.arrays import Array
from soft_gripper.errors import InputError
from soft_gripper.files.notes import LEFT_OUT, MENDED
from soft_gripper.files.xml_text import DRAKE, MOST, finite_numbers, joint_end, number, take
from soft_gripper.model_import.drake_parsing import WITHOUT_AXIS
from soft_gripper.model_import.imported_model import ImportOptions, Mimic
from soft_gripper.model_import.mesh_checks import check_mesh_file
from soft_gripper.model_import.model_file import ModelFile
from soft_gripper.model_import.named_files import is_known_package, mesh_file

JOINTED = ("revolute", "continuous", "prismatic")
_IGNORED_TAGS = ("calibration", "property", "arg")  # without any effect; the last two of xacro
_AXIS_TAGS = ("axis", "axis2", "limit", "dynamics", "mimic")
_DRAKE_READS = (".obj", ".gltf", ".vtk")  # meshes
_FILTER_GROUP = DRAKE + "collision_filter_group"
SPECK = (1e-3, 4e-8 * np.eye(3))  # kg, kg m^2: a ball of 1 g and 1 cm radius
NEXT_TO_NONE = (1e-9, 1e-15 * np.eye(3))  # kg, kg m^2
SPECK_WHY = "it moves on a joint of its own, and weighs 1 g now"
_MIN_MASS_SPREAD = 1e-3  # m, spread of the mass along any axis
_ROUNDING_TOLERANCE = 1e-3  # change relative to the trace, below which an inertia was only rounded in its file
DEFAULT_DENSITY = "1000"  # kg/m^3, of SDFormat and MJCF
INERTIA_ENTRIES = {"ixx": (0, 0), "iyy": (1, 1), "izz": (2, 2), "ixy": (0, 1), "ixz": (0, 2), "iyz": (1, 2)}


def drop_others(model: ModelFile, tags_by_parent: Mapping[str, Sequence[str]]) -> None:
    """Removes what is for other programs, and what a joint's type does not use.

    Elements stay that are of Drake or xacro, or in `tags_by_parent`, by path of the parent; "." is the model.
    """
    for path, tags in tags_by_parent.items():
        for parent in model.root.findall(path):
            for element in [element for element in parent if isinstance(element.tag, str)]:
                is_macro = "xacro" in element.tag and plain(element.tag) not in _IGNORED_TAGS
                if element.tag not in tags and not element.tag.startswith(DRAKE) and not is_macro:
                    drop(model, parent, element)
    for joint in model.root.findall("joint"):
        if joint.get("type") in WITHOUT_AXIS:
            take(joint, *_AXIS_TAGS)


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


def mend_joints(model: ModelFile, options: ImportOptions) -> list[Mimic]:
    """Converts joints to kinds of Drake, and takes couplings out of a model; raises an InputError if it cannot."""
    mimics = _take_mimics(model)
    for joint in model.root.findall("joint"):
        for dynamics in [*joint.findall("dynamics"), *joint.findall("axis/dynamics")]:
            place = f"joint '{joint.get('name')}'"
            friction = number(f"{model.path}: {place}", dynamics, "friction")
            dynamics.attrib.pop("friction", None)
            take(dynamics, "friction")
            if friction:
                model.note(LEFT_OUT, f"{place}: dynamics.friction", friction, "Drake's joints have damping only")
    _check_ranges(model)
    _free_from_world(model, options.free, options.child)
    return mimics


def _take_mimics(model: ModelFile) -> list[Mimic]:
    """Takes the couplings out of a model; raises an InputError if a joint follows none that can be followed."""
    mimics: dict[str, Mimic] = {}
    kinds = {joint.get("name", ""): joint.get("type", "") for joint in model.root.findall("joint")}
    for joint in model.root.findall("joint"):
        for parent in [joint, *joint.findall("axis")]:
            for element in take(parent, "mimic"):
                place = f"{model.path}: joint '{joint.get('name', '')}'"
                multiplier, offset, reference = (
                    finite_numbers(place, f"mimic.{key}", str(number(place, element, key, default)), 1)[0]
                    for key, default in (("multiplier", "1"), ("offset", "0"), ("reference", "0"))
                )
                offset -= multiplier * reference
                mimic = Mimic(joint.get("name", ""), element.get("joint", ""), multiplier, offset)
                if kinds.get(mimic.leader) not in JOINTED:
                    joint_names = ", ".join(name for name, kind in kinds.items() if kind in JOINTED)
                    expected = f"no joint with one degree of freedom has this name; known: {joint_names}"
                    raise InputError(place, "mimic.joint", mimic.leader, expected)
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


def _check_ranges(model: ModelFile) -> None:
    """Gives limits of URDF an end that they leave out, 0; raises an InputError for a lower end above the upper."""
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
    for element in [element for joint in joints for element in joint.findall("parent")]:
        if element.get("link") is None:
            element.text = anchor
        else:
            element.set("link", anchor)
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
    if any((mark.text or "").strip() in ("true", "1") for mark in take(model, "static")):
        children = {joint_end(joint, "child") for joint in model.findall("joint")}
        for name in [link.get("name", "") for link in model.findall("link")]:
            if name not in children:
                joint = ET.SubElement(model, "joint", name=f"{name}_to_world", type="fixed")
                ET.SubElement(joint, "parent").text, ET.SubElement(joint, "child").text = "world", name


def mend_links(model: ModelFile, options: ImportOptions) -> None:
    """Converts the shapes and inertias of links to those that Drake has; raises an InputError if it cannot."""
    for link in model.root.findall("link"):
        for shape in _shapes(link):
            for solid in shape.findall("geometry/*"):
                texts = [*solid.attrib.values(), *(child.text or "" for child in solid)]
                has_size = any(word.strip("+-0.") for text in texts for word in text.split())
                if solid.tag in ("box", "sphere", "cylinder") and texts and not has_size:
                    link.remove(shape)
                    model.note(LEFT_OUT, f"link '{link.get('name')}': {shape.tag}", " ".join(texts), "it has no size")
                    break
    joints = [joint for joint in model.root.findall("joint") if joint.get("type") != "fixed"]
    links = [link.get("name", "") for link in model.root.findall("link")]
    repair_inertia(model, {joint_end(joint, "child") for joint in joints} | set(links[:1] if options.free else ()))


def _shapes(link: ET.Element) -> list[ET.Element]:
    return [*link.findall("visual"), *link.findall("collision")]


def convert_meshes(model: ModelFile, to_convex: bool) -> None:
    """Gives all shapes mesh files that Drake reads; `to_convex`, collisions take their convex hulls, with a note.

    Raises:
        InputError: if a mesh is missing or cannot be read.
    """
    for link in model.root.findall("link"):
        for shape in _shapes(link):
            for mesh in shape.findall("geometry/mesh"):
                name = (mesh.get("filename") or mesh.findtext("uri") or "").strip()
                is_made_for_drake = shape.find(DRAKE + "proximity_properties") is not None or any(
                    isinstance(child.tag, str) and child.tag.startswith(DRAKE) for child in mesh
                )
                to_hull = to_convex and shape.tag == "collision" and not is_made_for_drake
                if to_hull:
                    ET.SubElement(mesh, DRAKE + "declare_convex")
                if not is_known_package(name):
                    origin = mesh_file(name, model.path)
                    file = _convert_mesh(model, shape, mesh, origin)
                    if to_hull:
                        from soft_gripper.model_import.mesh_files import note_hull

                        note_hull(model, link.get("name", ""), file, origin)


def _convert_mesh(model: ModelFile, shape: ET.Element, mesh: ET.Element, origin: Path) -> Path:
    """Gives a mesh a file that Drake reads, made from its `origin`; returns its path."""
    from soft_gripper.model_import.mesh_files import convert_to_obj, outward

    file = origin
    is_foreign = file.suffix.lower() not in _DRAKE_READS
    has_surface = shape.tag == "collision" and mesh.find(DRAKE + "declare_convex") is None
    try:
        check_mesh_file(file)
        file = convert_to_obj(file) if is_foreign else file
        file = outward(model, file, origin) if has_surface and file.suffix == ".obj" else file
    except InputError as error:
        raise error.inside(model.path) from None
    if is_foreign and file.with_suffix(".mtl").exists():
        take(shape, "material")  # Drake prefers it to the colours of the file
    if mesh.get("filename") is not None:
        mesh.set("filename", f"file://{file}")
    for uri in mesh.findall("uri"):
        uri.text = f"file://{file}"
    return file


def remove_links(model: ModelFile, names: Sequence[str]) -> None:
    """Removes links, with all links beyond them, the joints before them, and references to these.

    The model is a <robot>, or a <model> without others in it; names are those of links, or of frames on them. Raises an
    InputError if there is no such link, or it is the root.
    """
    if not names:
        return
    frame_elements = model.root.findall("frame")
    frames = {frame.get("name", ""): frame.get("attached_to", frame.get("link", "")) for frame in frame_elements}
    links = [link.get("name", "") for link in model.root.findall("link")]

    def link_of(name: str) -> str:
        for _ in frames:  # no longer than the longest chain
            name = name if name in links else frames.get(name, name)
        return name

    children = {joint: link_of(joint_end(joint, "child")) for joint in model.root.findall("joint")}
    parents = {child: link_of(joint_end(joint, "parent")) for joint, child in children.items()}
    chosen_links = [link_of(name if model.root.tag == "robot" else name.replace("::", "_")) for name in names]
    for name, link in zip(names, chosen_links, strict=True):
        if link not in links:
            model.refuse("without", name, f"no such link; known: {', '.join(links)}")
        if parents.get(link) not in links:
            model.refuse("without", name, "hangs on nothing; only what a joint carries can be left out")
    cut_links = set(chosen_links)
    for _ in parents:  # no longer than the longest chain, should the joints form a ring
        cut_links |= {link for link in links if parents.get(link) in cut_links}
    cut_joints = {joint.get("name", "") for joint, child in children.items() if child in cut_links}
    cut_frames = {name for name in frames if link_of(name) in cut_links}
    for element in list(model.root):
        if _refers_to(element, cut_links, cut_joints, cut_frames):
            model.root.remove(element)
    for parent in [*model.root.findall("joint"), *model.root.findall("joint/axis"), *model.root.findall(_FILTER_GROUP)]:
        for element in [*parent.findall("mimic"), *parent.findall(DRAKE + "member")]:
            if element.get("joint") in cut_joints or element.get("link", (element.text or "").strip()) in cut_links:
                parent.remove(element)


def _refers_to(element: ET.Element, links: set[str], joints: set[str], frames: set[str]) -> bool:
    """Whether a child of a model is, or refers to, one of the links, joints or frames."""
    names_by_tag = {"joint": joints, "link": links, "frame": frames}
    if element.tag in names_by_tag:
        return element.get("name") in names_by_tag[element.tag]
    if element.tag == "finger":
        return joint_end(element, "parent") in links
    if str(element.tag).startswith(DRAKE) and element.tag != _FILTER_GROUP:
        words = {word.strip() for part in element.iter() for word in (*part.attrib.values(), part.text or "")}
        return bool(words & (links | joints | frames))
    named_joints = {joint.get("name") for joint in element.findall("joint")}
    return element.get("reference") in links | joints or element.get("link") in links or bool(named_joints & joints)


def possible_inertia(mass: float, inertia: Array) -> Array:
    """The nearest rotational inertia (3, 3), kg m^2, about the centre of mass, that a body of this mass can have.

    An inertia is possible if no principal moment is larger than the sum of the others, that is, if no second moment
    of the mass, tr(I)/2 1 - I, is negative. A possible one is kept, unless a principal moment is zero, which would
    make the mass matrix singular. A changed one is that of a body at least 1 mm thick.
    """
    moments, axes = np.linalg.eigh(np.trace(inertia) / 2 * np.eye(3) - inertia)
    if moments[0] >= 0 and moments[0] + moments[1] > 0:
        return inertia
    second_moments = (axes * np.maximum(moments, mass * _MIN_MASS_SPREAD**2)) @ axes.T
    return np.trace(second_moments) * np.eye(3) - second_moments


def repair_inertia(model: ModelFile, jointed: Collection[str]) -> None:
    """Makes the inertias of all links of a URDF or SDFormat model possible; raises an InputError for what is no number.

    Files leave out inertias that hardly matter, or give zeros. Links named in `jointed`, which have a degree of
    freedom of their own, then get a tiny mass, since the mass matrix would be singular, unless something that has a
    mass is fixed to them; the others are fixed to something that has a mass.
    """
    is_sdf = model.root.tag == "model"
    loaded_links = _links_with_load(model, is_sdf)
    for link in model.root.findall("link"):
        name = link.get("name")
        if is_sdf and (link.find("inertial") is None or link.find("inertial[@auto]") is not None):
            continue  # 1 kg and 1 kg m^2, or computed by Drake
        mass, inertia = _read_inertial(f"{model.path}: link '{name}'", link, is_sdf)
        if mass > 0:
            mended_inertia = possible_inertia(mass, inertia)
            if mended_inertia is not inertia:
                write_inertial(link, mass, mended_inertia, is_sdf)
                is_rounded = np.abs(mended_inertia - inertia).max() <= _ROUNDING_TOLERANCE * np.trace(mended_inertia)
                if not (is_rounded and np.linalg.eigvalsh(inertia)[0] > 0):
                    note_impossible(model, f"link '{name}': inertia ixx, iyy, izz", inertia)
        elif name in jointed and name not in loaded_links:
            write_inertial(link, *SPECK, is_sdf)
            model.note(MENDED, f"link '{name}': mass", "0", SPECK_WHY)
        else:
            massless(link, is_sdf)


def note_impossible(model: ModelFile, element: str, inertia: Array) -> None:
    """Notes an inertia (3, 3), kg m^2, that was replaced by a possible one."""
    moments = ", ".join(f"{moment:.3g}" for moment in np.diag(inertia))
    model.note(MENDED, element, moments, "no body has it; the nearest that a body can have takes its place")


def scale_inertias(path: Path, model: ET.Element, factor: float) -> None:
    """Multiplies the masses and moments of all links of a URDF or SDFormat model; raises as `repair_inertia`."""
    is_sdf = model.tag == "model"
    for link in model.findall("link"):
        auto = link.find("inertial[@auto='true']")
        if auto is not None:  # computed by Drake, from the densities of the shapes or that of the link
            density = _child(auto, "density")
            density.text = density.text or DEFAULT_DENSITY
            for element in (density, *link.findall("collision/density")):
                element.text = repr(factor * float(element.text or DEFAULT_DENSITY))
        elif is_sdf or link.find("inertial") is not None:
            mass, inertia = _read_inertial(f"{path}: link '{link.get('name')}'", link, is_sdf)
            write_inertial(link, factor * mass, factor * inertia, is_sdf)


def _links_with_load(model: ModelFile, is_sdf: bool) -> set[str]:
    """The links that carry a fixed link with a mass, directly or through others."""
    fixed_joints = [joint for joint in model.root.findall("joint") if joint.get("type") == "fixed"]
    parents = {joint_end(joint, "child"): joint_end(joint, "parent") for joint in fixed_joints}
    loaded_links = set[str]()
    for link in model.root.findall("link"):
        name = link.get("name", "")
        mass, _ = _read_inertial(f"{model.path}: link '{name}'", link, is_sdf)
        while mass > 0 and (name := parents.get(name, "")) and name not in loaded_links:
            loaded_links.add(name)
    return loaded_links


def massless(link: ET.Element, is_sdf: bool) -> ET.Element:
    """Removes the mass of a link, or nearly all of it in SDFormat, where one without mass weighs 1 kg; returns it."""
    take(link, "inertial")
    if is_sdf:
        write_inertial(link, *NEXT_TO_NONE, is_sdf)
    return link


def _read_inertial(where: str, link: ET.Element, is_sdf: bool) -> tuple[float, Array]:
    inertial, inertia = link.find("inertial"), np.zeros((3, 3))
    entries = None if inertial is None else inertial.find("inertia")
    for key, (i, j) in INERTIA_ENTRIES.items():
        inertia[i, j] = inertia[j, i] = number(where, entries, key, "1" if is_sdf and i == j else "0")
    mass = number(where, inertial, "mass", "1" if is_sdf else "0")
    check_mass(where, mass)
    return mass, inertia


def check_mass(where: str, mass: float) -> None:
    """Raises an InputError for a mass below 0, kg."""
    if mass < 0:
        raise InputError(where, "mass", mass, "give a mass of at least 0, kg")


def write_inertial(link: ET.Element, mass: float, inertia: Array, is_sdf: bool) -> ET.Element:
    """Gives a link a mass, kg, and an inertia (3, 3), kg m^2; returns its <inertial>."""
    inertial = _child(link, "inertial")
    entries = {key: repr(float(inertia[index])) for key, index in INERTIA_ENTRIES.items()}
    if is_sdf:
        _child(inertial, "mass").text = repr(mass)
        for key, text in entries.items():
            _child(_child(inertial, "inertia"), key).text = text
    else:
        _child(inertial, "mass").set("value", repr(mass))
        _child(inertial, "inertia").attrib.update(entries)
    return inertial


def _child(element: ET.Element, tag: str) -> ET.Element:
    child = element.find(tag)
    return ET.SubElement(element, tag) if child is None else child
