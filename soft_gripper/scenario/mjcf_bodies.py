"""Bodies left out of MJCF files, such as those of a gripper that an arm has already."""

import re
import xml.etree.ElementTree as ET
from collections.abc import Sequence
from pathlib import Path

from soft_gripper.errors import InputError

_SECTIONS = ("tendon", "actuator", "equality", "contact", "sensor")  # they refer to bodies and to those before them
_KINDS = ("body", "joint", "site", "geom", "tendon", "actuator")
# Attributes that name another element end in its kind, or in that and a number: "joint1", "refsite".
_REFERENCE = re.compile(rf"[a-z]*?({'|'.join(_KINDS)})(?:name|inparent)?[12]?")
_NAMED_KINDS = {"objname": "objtype", "refname": "reftype"}  # attributes with names, and those with their kinds


def remove_bodies(path: Path, root: ET.Element, names: Sequence[str]) -> None:
    """Removes bodies from an MJCF model, with all bodies in them and what refers to these.

    Keyframes, whose positions are those of all joints, go too, and meshes that nothing else has.

    Raises:
        InputError: if there is no such body, or it is in no other.
    """
    if not names:
        return
    known = [body.get("name", "") for world in root.findall("worldbody") for body in world.iter("body")]
    removed: set[tuple[str, str | None]] = set()
    meshes: set[str | None] = set()
    for name in names:
        if name not in known:
            raise InputError(path, "without", name, f"no such body; known: {', '.join(filter(None, known))}")
        if any(body.get("name") == name for world in root.findall("worldbody") for body in world.findall("body")):
            raise InputError(path, "without", name, "is in no other body; only a body in another can be left out")
    parents = {child: parent for parent in root.iter() for child in parent}
    for body in [body for world in root.findall("worldbody") for body in world.iter("body")]:
        if body.get("name") in names:
            removed |= {(_kind(element), element.get("name")) for element in body.iter() if element.get("name")}
            meshes |= {geom.get("mesh") for geom in body.iter("geom")}
            parents[body].remove(body)
    for section in [section for tag in _SECTIONS for section in root.findall(tag)]:
        for element in list(section):
            if any(_references(part) & removed for part in element.iter()):
                section.remove(element)
                removed.add((_kind(section), element.get("name")))
    for keyframe in root.findall("keyframe"):
        root.remove(keyframe)
    meshes -= {geom.get("mesh") for geom in root.iter("geom")}
    for assets in root.findall("asset"):
        for mesh in [mesh for mesh in assets.findall("mesh") if mesh_name(mesh) in meshes]:
            assets.remove(mesh)


def mesh_name(mesh: ET.Element) -> str:
    """The name of a mesh: that of its file if it has none."""
    return mesh.get("name") or Path((mesh.get("file") or "").strip()).stem


def _kind(element: ET.Element) -> str:
    return "joint" if element.tag == "freejoint" else element.tag


def _references(element: ET.Element) -> set[tuple[str, str | None]]:
    """Kinds and names of the elements to which one refers."""
    pairs = {(match[1], value) for key, value in element.attrib.items() if (match := _REFERENCE.fullmatch(key))}
    return pairs | {(element.get(kind, "").removeprefix("x"), element.get(name)) for name, kind in _NAMED_KINDS.items()}
