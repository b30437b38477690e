"""URDF files with <finger> components, expanded to plain URDF that any Drake loads.

Drake silently skips unknown elements, and so the fingers of a file that is not expanded. Therefore a file with
<finger>s also has an element that makes Drake refuse it, with a message on what to do:

    <frame name="fingers: load with soft_gripper.add_fingers, or soft-gripper expand"/>

Drake requires every <frame> to name a link. Expanding removes the element.
"""

import os
import xml.etree.ElementTree as ET
from collections.abc import Callable, Sequence
from copy import deepcopy
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path

from soft_gripper.errors import InputError
from soft_gripper.files.text import read_text
from soft_gripper.files.xml_text import check_counts, parse_xml
from soft_gripper.fingers.finger import Finger
from soft_gripper.fingers.finger_element import FingerElement, finger_element, read_finger_element
from soft_gripper.fingers.finger_links import finger_to_urdf
from soft_gripper.model_import.links_and_joints import remove_links
from soft_gripper.model_import.model_file import ModelFile

GUARD = "fingers: load with soft_gripper.add_fingers, or soft-gripper expand"
_Source = tuple[Path, str, int | None, str | None, tuple[str, ...], str | None]  # path, text and options of a file
_MAX_CACHED_TEXTS = 16  # files, or expansions of about 0.1 MB: a sweep reads the same ones for every run


@dataclass(frozen=True)
class ExpandedUrdf:
    """A plain URDF, cached and not to be changed, and its fingers in the file's order."""

    robot: ET.Element
    fingers: tuple[Finger, ...]

    @property
    def text(self) -> str:
        return _text(self.robot)


def expand_urdf(
    file: Path | str,
    segments: int | None = None,
    only_name: str | None = None,
    without: Sequence[str] = (),
    model_name: str | None = None,
    change: Callable[[FingerElement], FingerElement] = lambda mounted: mounted,
    springs: str = "linear",
    visuals: bool = True,
    points: int | None = None,
    touches_itself: bool = False,
) -> ExpandedUrdf:
    """Replaces every <finger> of a URDF by links, joints and springs.

    Args:
        file: relative mesh names in it become absolute, so that the result can be stored elsewhere.
        segments: replaces every finger's own number of segments.
        only_name: name of the finger if the file holds just one, so that a file can be loaded twice.
        without: removed links, see `remove_links`.
        model_name: name of the robot in the result; None: as in the file.
        change: returns the replacement of each finger of the file.
        springs: "linear", "torsion" or "implicit", see `finger_to_urdf`.
        visuals: False omits the fingers' visual geometry.
        points: spheres on either side of a link, which touch other bodies instead of its surface; None: the surface.
        touches_itself: whether links of a finger that are more than two apart touch each other.

    Raises:
        InputError: if the file cannot be read or is not a URDF, or a <finger> in it is wrong.
    """
    path = Path(file)
    source = path, read_text(path), segments, only_name, tuple(without), model_name
    robot, parsed = _parse_fingers(source)
    elements = tuple(map(change, parsed))
    meshes = _meshes(path, robot)  # links may have changed
    options = springs, visuals, points, touches_itself
    return ExpandedUrdf(_expand(source, elements, meshes, options), tuple(element.finger for element in elements))


def read_fingers(
    file: Path | str, segments: int | None = None, only_name: str | None = None, without: Sequence[str] = ()
) -> tuple[FingerElement, ...]:
    """Reads the fingers of a URDF and their mounts; args and raises as `expand_urdf`."""
    path = Path(file)
    return _parse_fingers((path, read_text(path), segments, only_name, tuple(without), None))[1]


def changed_urdf(
    file: Path | str,
    segments: int | None = None,
    only_name: str | None = None,
    without: Sequence[str] = (),
    change: Callable[[FingerElement], FingerElement] = lambda mounted: mounted,
) -> str:
    """Replaces the <finger>s of a URDF and returns its text; they are not expanded.

    Args and raises as `expand_urdf`.
    """
    path = Path(file)
    parsed, elements = _parse_fingers((path, read_text(path), segments, only_name, tuple(without), None))
    robot = deepcopy(parsed)
    for mesh, filename in zip(robot.iter("mesh"), _meshes(path, robot), strict=True):
        mesh.set("filename", filename)
    new_elements = map(finger_element, map(change, elements))
    guard = [ET.Element("frame", name=GUARD)] if elements else []
    robot[:] = [*guard, *(next(new_elements) if child.tag == "finger" else child for child in robot)]
    ET.indent(robot)
    return _text(robot)


def _text(robot: ET.Element) -> str:
    return '<?xml version="1.0"?>\n' + ET.tostring(robot, encoding="unicode") + "\n"


@lru_cache(maxsize=_MAX_CACHED_TEXTS)
def _parse_fingers(source: _Source) -> tuple[ET.Element, tuple[FingerElement, ...]]:
    """A <robot> with its <finger>s, and their contents; both are cached, so they must not be changed."""
    path, text, segments, only_name, without, model_name = source
    robot = parse_xml(path, text)
    if robot.tag != "robot" or not robot.get("name"):
        raise InputError(path, "root element", robot.tag, "a URDF begins with <robot name='...'>")
    check_counts(path, robot)
    remove_links(ModelFile(path, robot), without)
    # Expanding removes the element that makes Drake refuse the file; one with fingers must have it.
    guards = [frame for frame in robot.findall("frame") if frame.get("name") == GUARD]
    for guard in guards:
        robot.remove(guard)
    if robot.find("finger") is not None and not guards:
        expected = f'add <frame name="{GUARD}"/> beside the <finger>s: Drake by itself then refuses the file, whose'
        raise InputError(path, "frame", None, f"{expected} fingers it would skip without a word")
    if model_name is not None:
        robot.set("name", model_name)
    if only_name is not None and len(robot.findall("finger")) == 1:
        robot.findall("finger")[0].set("name", only_name)
    return robot, tuple(read_finger_element(str(path), e, segments) for e in robot.findall("finger"))


@lru_cache(maxsize=_MAX_CACHED_TEXTS)
def _expand(
    source: _Source,
    elements: tuple[FingerElement, ...],
    meshes: tuple[str, ...],
    options: tuple[str, bool, int | None, bool],
) -> ET.Element:
    """The <robot> with the last arguments of `finger_to_urdf` as options."""
    robot = deepcopy(_parse_fingers(source)[0])
    path, links = source[0], [link.get("name") for link in robot.findall("link")]
    names = [element.finger.name for element in elements]
    for element in elements:
        place = f"{path}: finger '{element.finger.name}'"
        if element.parent not in links:
            raise InputError(place, "parent.link", element.parent, f"no such link; known: {', '.join(map(str, links))}")
        if names.count(element.finger.name) > 1:
            raise InputError(path, "finger.name", element.finger.name, "appears more than once")
    for mesh, filename in zip(robot.iter("mesh"), meshes, strict=True):
        if filename:
            mesh.set("filename", filename)
    children = list(robot)
    robot[:] = []
    expanded = iter(elements)
    for child in children:
        robot.extend(finger_to_urdf(next(expanded), *options) if child.tag == "finger" else [child])
    ET.indent(robot)
    return robot


def _meshes(path: Path, robot: ET.Element) -> tuple[str, ...]:
    names = [mesh.get("filename", "") for mesh in robot.iter("mesh")]
    return tuple(n if "://" in n or not n else f"file://{os.path.realpath(path.parent / n)}" for n in names)
