"""Prepares MJCF files for Drake: one text, meshes that Drake reads, possible masses, motors."""

import math
import os
import re
import xml.etree.ElementTree as ET
from collections.abc import Collection, Iterator, Mapping, Sequence
from pathlib import Path

import numpy as np

from soft_gripper.arrays import Array
from soft_gripper.errors import InputError
from soft_gripper.files.notes import MENDED, READ
from soft_gripper.files.xml_text import check_counts, finite_numbers, read_numbers, take
from soft_gripper.model_import.imported_model import Form, ImportedModel, ImportOptions, Mimic
from soft_gripper.model_import.links_and_joints import (
    DEFAULT_DENSITY,
    INERTIA_ENTRIES,
    NEXT_TO_NONE,
    SPECK,
    SPECK_WHY,
    check_chains,
    check_mass,
    note_impossible,
    possible_inertia,
)
from soft_gripper.model_import.mesh_checks import check_mesh_file
from soft_gripper.model_import.model_file import ModelFile
from soft_gripper.model_import.named_files import IncludedFiles

_ACTUATOR_TAGS = ("motor", "general", "position", "velocity", "intvelocity", "damper")
_JOINT_TAGS = ("joint", "freejoint")
_WITH_DEFAULTS = ("geom", "joint", "actuator")
_REFERRING_SECTIONS = ("tendon", "actuator", "equality", "contact", "sensor")  # to bodies, and to those before them
_NAMED_TAGS = ("body", "joint", "site", "geom", "tendon", "actuator")
# Attributes that name another element end in its kind, or in that and a number: "joint1", "refsite".
_REFERENCE_PATTERN = re.compile(rf"[a-z]*?({'|'.join(_NAMED_TAGS)})(?:name|inparent)?[12]?")
_NAMED_KINDS = {"objname": "objtype", "refname": "reftype"}  # attributes with names, and those with their kinds
_Defaults = Mapping[str, Mapping[str, Mapping[str, str]]]  # attributes by class and tag


def read(model: ModelFile, options: ImportOptions) -> ImportedModel:
    """A model that Drake reads; it touches its meshes at their convex hulls, and those of an arm are noted.

    Raises:
        InputError: if a file that it names is missing or cannot be read, or files include each other.
    """
    path, root = model.path, model.root
    _include(path.parent, root, IncludedFiles(path, root))
    remove_bodies(model, options.without)
    check_counts(path, root)
    if not (root.get("model") or "").strip():
        root.set("model", path.stem)
    defaults = _defaults(root)
    meshes = _find_meshes(model, defaults, options.is_arm)
    _mend_masses(model, defaults, meshes)
    mimics = _take_mimics(model, {name for name, _ in _joints(root, defaults)})
    _make_motors(model, defaults)
    return ImportedModel(ET.tostring(root, encoding="unicode"), ".xml", mimics, tuple(_separate_groups(root, defaults)))


def scale_masses(path: Path, root: ET.Element, factor: float) -> None:
    """Multiplies the masses and moments of all bodies of a model that was `read`; raises as `finite_numbers`."""
    defaults = _defaults(root)
    for body, childclass in _bodies(root):
        place = f"{path}: {_name(body)}"
        for inertial in body.findall("inertial"):
            for name in {"mass", "diaginertia", "fullinertia"} & set(inertial.keys()):
                numbers = finite_numbers(place, f"inertial.{name}", inertial.get(name, ""), 1, 3, 6, least=0)
                inertial.set(name, " ".join(repr(factor * number) for number in numbers))
        for geom in body.findall("geom"):
            values = _with_defaults(geom, "geom", defaults, childclass)
            name, value = _mass_or_density(place, values)
            geom.set(name, repr(factor * value))


FORM = Form("MJCF", ("mujoco",), read, scale_masses)


def _include(folder: Path, parent: ET.Element, files: IncludedFiles) -> None:
    """Puts the contents of included files, which are named from a folder, in the place of each <include>."""
    content: list[ET.Element] = []
    for element in parent:
        if element.tag == "include":
            name = element.get("file", "")
            with files.read("include.file", name, folder / name) as included:
                _include(folder, included, files)
            content += included
        else:
            _include(folder, element, files)
            content.append(element)
    parent[:] = content


def _find_meshes(model: ModelFile, defaults: _Defaults, is_arm: bool) -> dict[str, bool]:
    """Gives meshes files that Drake reads, and names; returns whether each has a file: Drake leaves out the others."""
    from soft_gripper.model_import.mesh_files import convert_to_obj, note_hull, outward

    options: dict[str, str] = {}
    for compiler in model.root.findall("compiler"):
        options |= compiler.attrib
        for name in ("meshdir", "assetdir", "strippath"):
            compiler.attrib.pop(name, None)
    weighs_all = options.get("inertiafromgeom") == "true"
    weighed_bodies = [body for body in model.root.iter("body") if weighs_all or body.find("inertial") is None]
    mass_meshes = {values["geom"].get("mesh") for values in defaults.values() if "geom" in values}
    mass_meshes |= {geom.get("mesh") for body in weighed_bodies for geom in body.findall("geom")}
    bodies: dict[str, list[str]] = {}  # names of the bodies with each mesh that others may touch
    worlds = ((world, "main") for world in model.root.findall("worldbody"))
    for body, childclass in [*worlds, *_bodies(model.root)]:
        for geom in body.findall("geom"):
            values = _with_defaults(geom, "geom", defaults, childclass)
            if "mesh" in values and (_bits(values, "contype") or _bits(values, "conaffinity")):
                bodies.setdefault(values["mesh"], []).append(body.get("name", ""))
    folder = Path(os.path.realpath(model.path.parent)) / options.get("meshdir", options.get("assetdir", ""))
    for mesh in model.root.findall("asset/mesh"):
        if file_name := (mesh.get("file") or "").strip():
            file = folder / (os.path.basename(file_name) if options.get("strippath") == "true" else file_name)
            mesh.set("name", name := _mesh_name(mesh))
            try:
                check_mesh_file(file)
                obj = file if file.suffix.lower() == ".obj" else convert_to_obj(file)
                if name in mass_meshes or name in bodies:
                    obj = outward(model, obj, file, from_volume=name in mass_meshes)
                for body_name in bodies.get(name, ()) if is_arm else ():
                    note_hull(model, body_name, obj, file)
            except InputError as error:
                raise error.inside(model.path) from None
            mesh.set("file", str(obj))
            mesh.attrib.pop("content_type", None)
    return {mesh.get("name", ""): bool(mesh.get("file")) for mesh in model.root.findall("asset/mesh")}


def _defaults(root: ET.Element) -> _Defaults:
    """Default attributes of each class for its elements."""
    attributes_by_class: dict[str, dict[str, dict[str, str]]] = {"main": {}}

    def add(default: ET.Element, outer_class: str, name: str) -> None:
        attributes = attributes_by_class.setdefault(name, dict(attributes_by_class[outer_class]))
        for element in default:
            tag = "actuator" if element.tag in _ACTUATOR_TAGS else str(element.tag)
            if tag in _WITH_DEFAULTS:
                attributes[tag] = {**attributes.get(tag, {}), **element.attrib}
        for inner in default.findall("default"):
            add(inner, name, inner.get("class", ""))

    for default in root.findall("default"):
        add(default, "main", "main")
    return attributes_by_class


def _with_defaults(element: ET.Element, tag: str, defaults: _Defaults, childclass: str) -> dict[str, str]:
    return {**defaults.get(element.get("class", childclass), {}).get(tag, {}), **element.attrib}


def _name(element: ET.Element) -> str:
    return f"{element.tag} '{element.get('name', element.get('joint', ''))}'"


def _mend_masses(model: ModelFile, defaults: _Defaults, meshes: Mapping[str, bool]) -> None:
    """Makes inertias possible, and gives moving bodies without a mass a tiny one.

    Geoms outside of the groups that have a mass, which Drake does not know, get none.
    """
    first, last = -math.inf, math.inf  # of these groups
    for compiler in model.root.findall("compiler"):
        if (text := compiler.attrib.pop("inertiagrouprange", None)) is not None:
            first, last = finite_numbers(model.path, "compiler.inertiagrouprange", text, 2)

    def has_mass(geom: ET.Element, childclass: str) -> bool:
        values, place = _with_defaults(geom, "geom", defaults, childclass), f"{model.path}: {_name(geom)}"
        if (mesh := values.get("mesh")) is not None and mesh not in meshes:
            raise InputError(place, "mesh", mesh, "no mesh of <asset> has this name")
        if not first <= finite_numbers(place, "group", values.get("group", "0"), 1)[0] <= last:
            geom.set("mass", "0")
            return False
        _, value = _mass_or_density(place, values)
        return value > 0 and (mesh is None or meshes[mesh])

    for body, childclass in _bodies(model.root):
        moves = any(body.find(tag) is not None for tag in _JOINT_TAGS)
        inertial = body.find("inertial")
        if inertial is not None:
            _mend(model, body, inertial, moves)
        elif sum(has_mass(geom, childclass) for geom in body.findall("geom")) == 0 and moves:
            _set_inertia(ET.SubElement(body, "inertial", pos="0 0 0"), *SPECK)
            model.note(MENDED, f"{_name(body)}: mass", "0", SPECK_WHY)


def _mass_or_density(where: str, values: Mapping[str, str]) -> tuple[str, float]:
    """The name and the value of the number that gives the mass of a geom, kg or kg/m^3."""
    name = "mass" if "mass" in values else "density"
    return name, finite_numbers(where, name, values.get(name, DEFAULT_DENSITY), 1)[0]


def _mend(model: ModelFile, body: ET.Element, inertial: ET.Element, moves: bool) -> None:
    where = f"{model.path}: {_name(body)}"
    (mass,) = finite_numbers(where, "inertial.mass", inertial.get("mass", "0"), 1)
    check_mass(where, mass)
    diagonal = finite_numbers(where, "inertial.diaginertia", inertial.get("diaginertia", "0 0 0"), 3)
    inertia = np.diag(diagonal)
    if (full := inertial.get("fullinertia")) is not None:
        numbers = finite_numbers(where, "inertial.fullinertia", full, 6)
        for (i, j), value in zip(INERTIA_ENTRIES.values(), numbers, strict=True):
            inertia[i, j] = inertia[j, i] = value
    if mass == 0:
        _set_inertia(inertial, *(SPECK if moves else NEXT_TO_NONE))
        if moves:
            model.note(MENDED, f"{_name(body)}: mass", "0", SPECK_WHY)
    elif (mended_inertia := possible_inertia(mass, inertia)) is not inertia:
        _set_inertia(inertial, mass, mended_inertia)
        note_impossible(model, f"{_name(body)}: inertia", inertia)


def _set_inertia(inertial: ET.Element, mass: float, inertia: Array) -> None:
    inertial.attrib.pop("diaginertia", None)
    inertial.set("mass", repr(mass))
    inertial.set("fullinertia", " ".join(repr(float(inertia[index])) for index in INERTIA_ENTRIES.values()))


def _take_mimics(model: ModelFile, joints: Collection[str]) -> tuple[Mimic, ...]:
    """Takes out of a model which joints follow others, as far as they follow in proportion."""
    mimics: list[Mimic] = []
    for equality in model.root.findall("equality"):
        for element in [joint for joint in equality.findall("joint") if joint.get("active") != "false"]:
            joint, leader = element.get("joint1", ""), element.get("joint2", "")
            text, place = element.get("polycoef", "0 1 0 0 0"), f"{model.path}: {_name(element)}"
            law = finite_numbers(place, "polycoef", text, 1, 2, 3, 4, 5)
            offset, factor, *higher_terms = (*law, *(0.0, 1.0)[len(law) :])
            followers = {mimic.joint for mimic in mimics}
            if {joint, leader} <= set(joints) and not any(higher_terms) and joint not in followers and joint != leader:
                equality.remove(element)
                mimics.append(Mimic(joint, leader, factor, offset))
    check_chains(model.path, mimics)
    return tuple(mimics)


def _make_motors(model: ModelFile, defaults: _Defaults) -> None:
    """Makes each actuator of a joint a motor with the largest effort at the joint: Drake knows neither gears nor gains.

    A default class may say what a motor no longer has, so that those of actuators go.
    """
    joints = dict(_joints(model.root, defaults))
    for actuators in model.root.findall("actuator"):
        for place, actuator in enumerate(list(actuators)):
            if actuator.tag in _ACTUATOR_TAGS and (joint := actuator.get("joint")) in joints:
                effort = _effort(model, actuator, _with_defaults(actuator, "actuator", defaults, "main"), joints[joint])
                motor = ET.Element("motor", {"name": actuator.get("name", f"{joint}_actuator"), "joint": joint})
                if effort < math.inf:
                    motor.attrib |= {"ctrllimited": "true", "ctrlrange": f"{-effort!r} {effort!r}"}
                if actuator.tag != "motor":
                    name, why = f"actuator '{motor.get('name')}'", "as a motor with its largest effort"
                    model.note(READ, name, actuator.tag, why)
                actuators[place] = motor
    for default in model.root.iter("default"):
        take(default, *_ACTUATOR_TAGS)


def _separate_groups(root: ET.Element, defaults: _Defaults) -> Iterator[tuple[list[str], list[str]]]:
    """Bodies that never touch others by the masks of their geoms, which Drake does not know, and these others."""
    groups: dict[tuple[int, int], list[str]] = {}
    for body, childclass in _bodies(root):
        contype = conaffinity = 0
        for geom in body.findall("geom"):
            values = _with_defaults(geom, "geom", defaults, childclass)
            contype, conaffinity = contype | _bits(values, "contype"), conaffinity | _bits(values, "conaffinity")
        if body.get("name") and (contype or conaffinity):
            groups.setdefault((contype, conaffinity), []).append(body.get("name", ""))
    for (a, b), names in groups.items():
        if others := [name for (c, d), bodies in groups.items() if not (a & d or c & b) for name in bodies]:
            yield names, others


def _bits(values: Mapping[str, str], name: str) -> int:
    text = values.get(name, "1")
    return int(text) if text.isascii() and text.isdecimal() and len(text) < 20 else 1


def _bodies(root: ET.Element) -> Iterator[tuple[ET.Element, str]]:
    """Pairs of a body and the default class of its elements."""

    def nested_bodies(parent: ET.Element, childclass: str) -> Iterator[tuple[ET.Element, str]]:
        for body in parent.findall("body"):
            body_class = body.get("childclass", childclass)
            yield body, body_class
            yield from nested_bodies(body, body_class)

    for world in root.findall("worldbody"):
        yield from nested_bodies(world, "main")


def _joints(root: ET.Element, defaults: _Defaults) -> Iterator[tuple[str, dict[str, str]]]:
    """The names and attributes of the joints with one degree of freedom."""
    for body, childclass in _bodies(root):
        for joint in body.findall("joint"):
            values = _with_defaults(joint, "joint", defaults, childclass)
            if values.get("type", "hinge") in ("hinge", "slide"):
                yield values.get("name", ""), values


def _effort(model: ModelFile, actuator: ET.Element, values: Mapping[str, str], joint: Mapping[str, str]) -> float:
    """The largest effort of an actuator at its joint, N m or N."""
    place = f"{model.path}: {_name(actuator)}"

    def number(name: str, default: str) -> float:
        return read_numbers(place, name, values.get(name, default))[0]

    gear = abs(number("gear", "1"))
    is_motor = actuator.tag == "motor" or (actuator.tag == "general" and values.get("biastype", "none") == "none")
    gain = abs(number("gainprm", "1")) if actuator.tag == "general" else 1.0
    efforts = [gear * _most(place, values, "force")]
    efforts += [gear * gain * _most(place, values, "ctrl")] if is_motor else []
    efforts += [_most(place, joint, "actuatorfrc")]
    return min(efforts)


def _most(where: str, values: Mapping[str, str], kind: str) -> float:
    """The larger end of a range, if it limits anything."""
    text = values.get(f"{kind}range")
    if text is None or values.get(f"{kind}limited", "auto") == "false":
        return math.inf
    return max(map(abs, finite_numbers(where, f"{kind}range", text, 2)))


def remove_bodies(model: ModelFile, names: Sequence[str]) -> None:
    """Removes bodies from an MJCF model, with all bodies in them and all references to these.

    Keyframes, whose positions are those of all joints, go too, and meshes that nothing else has.

    Raises:
        InputError: if there is no such body, or it is in no other.
    """
    if not names:
        return
    worlds = model.root.findall("worldbody")
    body_names = [body.get("name", "") for world in worlds for body in world.iter("body")]
    kinds: set[tuple[str, str | None]] = set()
    meshes: set[str | None] = set()
    for name in names:
        if name not in body_names:
            model.refuse("without", name, f"no such body; known: {', '.join(filter(None, body_names))}")
        if any(body.get("name") == name for world in worlds for body in world.findall("body")):
            model.refuse("without", name, "is in no other body; only a body in another can be left out")
    parents = {child: parent for parent in model.root.iter() for child in parent}
    for body in [body for world in worlds for body in world.iter("body")]:
        if body.get("name") in names:
            kinds |= {(_kind_of(element), element.get("name")) for element in body.iter() if element.get("name")}
            meshes |= {geom.get("mesh") for geom in body.iter("geom")}
            parents[body].remove(body)
    for section in [section for tag in _REFERRING_SECTIONS for section in model.root.findall(tag)]:
        for element in list(section):
            references: set[tuple[str, str | None]] = set()  # kinds and names
            for part in element.iter():
                attributes = ((_REFERENCE_PATTERN.fullmatch(key), value) for key, value in part.attrib.items())
                references |= {(match[1], value) for match, value in attributes if match}
                named = _NAMED_KINDS.items()
                references |= {(part.get(kind, "").removeprefix("x"), part.get(name)) for name, kind in named}
            if references & kinds:
                section.remove(element)
                kinds.add((_kind_of(section), element.get("name")))
    take(model.root, "keyframe")
    meshes -= {geom.get("mesh") for geom in model.root.iter("geom")}
    for assets in model.root.findall("asset"):
        for mesh in [mesh for mesh in assets.findall("mesh") if _mesh_name(mesh) in meshes]:
            assets.remove(mesh)


def _mesh_name(mesh: ET.Element) -> str:
    """The name of a mesh, by default the stem of its file."""
    return mesh.get("name") or Path((mesh.get("file") or "").strip()).stem


def _kind_of(element: ET.Element) -> str:
    return "joint" if element.tag == "freejoint" else element.tag


def _references(element: ET.Element) -> set[tuple[str, str | None]]:
    """Kinds and names of the elements to which one refers."""
    pairs = {(match[1], value) for key, value in element.attrib.items() if (match := _REFERENCE_PATTERN.fullmatch(key))}
    return pairs | {(element.get(kind, "").removeprefix("x"), element.get(name)) for name, kind in _NAMED_KINDS.items()}
