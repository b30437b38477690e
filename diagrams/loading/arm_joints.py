"""Joints of third-party URDF files: their limits checked, and an actuator for each of them."""

import math
import xml.etree.ElementTree as ET
from pathlib import Path

from soft_gripper.errors import InputError
from soft_gripper.xml_numbers import number

_MOVABLE = ("revolute", "continuous", "prismatic")
_LIMIT = "<limit lower='...' upper='...' velocity='...' effort='...'/> in rad, rad/s and N m, or m, m/s and N"


def movable_joints(robot: ET.Element) -> list[ET.Element]:
    """The joints of one degree of freedom, in the order of the file."""
    return [joint for joint in robot.findall("joint") if joint.get("type") in _MOVABLE]


def check_limits(path: Path, joint: ET.Element) -> None:
    """Looks at what an arm needs to know of a joint.

    Raises:
        InputError: if there is no range of positions, unless the joint is continuous, no velocity or no effort.
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
