"""SDFormat, made ready for Drake: all links in one model, as a scenario has them.

Links, joints and frames of a nested model get its name as a prefix, `hand_palm` for `hand::palm`; a frame with the
name of the model takes the place of its own, in which its poses are given.
"""

import os
import xml.etree.ElementTree as ET
from collections.abc import Collection
from pathlib import Path

from soft_gripper.errors import InputError
from soft_gripper.files.notes import LEFT_OUT
from soft_gripper.files.xml_text import DRAKE, check_counts, take
from soft_gripper.model_import.imported_model import Form, ImportedModel, ImportOptions, Mimic
from soft_gripper.model_import.links_and_joints import (
    convert_meshes,
    drop,
    drop_others,
    fix_if_static,
    mend_joints,
    mend_links,
    remove_links,
    scale_inertias,
)
from soft_gripper.model_import.model_file import ModelFile
from soft_gripper.model_import.named_files import IncludedFiles, sdf_file

# What elements may have, by their path in the model; all else is for other programs.
_CHILD_TAGS = {
    "link": (
        *("pose", "inertial", "collision", "visual", "gravity", "enable_wind", "self_collide", "kinematic"),
        *("must_be_base_link", "velocity_decay"),
    ),
    "link/collision": ("pose", "geometry", "surface", "max_contacts", "laser_retro", "density", "auto_inertia_params"),
    "link/visual": (
        *("pose", "geometry", "material", "cast_shadows", "laser_retro", "transparency", "visibility_flags", "meta"),
    ),
    "joint": (
        *("parent", "child", "pose", "axis", "axis2", "physics"),
        *("gearbox_ratio", "gearbox_reference_body", "thread_pitch", "screw_thread_pitch"),
    ),
}
_KNOWN_ATTRIBUTES = {"link": ("name",), "collision": ("name",), "visual": ("name",), "joint": ("name", "type")}
_FOREIGN_TAGS = (
    *("plugin", "sensor", "light", "projector", "battery", "particle_emitter", "audio_source", "audio_sink", "script"),
)
_TARGET_VERSION = (1, 7)  # of SDFormat, the first in which poses name the frames in which they are given
_NAMED_TAGS = ("link", "frame", "model", "joint")
_REFERRING_ATTRIBUTES = ("relative_to", "attached_to", "expressed_in", "canonical_link", "placement_frame")
_REFERRING_TEXTS = ("parent", "child", "gearbox_reference_body", f"{DRAKE}member")
_OUTER_NAMES = ("world", "__root__")
_OVERRIDE_TAGS = ("pose", "static")  # of an <include>


def read(file: ModelFile, options: ImportOptions) -> ImportedModel:
    """Reads a model of SDFormat; raises an InputError if a file is missing, or it contradicts itself or the options."""
    _flatten(file)
    check_counts(file.path, file.root)
    mimics: list[Mimic] = []
    for model in map(file.part, _models(file.root)):
        remove_links(model, options.without)
        drop_others(model, _CHILD_TAGS)
        for parent in list(model.root.iter()):
            for element in [element for element in parent if element.tag in _FOREIGN_TAGS]:
                drop(model, parent, element)
            names = _KNOWN_ATTRIBUTES.get(parent.tag, tuple(parent.attrib))
            for name in [name for name in parent.attrib if name not in names and not name.startswith(DRAKE)]:
                value, element_name = parent.attrib.pop(name), f"{parent.tag} '{parent.get('name')}'"
                model.note(LEFT_OUT, f"{element_name}: {name}", value, "SDFormat has no such attribute")
        for link in model.root.findall("link"):
            for tag in ("collision", "visual"):  # SDFormat allows no name twice
                used_names: set[str | None] = set()
                for place, shape in enumerate(link.findall(tag)):
                    if shape.get("name") in used_names:
                        shape.set("name", f"{shape.get('name')}_{place}")
                    used_names.add(shape.get("name"))
        mimics += mend_joints(model, options)
        mend_links(model, options)
        convert_meshes(model, options.is_arm)
    return ImportedModel(ET.tostring(file.root, encoding="unicode"), ".sdf", mimics)


def _scale(path: Path, root: ET.Element, factor: float) -> None:
    for model in _models(root):
        scale_inertias(path, model, factor)


FORM = Form("SDFormat", ("sdf",), read, _scale)


def _models(root: ET.Element) -> list[ET.Element]:
    return [*root.findall("model"), *root.findall("world/model")]


def _flatten(file: ModelFile) -> None:
    """Puts included and nested models into the model around them; raises an InputError if that cannot be."""
    path, root = file.path, file.root
    if root.find(".//include") is None and root.find(".//model/model") is None:
        return
    files = IncludedFiles(path, root)
    for parent in [root, *root.findall("world")]:
        _include(path, parent, files)
    version = _version(path, root)
    for model in _models(root):
        _modernize(model, version)
        _merge_all(path, model)
    root.set("version", ".".join(map(str, max(version, _TARGET_VERSION))))


def _version(path: Path, root: ET.Element) -> tuple[int, ...]:
    text = root.get("version", "")
    try:
        return tuple(map(int, text.split(".")))
    except ValueError:
        raise InputError(path, "sdf.version", text, "give a version such as 1.7") from None


def _include(path: Path, parent: ET.Element, files: IncludedFiles) -> None:
    """Replaces each <include> in an element, and in the models in it, by the model that it names."""
    for model in parent.findall("model"):
        _include(path, model, files)
    for place, include in [(i, element) for i, element in enumerate(parent) if element.tag == "include"]:
        parent[place] = _include_model(path, include, files)


def _include_model(path: Path, include: ET.Element, files: IncludedFiles) -> ET.Element:
    """The model that an <include> requests as a whole under a new name, and in no other manner."""
    if (merge := include.get("merge", "false").strip()) not in ("false", "0"):
        expected = "leave it out: links get the name of the included model before them"
        raise InputError(path, "include.merge", merge, expected)
    if any(isinstance(element.tag, str) and element.tag.endswith("params") for element in include):
        expected = "leave it out, and include a file with these changes"
        raise InputError(path, "include.experimental:params", include.findtext("uri"), expected)
    uri, file = sdf_file(path, include)
    with files.read("include.uri", uri, file) as root:
        models = [*root.findall("model"), *root.findall("include")] if root.tag == "sdf" else []
        if len(models) != 1:
            raise InputError(path, "include.uri", uri, f"must be SDFormat with one model: {file}")
        _include(file, root, files)
    (model,) = root.findall("model")
    _modernize(model, _version(file, root))
    for mesh in model.iter("mesh"):
        for name in mesh.findall("uri"):
            if "://" not in (text := (name.text or "").strip()):
                name.text = f"file://{Path(os.path.realpath(file.parent)) / text}"
    for tag in _OVERRIDE_TAGS:
        if (value := include.find(tag)) is not None:
            take(model, tag)
            model.append(value)
    model.set("name", (include.findtext("name") or model.get("name") or "").strip())
    if frame := (include.findtext("placement_frame") or "").strip():
        model.set("placement_frame", frame)
    return model


def _modernize(model: ET.Element, version: tuple[int, ...]) -> None:
    """Writes the frame of axes explicitly, where older versions of SDFormat have another rule."""
    for axis in [*model.findall("joint/axis"), *model.findall("joint/axis2")] if version < _TARGET_VERSION else ():
        marks = take(axis, "use_parent_model_frame")
        is_in_model = (marks[-1].text or "").strip() in ("true", "1") if marks else version < (1, 5)
        for direction in axis.findall("xyz") if is_in_model else ():
            direction.set("expressed_in", "__model__")
    for inner_model in model.findall("model"):
        _modernize(inner_model, version)


def _merge_all(path: Path, parent: ET.Element) -> None:
    """Moves the elements of nested models into the model around them."""
    inner_models = parent.findall("model")
    for model in inner_models:
        _merge(path, parent, model)
    _scope(parent, {model.get("name", "") for model in inner_models})


def _merge(path: Path, parent: ET.Element, inner_model: ET.Element) -> None:
    name = inner_model.get("name", "")
    _merge_all(path, inner_model)
    fix_if_static(inner_model)
    links = [link.get("name", "") for link in inner_model.findall("link")]
    if (frame := inner_model.get("placement_frame")) is not None:
        raise InputError(f"{path}: model '{name}'", "placement_frame", frame, "leave it out of a nested model")
    if not links:
        raise InputError(path, "model", name, "is nested, and holds no link")
    first = inner_model.get("canonical_link", links[0])
    for element in inner_model:
        if element.tag == "frame":
            element.attrib.setdefault("attached_to", "__model__")
        elif element.tag in ("link", "model"):
            _relative_pose(element)
        _rename(element, name)
    pose = _relative_pose(inner_model)
    frame_of_model = ET.Element("frame", {"name": name, "attached_to": f"{name}_{first.replace('::', '_')}"})
    frame_of_model.append(pose)
    parent.remove(inner_model)
    parent.append(frame_of_model)
    parent.extend([element for element in inner_model if element.tag in _NAMED_TAGS])
    parent.extend([element for element in inner_model if str(element.tag).startswith(DRAKE)])


def _relative_pose(element: ET.Element) -> ET.Element:
    """The pose of an element, which names the frame of the model if it named none."""
    pose = element.find("pose")
    pose = ET.SubElement(element, "pose") if pose is None else pose
    pose.attrib.setdefault("relative_to", "__model__")
    return pose


def _rename(element: ET.Element, prefix: str) -> None:
    """Prefixes all names of a nested model, and all references to them."""
    if element.tag in _NAMED_TAGS:
        element.set("name", f"{prefix}_{element.get('name', '')}")
    for part in element.iter():
        for key in _REFERRING_ATTRIBUTES:
            if (value := part.get(key)) is not None:
                part.set(key, _prefix_name(value, prefix))
        if part.tag == "mimic" and (leader := part.get("joint")):
            part.set("joint", _prefix_name(leader, prefix))
        if part.tag in _REFERRING_TEXTS and len(part) == 0 and part.text:
            part.text = _prefix_name(part.text.strip(), prefix)


def _prefix_name(name: str, prefix: str) -> str:
    return prefix if name == "__model__" else name if not name or name in _OUTER_NAMES else f"{prefix}_{name}"


def _scope(model: ET.Element, inner_names: Collection[str]) -> None:
    """Replaces scoped names, such as `hand::palm`, by those after merging."""

    def is_inside(name: str) -> bool:
        model_name, colons, _ = name.partition("::")
        return bool(colons) and model_name in inner_names

    for part in model.iter() if inner_names else ():
        for key, value in part.attrib.items():
            if (key in _REFERRING_ATTRIBUTES or part.tag == "mimic") and is_inside(value):
                part.set(key, value.replace("::", "_"))
        if part.tag in _REFERRING_TEXTS and is_inside(text := (part.text or "").strip()):
            part.text = text.replace("::", "_")
