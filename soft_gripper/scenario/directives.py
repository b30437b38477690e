"""Model directives of Drake: models, frames, welds and filters that a plant gets before those of `models`."""

import os
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

from pydrake.multibody.parsing import (
    FlattenModelDirectives,
    ModelDirective,
    ModelDirectives,
    PackageMap,
    Parser,
    ProcessModelDirectives,
)
from pydrake.multibody.plant import MultibodyPlant

from soft_gripper.errors import InputError
from soft_gripper.files.document import require
from soft_gripper.models import package_map
from soft_gripper.scenario.drake_parsing import check_inside, drake_reads
from soft_gripper.scenario.included_files import check_files

_FILE = "file://"
_PACKAGE = "package://"


def parts_with_files(directives: Sequence[ModelDirective]) -> Iterator[Any]:
    """The parts of directives that have a `file`: a model, or further directives."""
    for directive in directives:
        yield from (part for part in (directive.add_model, directive.add_directives) if part is not None)


def add_directives(plant: MultibodyPlant, directives: Sequence[ModelDirective]) -> None:
    """Adds what directives ask for to a plant that is not finalized.

    Raises:
        InputError: naming the directive, if a file is missing, a name is taken or unknown, or Drake refuses it; or if a
            model has a <finger>, which only `models` know.
    """
    if not directives:
        return
    parser = Parser(plant)
    packages = parser.package_map()
    packages.AddMap(package_map())
    flat: list[ModelDirective] = []
    for i, directive in enumerate(directives):
        where, kind = f"directives[{i}]", _kind(directive)
        with drake_reads(where, kind, getattr(getattr(directive, kind), "file", None)):
            located = ModelDirectives(directives=[_located(directive, where, packages)])
            flat += FlattenModelDirectives(located, packages).directives
    for part in parts_with_files(flat):
        _check_model(_path(part.file, "directives", packages), "directives", part.file)
    with drake_reads("scenario", "directives", f"{len(flat)} directives"):  # together: they weld what they have added
        ProcessModelDirectives(ModelDirectives(directives=flat), parser)


def _kind(directive: ModelDirective) -> str:
    """The kind of a directive, such as "add_model"."""
    return next(field.name for field in ModelDirective.__fields__ if getattr(directive, field.name) is not None)


def _located(directive: ModelDirective, where: str, packages: PackageMap) -> ModelDirective:
    """A directive whose file, if it has one, is there and is named by a URI, as Drake wants it."""
    found = ModelDirective(**{field.name: getattr(directive, field.name) for field in ModelDirective.__fields__})
    for name in ("add_model", "add_directives"):
        if (part := getattr(found, name)) is not None:
            path = _path(part.file, where, packages)
            require(path.is_file(), where, "file", part.file, f"there is no file {path}")
            keys = {field.name: getattr(part, field.name) for field in type(part).__fields__}
            uri = part.file if part.file.startswith(_PACKAGE) else f"{_FILE}{os.path.abspath(path)}"
            setattr(found, name, type(part)(**keys | {"file": uri}))
    return found


def _path(file: str, where: str, packages: PackageMap) -> Path:
    if not file.startswith(_PACKAGE):
        return Path(file.removeprefix(_FILE))
    check_inside(where, file)
    package, _, inside = file.removeprefix(_PACKAGE).partition("/")
    if not packages.Contains(package):
        known = ", ".join(packages.GetPackageNames())
        raise InputError(where, "file", file, f"no package '{package}'; known: {known}")
    return Path(packages.GetPath(package)) / inside


def _check_model(path: Path, where: str, file: str) -> None:
    """Checks a file before Drake reads it."""
    require(path.is_file(), where, "file", file, f"there is no file {path}")
    root = check_files(path)
    if root is not None and root.find(".//finger") is not None:
        raise InputError(where, "file", file, "holds a <finger>, which Drake does not know; list the file in `models`")
