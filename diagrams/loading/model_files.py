"""Model files into the plant: URDF with <finger>s, whatever else Drake reads, and bare meshes."""

from pathlib import Path

from pydrake.multibody.parsing import Parser
from pydrake.multibody.plant import MultibodyPlant
from pydrake.multibody.tree import ModelInstanceIndex

from soft_gripper.diagrams.loading.arm_file import arm_urdf
from soft_gripper.diagrams.loading.mesh_object import MESH_SUFFIXES, mesh_to_sdf
from soft_gripper.diagrams.scenario import ModelConfig
from soft_gripper.errors import InputError
from soft_gripper.finger import Finger
from soft_gripper.models import DIRECTORY, PACKAGE, package_map
from soft_gripper.urdf import expand_urdf


def load_model(
    plant: MultibodyPlant, config: ModelConfig, where: str, is_arm: bool = False
) -> tuple[ModelInstanceIndex, tuple[Finger, ...]]:
    """Adds one model to the plant, under its name in the scenario; returns it and the fingers in it.

    The file of an arm is first made ready for Drake, see `arm_urdf`.

    Raises:
        InputError: if the file is missing, or neither we nor Drake can read it.
    """
    path = model_path(config.file)
    if not path.is_file():
        raise InputError(where, "file", config.file, f"there is no file {path}")
    is_urdf = path.suffix.lower() in (".urdf", ".xacro")
    if config.without and not is_urdf:
        raise InputError(where, "without", config.without, "links can be left out of URDF files only")
    parser = Parser(plant)
    parser.SetAutoRenaming(True)
    parser.package_map().AddMap(package_map())
    fingers: tuple[Finger, ...] = ()
    try:
        if is_urdf:
            expanded = expand_urdf(path, config.segments or None, config.name, config.without)
            fingers = expanded.fingers
            text = arm_urdf(path, expanded.text) if is_arm else expanded.text
            models = parser.AddModelsFromString(text, "urdf")
        elif path.suffix.lower() in MESH_SUFFIXES:
            models = parser.AddModelsFromString(mesh_to_sdf(path, config.mesh, config.name), "sdf")
        else:
            models = parser.AddModels(str(path))
    except RuntimeError as error:
        raise InputError(where, "file", config.file, f"Drake cannot read it: {first_line(error)}") from None
    if len(models) != 1:
        raise InputError(where, "file", config.file, f"holds {len(models)} models; give a file with one")
    if plant.HasModelInstanceNamed(config.name) and plant.GetModelInstanceName(models[0]) != config.name:
        raise InputError(where, "name", config.name, "is taken by another model")
    plant.RenameModelInstance(models[0], config.name)
    return models[0], fingers


def model_path(file: str) -> Path:
    """The file behind a package:// URI of a package that Drake or soft_gripper knows, or a plain path."""
    if not file.startswith("package://"):
        return Path(file)
    package, _, inside = file.removeprefix("package://").partition("/")
    packages = package_map()
    if package == PACKAGE:
        return DIRECTORY / inside
    if not packages.Contains(package):
        known = ", ".join(packages.GetPackageNames())
        raise InputError("model", "file", file, f"no package '{package}'; known: {known}")
    return Path(packages.GetPath(package)) / inside


def first_line(error: Exception) -> str:
    """What an exception says, short enough for a message of one line."""
    return str(error).strip().splitlines()[0]
