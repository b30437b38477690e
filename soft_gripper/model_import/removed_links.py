"""Links of URDF and SDFormat that are left out, with all that hangs on them."""

import xml.etree.ElementTree as ET
from collections.abc import Sequence

from soft_gripper.files.xml_text import DRAKE, joint_end
from soft_gripper.model_import.model_file import ModelFile


def remove_links(model: ModelFile, names: Sequence[str]) -> None:
    """Removes links, with all links beyond them, the joints before them, and references to these.

    Args:
        model: a <robot>, or a <model> of SDFormat without models in it, which is changed.
        names: of the links, or of frames on them.

    Raises:
        InputError: if there is no such link, or it is the root.
    """
    if not names:
        return
    frames = {
        frame.get("name", ""): frame.get("attached_to", frame.get("link", "")) for frame in model.root.findall("frame")
    }
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
    cut_links = {link for link in links if _hangs_on(link, chosen_links, parents)}
    cut_joints = {joint.get("name", "") for joint, child in children.items() if child in cut_links}
    cut_frames = {name for name in frames if link_of(name) in cut_links}
    for element in list(model.root):
        if _refers_to(element, cut_links, cut_joints, cut_frames):
            model.root.remove(element)
    for parent in [*model.root.findall("joint"), *model.root.findall("joint/axis"), *model.root.findall(_FILTER_GROUP)]:
        for element in [*parent.findall("mimic"), *parent.findall(DRAKE + "member")]:
            if element.get("joint") in cut_joints or element.get("link", (element.text or "").strip()) in cut_links:
                parent.remove(element)


_FILTER_GROUP = DRAKE + "collision_filter_group"


def _hangs_on(link: str, names: Sequence[str], parents: dict[str, str]) -> bool:
    for _ in parents:  # no longer than the longest chain, should the joints form a ring
        link = link if link in names else parents.get(link, link)
    return link in names


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
