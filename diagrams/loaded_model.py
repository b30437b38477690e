"""Loads a model of a scenario into the plant: reads its file, expands its fingers, applies the scenario's changes."""

import logging
import os
from collections.abc import Sequence
from copy import deepcopy
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import NamedTuple

from pydrake.multibody.parsing import Parser
from pydrake.multibody.plant import MultibodyPlant
from pydrake.multibody.tree import ModelInstanceIndex

from soft_gripper.errors import InputError
from soft_gripper.files.document import require
from soft_gripper.files.notes import READ, report
from soft_gripper.fingers.finger import Finger
from soft_gripper.fingers.finger_links import link_name
from soft_gripper.fingers.plant_finger import PlantFinger, add_torsion_springs
from soft_gripper.fingers.urdf import ExpandedUrdf, expand_urdf
from soft_gripper.model_import.added_model import (
    AddedModel,
    add_model,
    check_meshes,
    note_quantities,
    note_spread,
    set_friction,
    touch_at_surfaces,
)
from soft_gripper.model_import.arm_joints import (
    couple,
    exclude_contact,
    exclude_self_contact,
    free_followers,
    set_limits,
)
from soft_gripper.model_import.drake_parsing import drake_reads
from soft_gripper.model_import.imported_model import ImportedModel, ImportOptions, Mimic
from soft_gripper.model_import.model_file import ModelFile
from soft_gripper.model_import.read_model import has_form, read_model
from soft_gripper.models import package_map
from soft_gripper.scenario.deformables import deformable_body, deformable_kind
from soft_gripper.scenario.finger_changes import check_names, mounted_finger
from soft_gripper.scenario.model_files import model_path
from soft_gripper.scenario.schema import ArmConfig, ModelConfig

_LOGGER = logging.getLogger(__name__)
_MAX_STEP = 0.01  # s; a longer one may be an oversight, and is refused if explicit springs are unstable
_MAX_FINGER_LENGTH = 1.0  # m


class LoadedModel(NamedTuple):
    """A model in a plant, the fingers in it, and its joints that follow others."""

    model: ModelInstanceIndex
    fingers: list[PlantFinger]
    mimics: Sequence[Mimic]


def load_model(
    plant: MultibodyPlant,
    config: ModelConfig,
    where: str,
    arm: ArmConfig | None = None,
    visuals: bool = True,
    points: int | None = None,
) -> LoadedModel:
    """Adds one model to the plant, under its name in the scenario.

    The file is first made ready for Drake, see `read_model`; `arm` is given for an arm. Without `visuals`, fingers are
    not seen; for `points` see `expand_urdf`.

    Raises:
        InputError: if the file is missing, or neither we nor Drake can read it.
    """
    path = model_path(config.file)
    if not os.path.isfile(path):
        raise InputError(where, "file", config.file, f"there is no file {path}")
    file = ModelFile(path)
    if config.self_contact and points is not None:
        expected = "leave it out with contact: points: these lie under the skin, and would meet too late"
        raise InputError(where, "self_contact", True, expected)
    options, fingers = import_options(config, where, arm is not None), tuple[Finger, ...]()
    is_welded_to_world = not config.free and config.parent == "world"
    is_urdf = has_form(file, "URDF")
    with drake_reads(where, "file", config.file, file):
        if is_urdf:
            expanded = _expand(plant, file.path, config, where, visuals, points)
            file.root = deepcopy(expanded.robot)
            fingers = expanded.fingers
            options = replace(options, without=())  # with what hangs on them, before fingers are expanded
            _check_fingers_keep(config, where, fingers)
        imported = read_model(file, options)
        parser = Parser(plant)
        parser.SetAutoRenaming(True)
        parser.package_map().AddMap(package_map())
        model = add_model(parser, file, imported)
        check_meshes(model, config.free, is_fixture=arm is None and is_welded_to_world)
    _check_model(model, config, where, fingers)
    plant.RenameModelInstance(model.index, config.name)
    _set_joints_and_contact(model, imported, arm, where)
    for finger in fingers:
        if finger.length > _MAX_FINGER_LENGTH:
            file.note(READ, f"finger '{finger.name}': length", f"{finger.length:g} m", "is it in millimetres?")
    note_spread(model, is_welded_to_world)
    note_quantities(model, config.free)
    report(file.notes)
    make_finger = add_torsion_springs if config.springs == "torsion" else PlantFinger
    plant_fingers = [make_finger(finger=finger, plant=plant, model=model.index) for finger in fingers]
    return LoadedModel(model.index, plant_fingers, model.mimics)


def import_options(config: ModelConfig, where: str = "model", is_arm: bool = False) -> ImportOptions:
    """The requests of a scenario on a model, fingers excluded."""
    kind = deformable_kind()
    add_to_link = None
    if kind is not None and kind.is_meant(config.mesh):
        add_to_link = partial(kind.add_to_link, config.mesh)
    requests = config.free, config.child, config.without, config.mass, config.friction
    return ImportOptions(where, is_arm, *requests, config.name, config.mesh.scale, config.mesh.color, add_to_link)


def _expand(
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


def _are_too_stiff(fingers: Sequence[Finger], time_step: float) -> bool:
    """Whether explicit springs would be unstable and implicit ones, which have no elastic law, can replace them."""
    can_be_implicit = all(finger.elastic_law is None for finger in fingers)
    unstable = any(time_step > finger.stable_time_step() for finger in fingers)
    return can_be_implicit and unstable and time_step <= _MAX_STEP


def _check_model(model: AddedModel, config: ModelConfig, where: str, fingers: Sequence[Finger]) -> None:
    """Checks that a file has one model, of another name, with links or one soft object, that suits its config."""
    plant = model.plant
    check_names(where, config.fingers, [finger.name for finger in fingers])
    require(bool(fingers) or not config.self_contact, where, "self_contact", True, f"{config.file} has no finger")
    if len(model.indices) != 1:
        raise InputError(where, "file", config.file, f"holds {len(model.indices)} models; give a file with one")
    if plant.HasModelInstanceNamed(config.name) and plant.GetModelInstanceName(model.index) != config.name:
        raise InputError(where, "name", config.name, "is taken by another model")
    soft_body, has_links = deformable_body(plant, model.index), bool(plant.GetBodyIndices(model.index))
    if soft_body is None:
        require(has_links, where, "file", config.file, "holds a model without links")
        return
    expected = "holds a body of finite elements; give a model with rigid links"
    require(deformable_kind() is not None, where, "file", config.file, expected)
    require(not has_links, where, "file", config.file, "holds a soft and a rigid link; give a file with one link")
    expected = f"must be true: {config.file} is a soft object, which nothing is welded to"
    require(config.free, where, "free", False, expected)


def _set_joints_and_contact(model: AddedModel, imported: ImportedModel, arm: ArmConfig | None, where: str) -> None:
    """Couples joints, sets their limits, and says what touches what, with which friction."""
    couple(model)
    exclude_contact(model, imported.apart)
    if imported.friction is not None:
        set_friction(where, imported.friction, model)
    if arm is None:
        touch_at_surfaces(model)
        free_followers(model)
    else:
        set_limits(model, arm.limits)
        exclude_self_contact(model)
        free_followers(model, arm.limits)


def _check_fingers_keep(config: ModelConfig, where: str, fingers: Sequence[Finger]) -> None:
    """Checks that mass and friction of a model with fingers are not given for all of it: fingers have theirs."""
    for name, finger_field in {"mass": "density", "friction": "contact.friction"}.items():
        value = getattr(config, name)
        expected = f"leave it out: the model has fingers; give fingers.all.{finger_field}"
        require(value is None or not fingers, where, name, value, expected)


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
    path = model_path(str(file))
    plant = parser.plant()
    if plant.is_finalized():
        raise InputError(path, "plant", "finalized", "read fingers before plant.Finalize()")
    if name is not None and (not name or plant.HasModelInstanceNamed(name)):
        expected = "is taken by another model" if name else "give a name, or None for the robot's in the file"
        raise InputError(path, "name", name, expected)
    expanded = expand_urdf(path, segments, model_name=name)
    if not expanded.fingers:
        raise InputError(path, "finger", None, "there is no <finger> in the file")
    model_file = ModelFile(path, deepcopy(expanded.robot))
    with drake_reads(path, "file", path.name, model_file):
        model = add_model(parser, model_file, read_model(model_file))
    couple(model)
    free_followers(model)
    report(model_file.notes)
    return [PlantFinger(finger, plant, model.index) for finger in expanded.fingers]


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
    plant_fingers = [PlantFinger(finger, plant, model) for finger in expand_urdf(path, segments).fingers]
    for finger in (finger.finger for finger in plant_fingers):
        has_last, has_more = (plant.HasBodyNamed(link_name(finger.name, finger.segments + i), model) for i in (0, 1))
        if not has_last or has_more:
            expected = f"is not in '{plant.GetModelInstanceName(model)}' with {finger.segments} segments"
            raise InputError(path, "finger", finger.name, expected)
    return plant_fingers
