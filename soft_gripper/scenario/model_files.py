"""The files of models, and the fingers in them as a scenario has them."""

from pathlib import Path

from soft_gripper.errors import InputError
from soft_gripper.files.text import name_of
from soft_gripper.fingers.finger_element import FingerElement
from soft_gripper.fingers.urdf import read_fingers
from soft_gripper.model_import.drake_parsing import check_inside
from soft_gripper.model_import.model_file import ModelFile
from soft_gripper.model_import.read_model import has_form
from soft_gripper.models import DIRECTORY, PACKAGE, package_map
from soft_gripper.scenario.finger_changes import mounted_finger
from soft_gripper.scenario.schema import ModelConfig


def mounted_fingers(config: ModelConfig, where: str) -> tuple[FingerElement, ...]:
    """The simulated fingers of a URDF, none in other files, and their mounts; raises an InputError if any is wrong."""
    path = model_path(config.file)
    if not has_form(ModelFile(path), "URDF"):
        return ()
    elements = read_fingers(path, config.segments, config.name, config.without)
    return tuple(mounted_finger(mounted, where, config.fingers) for mounted in elements)


def is_mjcf(path: Path) -> bool:
    return has_form(ModelFile(path), "MJCF")


def model_path(file: str | Path, where: str = "model") -> Path:
    """The file behind a package:// URI of a package that Drake or soft_gripper knows, or a plain path.

    Raises:
        InputError: naming `where`, if there is no such package, or the URI leads out of it.
    """
    file = name_of(file)
    if not file.startswith("package://"):
        return Path(file)
    check_inside(where, file)
    package, _, inside = file.removeprefix("package://").partition("/")
    if package == PACKAGE:
        return DIRECTORY / inside
    packages = package_map()
    if not packages.Contains(package):
        package_names = ", ".join(packages.GetPackageNames())
        raise InputError(where, "file", file, f"no package '{package}'; known: {package_names}")
    return Path(packages.GetPath(package)) / inside
