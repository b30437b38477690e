"""Files that model files name: meshes, and models that include each other, within limits for all of them together."""

import os
import re
import xml.etree.ElementTree as ET
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from soft_gripper.errors import InputError
from soft_gripper.files.xml_text import MAX_CHARACTERS, MAX_ELEMENTS, read_xml
from soft_gripper.model_import.drake_parsing import check_file, check_inside
from soft_gripper.models import package_map

_PACKAGE_URI_PATTERN = re.compile(r"(?:package|model):/+([^/]+)(?:/(.*))?")
_MAX_DEPTH = 10  # files inside each other
_MAX_FILES = 500  # more than the largest models have, and read within a second


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
    """Candidate files of a URI of a package, none for a plain name; raises an InputError if it leads out of it."""
    match = _PACKAGE_URI_PATTERN.fullmatch(uri)
    if match is None:
        return []
    package, inside = match.groups()
    check_inside(model, f"package://{package}/{inside or 'package.xml'}")
    package_folders = [Path(package_map().GetPath(package))] if package_map().Contains(package) else []
    return [root / (inside or "") for root in (*package_folders, *_package_roots(package, model))]


def _package_roots(package: str, model: Path) -> Iterator[Path]:
    variables = ("ROS_PACKAGE_PATH", ""), ("AMENT_PREFIX_PATH", "share")
    folders = [*Path(os.path.realpath(model)).parents]
    for variable, inside in variables:
        folders += [Path(folder, inside) for folder in os.environ.get(variable, "").split(os.pathsep) if folder]
    for folder in folders:
        if os.path.isdir(folder / package):
            yield folder / package
        try:
            name = (read_xml(folder / "package.xml").findtext("name") or "").strip()
        except InputError:
            continue
        if name == package:
            yield folder


class IncludedFiles:
    """Reader of the files that a model includes, directly or through others, within limits."""

    def __init__(self, path: Path, root: ET.Element):
        self._chain = [path]  # files that are being read, the model's own first
        self._elements = sum(1 for _ in root.iter())
        self._count = self._characters = 0

    @contextmanager
    def read(self, field: str, name: str, file: Path) -> Iterator[ET.Element]:
        """Reads the root of a file; files read within the context are included in it.

        `field` and `name` are those in the including file. Raises an InputError if the file cannot be read, is among
        those that include it, or is one too many or too large.
        """
        place, chain = self._chain[-1], [*self._chain, file]
        if not os.path.isfile(file):
            raise InputError(place, field, name, f"there is no file {file}")
        if any(os.path.realpath(file) == os.path.realpath(path) for path in self._chain):
            names = " > ".join(path.name for path in chain)
            raise InputError(place, field, name, f"leave it out: the file would be inside itself: {names}")
        if len(self._chain) > _MAX_DEPTH:
            raise InputError(place, field, name, f"lies in more than {_MAX_DEPTH} files that include each other")
        self._count += 1
        if self._count > _MAX_FILES:
            raise InputError(place, field, name, f"is one of more than {_MAX_FILES} included files; include fewer")
        root = read_xml(file)
        self._elements += sum(1 for _ in root.iter())
        self._characters += os.path.getsize(file)
        if self._elements > MAX_ELEMENTS or self._characters > MAX_CHARACTERS:
            limit = f"{MAX_ELEMENTS} elements or {MAX_CHARACTERS} characters"
            raise InputError(place, field, name, f"makes a model of more than {limit}; include fewer files")
        self._chain = chain
        yield root
        self._chain = chain[:-1]


def check_files(path: Path) -> ET.Element | None:
    """Checks a file that Drake is to read unchanged, and all that it includes; returns and raises as `check_file`."""
    root = check_file(path)
    if root is not None:
        _check_included(path, path.parent, root, IncludedFiles(path, root))
    return root


def _check_included(path: Path, folder: Path, parent: ET.Element, files: IncludedFiles) -> None:
    for include in parent.iter("include"):
        if (name := include.get("file")) is not None:
            field, file = "include.file", folder / name
        else:
            field, (name, file) = "include.uri", sdf_file(path, include)
        with files.read(field, name, file) as included:
            check_file(file)
            _check_included(file, folder, included, files)


def sdf_file(path: Path, include: ET.Element) -> tuple[str, Path]:
    """The URI of an <include>, perhaps of a model's folder, and its file; raises an InputError if there is none."""
    uri = (include.findtext("uri") or "").strip()
    neighbor = Path(os.path.realpath(path.parent)) / uri.removeprefix("file://")
    folders = [folder for folder in (neighbor, *find_in_packages(uri, path)) if os.path.isdir(folder)]
    if not folders:
        try:
            return uri, mesh_file(uri, path)
        except InputError as error:
            raise InputError(path, "include.uri", uri, error.expected) from None
    names = [(sdf.text or "").strip() for sdf in read_xml(folders[0] / "model.config").findall("sdf")]
    if not names or not os.path.isfile(folders[0] / names[-1]):
        raise InputError(folders[0] / "model.config", "sdf", ", ".join(names), "names no file of the model")
    return uri, folders[0] / names[-1]
