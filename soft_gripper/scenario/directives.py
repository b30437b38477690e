"""Model directives of Drake: models, frames, welds and filters that a plant gets before those of `models`."""

import os
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

from pydrake.multibody.parsing import (
    FlattenModelDirectives,
    ModelDirective,
    ModelDirectives,
    Parser,
    ProcessModelDirectives,
)
from pydrake.multibody.plant import MultibodyPlant

from soft_gripper.files.document import load_config, require
from soft_gripper.files.yaml_text import read_yaml
from soft_gripper.model_import.drake_parsing import drake_reads
from soft_gripper.model_import.named_files import check_files
from soft_gripper.models import package_map
from soft_gripper.scenario.drake_values import config_parts
from soft_gripper.scenario.model_files import model_path

_FILE_SCHEME = "file://"
_PACKAGE_SCHEME = "package://"
_MAX_DIRECTIVES = 1000  # of a scenario, those of its files among them
_MAX_DEPTH = 20  # files that add each other
_MAX_BYTES = 300_000  # of these files together: a second of work


def parts_with_files(directives: Sequence[ModelDirective]) -> Iterator[Any]:
    """The parts of directives that have a `file`: a model, or further directives."""
    for directive in directives:
        yield from (part for part in (directive.add_model, directive.add_directives) if part is not None)


def add_directives(plant: MultibodyPlant, directives: Sequence[ModelDirective]) -> None:
    """Adds the models, frames and welds of directives to a plant that is not finalized.

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
    counts: dict[Path, int] = {}
    count = len(directives)
    for i, directive in enumerate(directives):
        where = f"directives[{i}]"
        kind = next(field.name for field in ModelDirective.__fields__ if getattr(directive, field.name) is not None)
        if directive.add_directives is not None:
            count += _count_directives(directive.add_directives.file, where, (), counts)
        require(count <= _MAX_DIRECTIVES, where, "count", count, f"give no more than {_MAX_DIRECTIVES} directives")
        with drake_reads(where, kind, getattr(getattr(directive, kind), "file", None)):
            located = ModelDirectives(directives=[_locate(directive, where)])
            flat += FlattenModelDirectives(located, packages).directives
    for part in parts_with_files(flat):
        path = _path(part.file, "directives")
        require(path.is_file(), "directives", "file", part.file, f"there is no file {path}")
        root = check_files(path)
        has_finger = root is not None and root.find(".//finger") is not None
        expected = "holds a <finger>, which Drake does not know; list the file in `models`"
        require(not has_finger, "directives", "file", part.file, expected)
    with drake_reads("scenario", "directives", f"{len(flat)} directives"):  # together: they weld what they have added
        ProcessModelDirectives(ModelDirectives(directives=flat), parser)


def _count_directives(file: str, where: str, chain: tuple[Path, ...], counts: dict[Path, int]) -> int:
    """Checks a file of directives, and counts them and those of the files that it adds.

    Drake reads such a file without an end if it adds itself, and ends the process. `where` names the file, the `chain`
    of files adds it, and `counts` has the numbers that are known.
    """
    path = Path(os.path.realpath(_path(file, where)))
    require(path not in chain, where, "file", file, "adds itself")
    require(len(chain) < _MAX_DEPTH, where, "file", file, f"lies in {_MAX_DEPTH} files that add each other")
    if path not in counts:
        document = read_yaml(path)
        size = sum(map(os.path.getsize, (*counts, *chain, path)))
        limit = f"makes the files of directives larger than {_MAX_BYTES} bytes"
        require(size <= _MAX_BYTES, where, "file", file, limit)
        require(isinstance(document, dict), path, "file", path.name, "holds no directives")
        load_config(path, document, ModelDirectives)
        directives = document.get("directives", [])
        count = len(directives)
        for i, directive in enumerate(directives):
            require(count <= _MAX_DIRECTIVES, path, "count", count, f"give no more than {_MAX_DIRECTIVES} directives")
            if (added_files := directive.get("add_directives")) is not None:
                inside, name = f"{path}: directives[{i}]", added_files.get("file", "")
                has_scheme = name.startswith((_FILE_SCHEME, _PACKAGE_SCHEME))
                require(has_scheme, inside, "file", name, "give file:///... or package://...")
                count += _count_directives(name, inside, (*chain, path), counts)
        counts[path] = count
    return counts[path]


def _locate(directive: ModelDirective, where: str) -> ModelDirective:
    """Copy of a directive with an absolute URI for its file, as Drake needs it; refuses a missing file."""
    located = ModelDirective(**config_parts(directive))
    for name in ("add_model", "add_directives"):
        if (part := getattr(located, name)) is not None:
            path = _path(part.file, where)
            require(path.is_file(), where, "file", part.file, f"there is no file {path}")
            uri = part.file if part.file.startswith(_PACKAGE_SCHEME) else f"{_FILE_SCHEME}{os.path.abspath(path)}"
            setattr(located, name, type(part)(**config_parts(part) | {"file": uri}))
    return located


def _path(file: str, where: str) -> Path:
    return model_path(file.removeprefix(_FILE_SCHEME), where)
