"""Model files into the plant: URDF with <finger>s, all other formats that Drake reads, and bare meshes."""

import logging
import math
import os
from collections.abc import Mapping, Sequence
from copy import deepcopy
from dataclasses import fields, replace
from functools import partial
from pathlib import Path
from typing import Any, NamedTuple, TypeVar

from pydrake.math import RollPitchYaw, RotationMatrix
from pydrake.multibody.parsing import Parser
from pydrake.multibody.plant import MultibodyPlant
from pydrake.multibody.tree import ModelInstanceIndex

from soft_gripper.control.couplings import Mimic
from soft_gripper.errors import InputError
from soft_gripper.files.document import require
from soft_gripper.files.number import number
from soft_gripper.files.text import name_of
from soft_gripper.files.xml_text import read_xml
from soft_gripper.fingers.cross_section import CrossSection
from soft_gripper.fingers.finger import Finger
from soft_gripper.fingers.finger_element import FingerElement
from soft_gripper.fingers.finger_links import link_name
from soft_gripper.fingers.finger_parts import ContactMaterial
from soft_gripper.fingers.paths import Chamber, Tendon
from soft_gripper.fingers.plant_finger import PlantFinger, add_torsion_springs
from soft_gripper.fingers.urdf import ExpandedUrdf, expand_urdf, read_fingers
from soft_gripper.models import DIRECTORY, PACKAGE, package_map
from soft_gripper.scenario.arm_joints import couple, exclude_contact, exclude_self_contact, free_followers, set_limits
from soft_gripper.scenario.contact_surface import touch_at_surfaces
from soft_gripper.scenario.deformables import deformable_body, deformable_kind
from soft_gripper.scenario.drake_parsing import add_file, add_text, check_inside, drake_reads
from soft_gripper.scenario.link_inertia import note_spread
from soft_gripper.scenario.mass_and_friction import geometries, set_friction, with_mass
from soft_gripper.scenario.mesh_object import mesh_suffixes, mesh_to_sdf
from soft_gripper.scenario.mjcf_xml import ready_mjcf
from soft_gripper.scenario.model_xml import ready
from soft_gripper.scenario.plausible_sizes import check_meshes, note_quantities
from soft_gripper.scenario.schema import ArmConfig, FingerChanges, FingerConfig, ModelConfig

_LOGGER = logging.getLogger(__name__)
OF_SECTION = tuple(field.name for field in fields(CrossSection))
OF_FINGER = ("length", "relaxation_time", "sensor_spacing")
# Fields of the chambers and tendons of a finger, by the names of their changes.
_OF_CHAMBER = {"chamber_width": "width", "chamber_thickness": "thickness"}
_OF_TENDON = {f"tendon_{name}": name for name in ("stiffness", "friction", "slack")}
_OF_CONTACT = tuple(field.name for field in fields(ContactMaterial))
_LONGEST_STEP = 0.01  # s; a longer one may be an oversight, and is refused if explicit springs are unstable
_ALL = "all"
_SUSPICIOUS_FACTOR = 20.0  # times the value so far; a larger change is taken for one whose "%" was forgotten
_EXPECTED = 'give a number, or a change such as "+10 %"'


def check_names(where: str, configs: Mapping[str, FingerConfig], names: Sequence[str]) -> None:
    """Raises an InputError unless changes are for "all" or for one of the named fingers."""
    known = (_ALL, *names) if names else ()
    for name in configs:
        if name not in known:
            raise InputError(where, "fingers", name, f"no such finger; known: {', '.join(known) or 'none'}")


def mounted_finger(mounted: FingerElement, where: str, configs: Mapping[str, FingerConfig]) -> FingerElement:
    """A finger and its place with the changes for all and, on top of them, its own; see `configured_finger`."""
    turn = RollPitchYaw(mounted.rpy).ToRotationMatrix()
    for name in (_ALL, mounted.finger.name):
        if (config := configs.get(name)) and config.tilt is not None:
            turn = turn @ RotationMatrix.MakeYRotation(_value(f"{where}.fingers.{name}", "tilt", config.tilt, 0.0))
    is_tilted = any(config.tilt is not None for config in configs.values())
    angles = RollPitchYaw(turn)
    rpy = tuple(map(float, angles.vector())) if is_tilted else mounted.rpy
    return replace(mounted, finger=configured_finger(mounted.finger, where, configs), rpy=rpy)


def mounted_fingers(config: ModelConfig, where: str) -> tuple[FingerElement, ...]:
    """The fingers of a model as they are simulated, and their places; none of what is not a URDF.

    Raises:
        InputError: if the file is missing or wrong, or the changes do not fit.
    """
    path = model_path(config.file)
    if kind_of(path) != "robot":
        return ()
    read = read_fingers(path, config.segments, config.name, config.without)
    return tuple(mounted_finger(mounted, where, config.fingers) for mounted in read)


def configured_finger(finger: Finger, where: str, configs: Mapping[str, FingerConfig]) -> Finger:
    """A finger with the changes for all and, on top of them, its own.

    Args:
        finger: as its file gives it.
        where: the model, for messages.
        configs: by names of fingers, or for "all".

    Raises:
        InputError: if a change is not a number, or the result cannot be a finger.
    """
    for name in (_ALL, finger.name):
        if config := configs.get(name):
            place = f"{where}.fingers.{name}"
            finger = changed_finger(finger, place, config, (*OF_FINGER, "shear_factor"))
            finger = _replaced(finger, contact=changed_part(finger.contact, place, config, _OF_CONTACT))
            finger = _with(finger, place, tendons=_changed_paths(finger.tendons, place, config, _OF_TENDON))
            if config.yields is not None:
                finger = _with(finger, place, yields=tuple(config.yields.split()))
    return finger


def _with(finger: Finger, where: str, **changes: Any) -> Finger:
    try:
        return _replaced(finger, **changes)
    except InputError as error:
        raise InputError(where, error.field, error.value, error.expected) from None


_D = TypeVar("_D")


def _replaced(part: _D, **changes: Any) -> _D:
    """A dataclass with changes; itself if they change nothing, since a copy is checked anew."""
    return part if all(getattr(part, name) == value for name, value in changes.items()) else replace(part, **changes)  # type: ignore[type-var]


def changed_finger(finger: Finger, where: str, changes: FingerChanges, of_finger: Sequence[str]) -> Finger:
    """A finger with changes of all sections, chambers and the fields `of_finger`; raises as `configured_finger`."""
    if finger.chambers and changes.chamber_center is not None:
        expected = "leave it out: its chambers lie where <chamber> has them"
        raise InputError(where, "chamber_center", changes.chamber_center, expected)
    of_section = [name for name in OF_SECTION if not (finger.chambers and name in _OF_CHAMBER)]
    try:
        alike = changed_part(finger, where, changes, of_finger)
        chambers = _changed_paths(finger.chambers, where, changes, _OF_CHAMBER)
        base, *between, tip = (changed_part(each, where, changes, of_section) for each in alike.cross_sections)
        return _replaced(alike, base=base, sections=tuple(between), tip=tip, chambers=chambers)
    except InputError as error:
        raise (error if error.where == where else error.inside(where)) from None


def changed_part(part: Any, where: str, changes: FingerChanges, names: Sequence[str]) -> Any:
    """A dataclass with changes of some of its fields."""
    texts = {name: getattr(changes, name) for name in names if getattr(changes, name) is not None}
    return _replaced(part, **{name: _value(where, name, text, getattr(part, name)) for name, text in texts.items()})


_P = TypeVar("_P", Chamber, Tendon)


def _changed_paths(paths: Sequence[_P], where: str, changes: FingerChanges, names: Mapping[str, str]) -> tuple[_P, ...]:
    """Paths with changes of some of their fields, `names` by those of the changes."""
    texts = {name: text for name in names if (text := getattr(changes, name)) is not None}
    if texts and not paths and set(texts) <= set(_OF_TENDON):
        name, text = next(iter(texts.items()))
        raise InputError(where, name, text, "leave it out: the finger has no tendon")
    return tuple(
        _replaced(
            path,
            **{names[name]: _values(where, name, text, getattr(path, names[name])) for name, text in texts.items()},
        )
        for path in paths
    )


def _values(where: str, name: str, text: str, before: Any) -> Any:
    """The value after a change, or the values at the stations of a path."""
    if isinstance(before, tuple):
        return tuple(_value(where, name, text, each) for each in before)
    return _value(where, name, text, before)


def _value(where: str, name: str, text: str, before: float) -> float:
    """The value after a change."""
    size, percent, rest = str(text).partition("%")
    try:
        value = number(size)
    except ValueError:
        value = math.nan
    relative, sign = bool(percent), size.strip()[:1]
    wrong = rest.strip() or (relative and sign not in ("+", "-")) or (not relative and sign == "+")
    if wrong or not math.isfinite(value):
        raise InputError(where, name, text, _EXPECTED)
    if not relative and value > 0 and before > 0 and not 1 / _SUSPICIOUS_FACTOR <= value / before <= _SUSPICIOUS_FACTOR:
        raise InputError(where, name, text, f'is far from the simulated {before:g}; a change is written "+10 %"')
    return before * (1 + value / 100) if relative else value


class LoadedModel(NamedTuple):
    """A model in a plant, the fingers in it, and its joints that follow others."""

    model: ModelInstanceIndex
    fingers: list[PlantFinger]
    mimics: Sequence[Mimic]


def _expanded(
    plant: MultibodyPlant, path: Path, config: ModelConfig, where: str, visuals: bool, points: int | None
) -> ExpandedUrdf:
    """A URDF file with its fingers, with implicit springs if none are chosen and explicit ones need shorter steps."""
    expand = partial(
        expand_urdf,
        path,
        config.segments,
        config.name,
        config.without,
        change=partial(mounted_finger, where=where, configs=config.fingers),
        visuals=visuals,
        points=points,
        touches_itself=config.self_contact,
    )
    expanded = expand(springs=config.springs or "linear")
    if config.springs is None and _are_too_stiff(expanded.fingers, plant.time_step()):
        _LOGGER.warning("%s: springs are implicit, since explicit ones need shorter steps", where)
        expanded = expand(springs="implicit")
    return expanded


def _check_contents(plant: MultibodyPlant, model: ModelInstanceIndex, config: ModelConfig, where: str) -> None:
    """Checks that a model has links, or is one soft object that is free."""
    soft = deformable_body(plant, model)
    if soft is not None and deformable_kind() is None:
        raise InputError(where, "file", config.file, "holds a body of finite elements; give a model with rigid links")
    if soft is None and not plant.GetBodyIndices(model):
        raise InputError(where, "file", config.file, "holds a model without links")
    if soft is not None and plant.GetBodyIndices(model):
        raise InputError(where, "file", config.file, "holds a soft and a rigid link; give a file with one link")
    if soft is not None and not config.free:
        raise InputError(
            where, "free", False, f"must be true: {config.file} is a soft object, which nothing is welded to"
        )


class _Prepared(NamedTuple):
    """A model as Drake reads it."""

    text: str | None  # None: the file as it is
    suffix: str = ""  # of the format of the text
    fingers: Sequence[Finger] = ()
    mimics: Sequence[Mimic] = ()
    apart: Sequence[tuple[list[str], list[str]]] = ()


def _prepared(
    plant: MultibodyPlant,
    path: Path,
    kind: str,
    config: ModelConfig,
    where: str,
    is_arm: bool,
    visuals: bool,
    points: int | None,
) -> _Prepared:
    """A model of a `kind_of` file; further arguments as of `load_model`."""
    if kind == "robot":
        expanded = _expanded(plant, path, config, where, visuals, points)
        found = ready(path, deepcopy(expanded.robot), is_arm, config.free, config.child)
        return _Prepared(found.text, ".urdf", expanded.fingers, found.mimics)
    if kind == "sdf":
        found = ready(path, read_xml(path), is_arm, config.free, config.child, config.without)
        return _Prepared(found.text, ".sdf", mimics=found.mimics)
    if kind == "mujoco":
        found = ready_mjcf(path, read_xml(path), is_arm, config.without)
        return _Prepared(found.text, ".xml", mimics=found.mimics, apart=found.apart)
    if kind in mesh_suffixes():
        return _Prepared(mesh_to_sdf(path, config.mesh, config.name, config.mass, config.friction), ".sdf")
    return _Prepared(None)


def _check_choices(config: ModelConfig, kind: str, where: str, points: int | None) -> None:
    """Checks what a scenario chooses for a model, before its file is read."""
    if config.without and kind not in _ROOTS:
        expected = f"links can be left out of {', '.join(_ROOTS.values())} only"
        raise InputError(where, "without", config.without, expected)
    if config.self_contact and points is not None:
        expected = "leave it out with contact: points: these lie under the skin, and would meet too late"
        raise InputError(where, "self_contact", True, expected)


def _check_fingers_keep(config: ModelConfig, where: str, fingers: Sequence[Finger]) -> None:
    """Checks that mass and friction of a model with fingers are not given for all of it: fingers have theirs."""
    for name, of_fingers in {"mass": "density", "friction": "friction"}.items():
        given = getattr(config, name)
        expected = f"leave it out: the model has fingers; give fingers.all.{of_fingers}"
        require(given is None or not fingers, where, name, given, expected)


def load_model(
    plant: MultibodyPlant,
    config: ModelConfig,
    where: str,
    arm: ArmConfig | None = None,
    visuals: bool = True,
    points: int | None = None,
) -> LoadedModel:
    """Adds one model to the plant, under its name in the scenario.

    The file is first made ready for Drake, see `ready`; `arm` is given for an arm. Without `visuals`, fingers are not
    seen; for `points` see `expand_urdf`.

    Raises:
        InputError: if the file is missing, or neither we nor Drake can read it.
    """
    path = model_path(config.file)
    if not os.path.isfile(path):
        raise InputError(where, "file", config.file, f"there is no file {path}")
    kind = kind_of(path)
    _check_choices(config, kind, where, points)
    parser = Parser(plant)
    parser.SetAutoRenaming(True)
    parser.package_map().AddMap(package_map())
    shapes = geometries(parser)
    is_fixture = arm is None and not config.free and config.parent == "world"
    with drake_reads(where, "file", config.file, path):
        prepared = _prepared(plant, path, kind, config, where, arm is not None, visuals, points)
        text, suffix, fingers, mimics, apart = prepared
        _check_fingers_keep(config, where, fingers)
        if text is not None and config.mass is not None and kind not in mesh_suffixes():
            text = with_mass(where, config.mass, text, path, suffix)
        models = add_file(parser, path) if text is None else add_text(parser, text, path, suffix)
        check_meshes(path, parser, shapes, config.free, is_fixture)
    check_names(where, config.fingers, [finger.name for finger in fingers])
    require(bool(fingers) or not config.self_contact, where, "self_contact", True, f"{config.file} has no finger")
    if len(models) != 1:
        raise InputError(where, "file", config.file, f"holds {len(models)} models; give a file with one")
    if plant.HasModelInstanceNamed(config.name) and plant.GetModelInstanceName(models[0]) != config.name:
        raise InputError(where, "name", config.name, "is taken by another model")
    plant.RenameModelInstance(models[0], config.name)
    couple(path, plant, models[0], mimics)
    exclude_contact(parser, models[0], apart)
    if config.friction is not None and kind not in mesh_suffixes():
        set_friction(where, config.friction, parser, shapes)
    note_spread(path, parser, models[0], stands=not config.free and config.parent == "world")
    if arm is None:
        touch_at_surfaces(parser, shapes)
    else:
        set_limits(path, plant, models[0], arm.limits, mimics)
        exclude_self_contact(parser, models[0])
    free_followers(path, plant, models[0], mimics, {} if arm is None else arm.limits)
    note_quantities(path, parser, models[0], fingers, config.free)
    _check_contents(plant, models[0], config, where)
    put = add_torsion_springs if config.springs == "torsion" else PlantFinger
    return LoadedModel(models[0], [put(finger=finger, plant=plant, model=models[0]) for finger in fingers], mimics)


_ROOTS = {"robot": "URDF", "sdf": "SDFormat", "mujoco": "MJCF"}  # root elements, and what they begin
_XML = (".urdf", ".xacro", ".sdf", ".world", ".xml", ".mjcf")


def kind_of(path: Path) -> str:
    """The root element of an XML file, of which `_ROOTS` knows some; the suffix, in lower case, of any other file.

    Raises:
        InputError: if it is XML of no known kind.
    """
    suffix = path.suffix.lower()
    if suffix not in _XML:
        return suffix
    root = read_xml(path).tag
    if root not in _ROOTS:
        known = ", ".join(f"<{name}> ({kind})" for name, kind in _ROOTS.items())
        raise InputError(path, "root element", root, f"a model begins with one of {known}")
    return root


def is_mjcf(path: Path) -> bool:
    """Whether a model file is MJCF, MuJoCo's format."""
    return kind_of(path) == "mujoco"


def _are_too_stiff(fingers: Sequence[Finger], time_step: float) -> bool:
    """Whether explicit springs would be unstable, and implicit ones, which know no elastic law, take their place."""
    can_be_implicit = all(finger.elastic_law is None for finger in fingers)
    unstable = any(time_step > finger.stable_time_step() for finger in fingers)
    return can_be_implicit and unstable and time_step <= _LONGEST_STEP


def add_fingers(
    parser: Parser, file: Path | str, name: str | None = None, segments: int | None = None
) -> list[PlantFinger]:
    """Reads a URDF with <finger>s into the plant of a parser, which is not yet finalized.

    Weld its first link where it belongs, finalize the plant, and give the fingers to `add_pressure_drive` and
    `add_sensing`. The same file may be read again, under another name.

    Args:
        parser: of the plant; its package map finds the meshes that the file names.
        file: a path or package://soft_gripper/... URI.
        name: of the model instance; None: the name of the robot in the file.
        segments: of every finger; None: as in the file.

    Returns:
        the fingers, in the order of the file.

    Raises:
        InputError: if the file is missing or wrong, has no fingers, or the name is taken.
    """
    path, plant = model_path(str(file)), parser.plant()
    if plant.is_finalized():
        raise InputError(path, "plant", "finalized", "read fingers before plant.Finalize()")
    if name is not None and (not name or plant.HasModelInstanceNamed(name)):
        expected = "is taken by another model" if name else "give a name, or None for the robot's in the file"
        raise InputError(path, "name", name, expected)
    expanded = expand_urdf(path, segments, model_name=name)
    if not expanded.fingers:
        raise InputError(path, "finger", None, "there is no <finger> in the file")
    with drake_reads(path, "file", path.name, path):
        found = ready(path, deepcopy(expanded.robot))
        (model,) = add_text(parser, found.text, path, ".urdf")
    couple(path, plant, model, found.mimics)
    free_followers(path, plant, model, found.mimics)
    return [PlantFinger(finger, plant, model) for finger in expanded.fingers]


def find_fingers(
    plant: MultibodyPlant, file: Path | str, model: ModelInstanceIndex, segments: int | None = None
) -> list[PlantFinger]:
    """The fingers of a model that was read from the expanded text of a URDF, as by ModelDirectives.

    Args:
        plant: with the model in it.
        file: the URDF with <finger>s that was expanded.
        model: the model instance.
        segments: with which it was expanded; None: as in the file.

    Raises:
        InputError: if the file is wrong, or the model has no such fingers.
    """
    path = model_path(str(file))
    found = [PlantFinger(finger, plant, model) for finger in expand_urdf(path, segments).fingers]
    for finger in (finger.finger for finger in found):
        last, beyond = (plant.HasBodyNamed(link_name(finger.name, finger.segments + i), model) for i in (0, 1))
        if not last or beyond:
            expected = f"is not in '{plant.GetModelInstanceName(model)}' with {finger.segments} segments"
            raise InputError(path, "finger", finger.name, expected)
    return found


def model_path(file: str | Path) -> Path:
    """The file behind a package:// URI of a package that Drake or soft_gripper knows, or a plain path.

    Raises:
        InputError: if there is no such package, or the URI leads out of it.
    """
    file = name_of(file)
    if not file.startswith("package://"):
        return Path(file)
    check_inside("model", file)
    package, _, inside = file.removeprefix("package://").partition("/")
    if package == PACKAGE:
        return DIRECTORY / inside
    packages = package_map()
    if not packages.Contains(package):
        known = ", ".join(packages.GetPackageNames())
        raise InputError("model", "file", file, f"no package '{package}'; known: {known}")
    return Path(packages.GetPath(package)) / inside
