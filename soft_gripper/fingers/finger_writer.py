"""Writes a mounted finger as the <finger> of a URDF, which `finger_element` reads.

Numbers are written in full, so that the same finger is read again. Default values are omitted.
"""

import xml.etree.ElementTree as ET
from dataclasses import MISSING, fields
from typing import Any

from soft_gripper.fingers.finger import Finger
from soft_gripper.fingers.finger_element import FingerElement

_BODY_FIELDS = ("segments", "relaxation_time", "shear_factor")


def finger_element(mounted: FingerElement) -> ET.Element:
    """The <finger> element of a finger."""
    finger = mounted.finger
    element = ET.Element("finger", name=finger.name)
    ET.SubElement(element, "parent", link=mounted.parent)
    ET.SubElement(element, "origin", xyz=_text(mounted.xyz), rpy=_text(mounted.rpy))
    ET.SubElement(element, "body", _body(finger))
    ET.SubElement(element, "base", _attributes(finger.base))
    for section in finger.sections:
        ET.SubElement(element, "section", _attributes(section))
    ET.SubElement(element, "tip", _attributes(finger.tip))
    ET.SubElement(element, "sensors", spacing=_text(finger.sensor_spacing))
    ET.SubElement(element, "contact", _attributes(finger.contact))
    if finger.elastic_law is not None:
        law, ds = finger.elastic_law, finger.segment_length
        angle = _text([ds * curvature for curvature in law.curvature])
        torques = {"base_torque": _text(law.base_moment), "tip_torque": _text(law.tip_moment)}
        ET.SubElement(element, "elastic_law", {"angle": angle, **torques})
    if finger.creep:
        shares, times = zip(*((branch.share, branch.time) for branch in finger.creep), strict=True)
        ET.SubElement(element, "creep", share=_text(shares), time=_text(times))
    if finger.pressure_law is not None:
        ET.SubElement(element, "pressure_law", _attributes(finger.pressure_law))
    if finger.tip_load is not None:
        load = finger.tip_load
        ET.SubElement(element, "tip_load", mass=_text(load.mass), xyz=_text((load.x, 0.0, load.z)))
    for chamber in finger.chambers:
        ET.SubElement(element, "chamber", _attributes(chamber))
    for tendon in finger.tendons:
        ET.SubElement(element, "tendon", _attributes(tendon))
    return element


def _body(finger: Finger) -> dict[str, str]:
    numbers = {name: _text(getattr(finger, name)) for name in _BODY_FIELDS}
    return {"length": _text(finger.length), **numbers, "yields": " ".join(finger.yields)}


def _attributes(part: Any) -> dict[str, str]:
    """Fields of a dataclass with other than default values, as text."""
    values = ((parameter, getattr(part, parameter.name)) for parameter in fields(part))
    return {
        parameter.name: _text(value)
        for parameter, value in values
        if parameter.default is MISSING or value != parameter.default
    }


def _text(value: Any) -> str:
    if isinstance(value, str):
        return value
    return " ".join(map(_text, value)) if isinstance(value, tuple | list) else repr(value)
