"""Scenario files: finding them, reading them with `--set` overrides, and writing them out."""

import copy
import os
import re
from collections import OrderedDict
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import is_dataclass, replace
from functools import partial
from operator import eq
from pathlib import Path
from typing import Any, TypeVar, get_type_hints

from pydrake.common.yaml import yaml_dump, yaml_dump_typed, yaml_load_data
from pydrake.visualization import VisualizationConfig

from soft_gripper.cached import get_or_make
from soft_gripper.errors import InputError, suggestion
from soft_gripper.files.document import load_config, require
from soft_gripper.files.text import name_of
from soft_gripper.files.yaml_text import parse_yaml, read_yaml
from soft_gripper.scenario.checks import check_scenario, checked_scenario
from soft_gripper.scenario.directives import parts_with_files
from soft_gripper.scenario.drake_values import plain_values, to_plain_numbers
from soft_gripper.scenario.finger_changes import FINGER_PATHS, FORMER_PATHS
from soft_gripper.scenario.schema import Scenario
from soft_gripper.scenario.shipped import scenario_path

_MAX_KEY_NAMES = 20  # names in the key of an override
_NAME_PATTERN = re.compile(r"\w+")
_T = TypeVar("_T")
# Parts of a scenario that have defaults: null, or nothing below, is as if they were left out.
_DEFAULT_PARTS = {name for name, kind in get_type_hints(Scenario).items() if is_dataclass(kind)}
_ANY_SEED = 31415926535897932  # in a kept text, in the place of the seed of a run
_MOUSE_STIFFNESS = getattr(VisualizationConfig(), "mouse_interaction_stiffness", None)
_MAX_CACHED_TEXTS = 8  # kept, since runs that differ in their seeds have one, and writing it takes 15 ms
_texts: OrderedDict[str, str] = OrderedDict()


def load_scenario(name_or_path: str | Path, overrides: Sequence[str] = ()) -> Scenario:
    """Reads a shipped scenario by its name, or any scenario file by its path.

    Args:
        name_or_path: such as "free_bending", or "my/scenario.yaml".
        overrides: "dotted.key=YAML value", each of which replaces the value in the file.

    Raises:
        InputError: naming file, field and value, if anything is wrong.
    """
    is_list = not isinstance(overrides, str) and isinstance(overrides, Sequence)
    require(is_list, "load_scenario", "overrides", overrides, 'give a list of "dotted.key=value"')
    return _load("--set", name_or_path, dict(map(read_override, overrides)))


def changed_scenario(name_or_path: str | Path, changes: Mapping[str, Any]) -> Scenario:
    """Reads a scenario, with plain data in place of values of the file.

    Args:
        name_or_path: as for `load_scenario`.
        changes: by dotted keys; an entry of a list is counted from 0, or named if it has a name, such as
            "models.gripper.segments".

    Raises:
        InputError: naming file, field and value, if anything is wrong.
    """
    return _load("change", name_or_path, changes)


def _load(where: str, name_or_path: str | Path, changes: Mapping[str, Any]) -> Scenario:
    path = scenario_path(name_of(name_or_path))
    require(isinstance(changes, Mapping), where, "changes", changes, "give values by dotted keys")
    return load_changed(where, path, changes, partial(_read_document, path))


def load_changed(where: str, path: Path, changes: Mapping[str, Any], load: Callable[[dict[str, Any]], _T]) -> _T:
    """Result of `load` for the document in a YAML file with changes by dotted keys, which come from `where`.

    Raises an InputError as `load`, but naming the change that made another field wrong, or if a change has no place.
    """

    def changed(keys: Iterable[str]) -> tuple[dict[str, Any], list[str]]:
        document = _mapping(path, read_yaml(path))
        return document, [_change(where, document, key, changes[key]) for key in keys]

    def mistake_without(key: str) -> tuple[object, str] | None:
        try:
            load(changed(other_key for other_key in changes if other_key != key)[0])
        except InputError as error:
            return error.where, error.field
        return None

    document, fields = changed(changes)
    try:
        return load(document)
    except InputError as error:
        message = str(error).removeprefix(f"{path}: ")
        wrong_names = _NAME_PATTERN.findall(message.partition(" = ")[0])
        changed_names = map(_NAME_PATTERN.findall, fields)  # one name is below another if they begin alike
        if not any(all(map(eq, wrong_names, names)) for names in changed_names):
            for key, value in changes.items():
                if mistake_without(key) != (error.where, error.field):
                    raise InputError(path, key, value, f"contradicts {message}") from None
        raise


def parse_scenario(path: Path, text: str) -> Scenario:
    """Reads a scenario from its text in a recording at `path`, of 0.2 or later; raises as `load_scenario`."""
    return _read_document(path, _with_current_keys(_mapping(path, parse_yaml(path, text))))


def _with_current_keys(document: dict[str, Any]) -> dict[str, Any]:
    """A document whose changes of fingers may have the keys of 0.2."""
    models, nominal = document.get("models"), document.get("nominal")
    for model in models if isinstance(models, list) else ():
        fingers = model.get("fingers") if isinstance(model, dict) else None
        for changes in fingers.values() if isinstance(fingers, dict) else ():
            for key in FORMER_PATHS.keys() & changes if isinstance(changes, dict) else ():
                changes[FORMER_PATHS[key]] = changes.pop(key)
    if isinstance(nominal, dict):
        changes = {key: nominal.pop(key) for key in FINGER_PATHS.keys() & nominal}
        document["nominal"] = nominal | ({"finger": changes} if changes else {})
    return document


def _read_document(path: Path, document: dict[str, Any]) -> Scenario:
    document = {name: part for name, part in document.items() if part is not None or name not in _DEFAULT_PARTS}
    scenario = load_config(path, document, Scenario)
    for part, field in _files(scenario):
        setattr(part, field, os.path.realpath(path.parent / getattr(part, field)))
    check_scenario(path, scenario)
    return scenario


def _files(scenario: Scenario) -> list[tuple[Any, str]]:
    """The parts of a scenario that name a file by its path, and the field of the name."""
    parts = [*scenario.models, *parts_with_files(scenario.directives), scenario.nominal]
    named_files = [*((part, "file") for part in parts), (scenario.nominal, "calibration"), (scenario, "bench")]
    files = ((part, field, getattr(part, field)) for part, field in named_files)
    return [(part, field) for part, field, file in files if file is not None and "://" not in file]


def files_read(name_or_path: str | Path, scenario: Scenario) -> list[str]:
    """Files of a scenario, its own first, without those that ship with the package."""
    return [str(name_or_path), *(getattr(part, field) for part, field in _files(scenario))]


def dump_scenario(scenario: Scenario, folder: Path | None = None) -> str:
    """The resolved scenario as YAML: every field that is not None, in a form that all supported Drakes read.

    Paths are relative to `folder`, where the text will be stored; without one they are absolute.
    """
    seed = checked_scenario("scenario", scenario).sensor.seed
    scenario = replace(scenario, sensor=replace(scenario.sensor, seed=_ANY_SEED))
    if folder is not None:
        scenario = copy.deepcopy(scenario)
        for part, field in _files(scenario):
            setattr(part, field, os.path.relpath(getattr(part, field), folder.resolve()))
    text = get_or_make(_texts, repr(plain_values(scenario)), lambda: _dump_text(scenario), _MAX_CACHED_TEXTS)
    return text.replace(f"seed: {_ANY_SEED}\n", f"seed: {seed}\n")


def _dump_text(scenario: Scenario) -> str:
    document = yaml_load_data(yaml_dump_typed(scenario))
    document["simulator_config"].pop("publish_every_time_step", None)  # gone from newer Drakes
    view = document.get("visualization") or {}
    if "mouse_interaction_stiffness" in view and view["mouse_interaction_stiffness"] == _MOUSE_STIFFNESS:
        del view["mouse_interaction_stiffness"]  # the default, unknown to older Drakes
    return yaml_dump(document)


def _mapping(path: Path, document: Any) -> dict[str, Any]:
    if not isinstance(document, dict):
        raise InputError(path, "file", path.name, "holds no mapping of fields to values")
    return document


def read_override(override: str) -> tuple[str, Any]:
    """Key and value of "a.b=c"."""
    require(isinstance(override, str), "--set", "argument", override, "give text, such as sensor.sections=3")
    key, equals, text = override.partition("=")
    if not equals or not key:
        raise InputError("--set", "argument", override, "write key=value, such as sensor.sections=3")
    try:
        return key, parse_yaml("--set", f"value: {text}")["value"]
    except InputError as error:
        raise InputError("--set", key, text, error.expected) from None


def _change(where: str, document: dict[str, Any], key: str, value: Any) -> str:
    """Puts a copy of a value into a document; returns the keys and indices that lead to it, with dots."""
    try:
        if not isinstance(key, str):
            raise LookupError("give names with dots between them, as text")
        *parents, last = key.split(".")
        if len(parents) >= _MAX_KEY_NAMES:
            raise LookupError(f"give no more than {_MAX_KEY_NAMES} names")
        node: Any = document
        path = list[Any]()
        for i, name in enumerate(parents):
            if isinstance(node, dict) and (dotted := key.split(".", i)[i]) in node:  # such as contact.friction
                last = dotted
                break
            path.append(name if isinstance(node, dict) else _index(node, name))
            node = node.setdefault(name, {}) if isinstance(node, dict) else node[path[-1]]
        path.append(last if isinstance(node, dict) else _index(node, last))
        node[path[-1]] = copy.deepcopy(to_plain_numbers(value))
    except LookupError as error:
        raise InputError(where, "key", key, str(error.args[0])) from None
    return ".".join(map(str, path))


def _index(node: Any, name: str) -> int:
    """Index of the entry of a list with a name or number; raises a LookupError if there is none."""
    if not isinstance(node, list):
        raise LookupError(f"nothing lies below: there is no '{name}'")
    names = [str(entry["name"]) for entry in node if isinstance(entry, dict) and "name" in entry]
    if len(names) == len(node) and names.count(name) == 1:
        return names.index(name)
    if name.isascii() and name.isdecimal() and len(name) < 10 and int(name) < len(node):
        return int(name)
    name_hint = f", or a name; {suggestion(name, names)}" if names else ""
    raise LookupError(f"there is no entry '{name}': give a number from 0 to {len(node) - 1}{name_hint}")
