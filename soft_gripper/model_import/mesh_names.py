"""Names of meshes in model files, and the files behind them."""

import os
import re
from collections.abc import Iterator
from pathlib import Path

from soft_gripper.errors import InputError
from soft_gripper.files.xml_text import read_xml
from soft_gripper.model_import.drake_parsing import check_inside
from soft_gripper.models import package_map

_PACKAGE_URI_PATTERN = re.compile(r"(?:package|model):/+([^/]+)(?:/(.*))?")


def is_known_package(name: str) -> bool:
    """Whether a mesh is in a package that the parser finds without help."""
    package = name.removeprefix("package://").partition("/")[0]
    return name.startswith("package://") and package_map().Contains(package)


def mesh_file(name: str, model: Path) -> Path:
    """The file behind a mesh name in a URDF or SDFormat file.

    Packages are looked for above the file and along ROS_PACKAGE_PATH and AMENT_PREFIX_PATH: folders with the
    package's name, or with a package.xml that gives it.

    Raises:
        InputError: if there is no such file.
    """
    uri = _PACKAGE_URI_PATTERN.fullmatch(name)
    if uri is None:
        candidates = [Path(os.path.realpath(model.parent)) / name.removeprefix("file://")]
    else:
        package, candidates = uri[1], find_in_packages(name, model)
        if not candidates:
            expected = (
                f"no folder '{package}', and no package.xml of that name, in any folder above the file or along "
                "ROS_PACKAGE_PATH or AMENT_PREFIX_PATH; set ROS_PACKAGE_PATH to the folder that holds the package"
            )
            raise InputError(model, "mesh", name, expected)
    for candidate in candidates:
        if os.path.isfile(candidate):
            return candidate
    raise InputError(model, "mesh", name, f"there is no file {', nor '.join(map(str, candidates))}")


def find_in_packages(uri: str, model: Path) -> list[Path]:
    """Candidate files of a URI of a package; none for a plain name.

    Raises:
        InputError: if it leads out of the package.
    """
    match = _PACKAGE_URI_PATTERN.fullmatch(uri)
    if match is None:
        return []
    package, inside = match.groups()
    check_inside(model, f"package://{package}/{inside or 'package.xml'}")
    package_folders = [Path(package_map().GetPath(package))] if package_map().Contains(package) else []
    return [root / (inside or "") for root in (*package_folders, *_package_roots(package, model))]


def _package_roots(package: str, model: Path) -> Iterator[Path]:
    for folder in _search_path(model):
        if os.path.isdir(folder / package):
            yield folder / package
        if _package_name(folder) == package:
            yield folder


def _search_path(model: Path) -> list[Path]:
    ros, ament = (_folders(variable) for variable in ("ROS_PACKAGE_PATH", "AMENT_PREFIX_PATH"))
    return [*Path(os.path.realpath(model)).parents, *ros, *(folder / "share" for folder in ament)]


def _folders(variable: str) -> list[Path]:
    return [Path(folder) for folder in os.environ.get(variable, "").split(os.pathsep) if folder]


def _package_name(folder: Path) -> str | None:
    """Name of the package in the package.xml of a folder, if it has one."""
    try:
        return (read_xml(folder / "package.xml").findtext("name") or "").strip()
    except InputError:
        return None
