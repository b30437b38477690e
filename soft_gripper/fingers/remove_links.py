"""Links of a URDF that are left out, such as a gripper that another one takes the place of."""

import xml.etree.ElementTree as ET
from collections.abc import Sequence
from pathlib import Path

from soft_gripper.errors import InputError
from soft_gripper.fingers.finger_links import DRAKE


def remove_links(path: Path, robot: ET.Element, names: Sequence[str]) -> None:
    """Takes links out of a <robot>, with all that hangs on them, the joints before them, and what is said of those.

    Raises:
        InputError: if there is no such link, or it is what all others hang on.
    """
    if not names:
        return
    parents = {_end(joint, "child"): _end(joint, "parent") for joint in robot.findall("joint")}
    links = [link.get("name", "") for link in robot.findall("link")]
    for name in names:
        if name not in links:
            raise InputError(path, "without", name, f"no such link; known: {', '.join(links)}")
        if name not in parents:
            raise InputError(path, "without", name, "hangs on nothing; only what a joint carries can be left out")
    cut = {link for link in links if _hangs_on(link, names, parents)}
    joints = {joint.get("name") for joint in robot.findall("joint") if _end(joint, "child") in cut}
    for element in list(robot):
        if _is_of(element, cut, joints):
            robot.remove(element)
    for group in robot.findall(DRAKE + "collision_filter_group"):
        for member in [member for member in group.findall(DRAKE + "member") if member.get("link") in cut]:
            group.remove(member)


def _end(joint: ET.Element, which: str) -> str:
    """The link at an end of a joint."""
    end = joint.find(which)
    return "" if end is None else end.get("link", "")


def _hangs_on(link: str, names: Sequence[str], parents: dict[str, str]) -> bool:
    for _ in parents:  # no longer than the longest chain, should the joints form a ring
        link = link if link in names else parents.get(link, link)
    return link in names


def _is_of(element: ET.Element, links: set[str], joints: set[str | None]) -> bool:
    """Whether a child of <robot> is, or speaks of, what is cut."""
    if element.tag == "joint":
        return element.get("name") in joints
    if element.tag == "link":
        return element.get("name") in links
    if element.tag == "finger":
        return _end(element, "parent") in links
    spoken_of = {joint.get("name") for joint in element.findall("joint")}
    return element.get("reference") in links | joints or element.get("link") in links or bool(spoken_of & joints)
