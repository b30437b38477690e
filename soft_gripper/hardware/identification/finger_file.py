"""A finger file with the values that a fit has found, and everything else as it was."""

import re
import xml.etree.ElementTree as ET
from pathlib import Path
from tempfile import TemporaryDirectory

from soft_gripper.errors import InputError
from soft_gripper.files.output import atomic_file
from soft_gripper.files.text import read_text
from soft_gripper.files.xml_text import parse_xml
from soft_gripper.fingers.finger import Finger
from soft_gripper.fingers.urdf import expand_urdf

_PROLOG = re.compile(r"(?:\s|<\?.*?\?>|<!--.*?-->)*", re.DOTALL)  # what may stand before the root element
_OF_BODY = ("length", "relaxation_time", "shear_factor")
_OF_SECTION = ("youngs_modulus", "density", "chamber_width", "chamber_thickness")


def read_finger(path: Path) -> Finger:
    """The finger of a file.

    Raises:
        InputError: if the file cannot be read or does not hold exactly one finger.
    """
    fingers = expand_urdf(path).fingers
    if len(fingers) != 1:
        raise InputError(path, "finger", [finger.name for finger in fingers], "give a file with one finger")
    return fingers[0]


def with_finger(path: Path, finger: Finger) -> str:
    """The text of a finger file with the numbers of another finger; comments and everything else are kept.

    Raises:
        InputError: if the result is not a valid finger file.
    """
    text = read_text(path)
    robot = parse_xml(path, text)
    element = robot.find("finger")
    assert element is not None
    before = read_finger(path)
    for name in _OF_BODY:
        _set(element, "body", name, getattr(finger, name), getattr(before, name))
    for end in ("base", "tip"):
        section = element.find(end)
        assert section is not None
        part, part_before = getattr(finger, end), getattr(before, end)
        if (part.youngs_modulus, part.density) != (part_before.youngs_modulus, part_before.density):
            section.attrib.pop("material", None)
            part_before = None  # the material stood for both
        for name in _OF_SECTION:
            _set(element, end, name, getattr(part, name), part_before and getattr(part_before, name))
    if finger.creep != before.creep:
        for name in ("share", "time"):
            _child(element, "creep").set(name, _text(*(getattr(branch, name) for branch in finger.creep)))
    law = finger.pressure_law
    if law is not None and law != before.pressure_law:
        _child(element, "pressure_law").set("pressure", _text(*law.pressure))
        _child(element, "pressure_law").set("effective", _text(*law.effective))
    ET.indent(robot)
    before_root = _PROLOG.match(text)
    assert before_root is not None
    text = before_root[0] + ET.tostring(robot, encoding="unicode") + "\n"
    with TemporaryDirectory(prefix="soft-gripper-") as folder:
        written = Path(folder) / path.name
        written.write_text(text, encoding="utf-8")
        read_finger(written)  # so that what is written runs
    return text


def write_finger(path: Path, text: str) -> None:
    """Writes the text of a finger file, whole."""
    with atomic_file(path) as partial:
        partial.write_text(text, encoding="utf-8")


def _set(element: ET.Element, tag: str, name: str, value: float, before: float | None) -> None:
    if value != before and not (before is None and value == 0):
        _child(element, tag).set(name, _text(value))


def _child(element: ET.Element, tag: str) -> ET.Element:
    child = element.find(tag)
    return ET.SubElement(element, tag) if child is None else child


def _text(*values: float) -> str:
    return " ".join(f"{value:.6g}" for value in values)
