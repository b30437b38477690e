"""URDF files with <finger> components, expanded to plain URDF that any Drake loads."""

import xml.etree.ElementTree as ET
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from soft_gripper.cut_links import cut_links
from soft_gripper.errors import InputError
from soft_gripper.finger import Finger
from soft_gripper.finger_element import FingerElement, read_finger_element
from soft_gripper.finger_links import finger_to_urdf


@dataclass(frozen=True)
class ExpandedUrdf:
    """Plain URDF text, and the fingers that it came from in the order of the file."""

    text: str
    fingers: tuple[Finger, ...]


def expand_urdf(
    path: Path, segments: int | None = None, only_name: str | None = None, without: Sequence[str] = ()
) -> ExpandedUrdf:
    """Replaces every <finger> of a URDF by links, joints and springs.

    Args:
        path: the file; relative mesh names in it become absolute, so that the result may be kept elsewhere.
        segments: takes the place of every finger's own number of segments.
        only_name: name of the finger if the file holds just one, so that a file can be loaded twice.
        without: links that are left out, see `cut_links`.

    Raises:
        InputError: if the file cannot be read or is not a URDF, or a <finger> in it is wrong.
    """
    robot = _read_robot(path)
    cut_links(path, robot, without)
    if only_name is not None and len(robot.findall("finger")) == 1:
        robot.findall("finger")[0].set("name", only_name)
    elements = [read_finger_element(str(path), e, segments) for e in robot.findall("finger")]
    _check_links(path, robot, elements)
    children = list(robot)
    robot[:] = []
    expanded = iter(elements)
    for child in children:
        robot.extend(finger_to_urdf(next(expanded)) if child.tag == "finger" else [child])
    for mesh in robot.iter("mesh"):
        if filename := mesh.get("filename"):
            mesh.set("filename", _absolute(path, filename))
    ET.indent(robot)
    text = '<?xml version="1.0"?>\n' + ET.tostring(robot, encoding="unicode") + "\n"
    return ExpandedUrdf(text, tuple(e.finger for e in elements))


def _read_robot(path: Path) -> ET.Element:
    try:
        parser = ET.XMLParser(target=ET.TreeBuilder(insert_comments=True))
        robot = ET.fromstring(path.read_text(encoding="utf-8"), parser)
    except (OSError, UnicodeDecodeError) as error:
        reason = getattr(error, "strerror", None) or "it is not a text file"
        raise InputError(path, "file", path.name, f"cannot be read: {reason}") from None
    except ET.ParseError as error:
        raise InputError(path, "file", path.name, f"is not well-formed XML: {error}") from None
    if robot.tag != "robot" or not robot.get("name"):
        raise InputError(path, "root element", robot.tag, "a URDF begins with <robot name='...'>")
    return robot


def _check_links(path: Path, robot: ET.Element, elements: list[FingerElement]) -> None:
    links = [link.get("name") for link in robot.findall("link")]
    names = [element.finger.name for element in elements]
    for element in elements:
        where = f"{path}: finger '{element.finger.name}'"
        if element.parent not in links:
            raise InputError(where, "parent.link", element.parent, f"no such link; known: {', '.join(map(str, links))}")
        if names.count(element.finger.name) > 1:
            raise InputError(path, "finger.name", element.finger.name, "stands more than once")


def _absolute(path: Path, filename: str) -> str:
    is_uri = "://" in filename
    return filename if is_uri else f"file://{(path.parent / filename).resolve()}"
