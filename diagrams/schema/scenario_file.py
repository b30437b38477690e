"""Scenario files: finding them, reading them with `--set` overrides, and writing them out."""

import copy
import os
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from pydrake.common.yaml import yaml_dump, yaml_dump_typed, yaml_load_data, yaml_load_typed

from soft_gripper.diagrams.schema.document_check import check_document
from soft_gripper.diagrams.schema.ranges import require
from soft_gripper.diagrams.schema.scenario import Scenario
from soft_gripper.diagrams.schema.scenario_checks import check_scenario
from soft_gripper.diagrams.schema.yaml_text import parse_yaml, read_yaml
from soft_gripper.errors import InputError

SHIPPED = Path(__file__).parents[1] / "scenarios"
_DEEPEST = 20  # names in the key of an override


def scenario_names() -> list[str]:
    """Names of the shipped scenarios."""
    return sorted(path.stem for path in SHIPPED.glob("*.yaml"))


def load_scenario(name_or_path: str, overrides: Sequence[str] = ()) -> Scenario:
    """Reads a shipped scenario by its name, or any scenario file by its path.

    Args:
        name_or_path: such as "free_bending", or "my/scenario.yaml".
        overrides: "dotted.key=YAML value", each in the place of what the file says.

    Raises:
        InputError: naming file, field and value, if anything is wrong.
    """
    path = _find(name_or_path)
    document = _mapping(path, read_yaml(path))
    for override in overrides:
        _apply(document, override)
    return _checked(path, document)


def parse_scenario(path: Path, text: str) -> Scenario:
    """Reads a scenario from the text that a recording at `path` keeps of it; raises as `load_scenario`."""
    return _checked(path, _mapping(path, parse_yaml(path, text)))


def _checked(path: Path, document: dict[str, Any]) -> Scenario:
    _quote_numbers(document.get("believed"))
    check_document(path, document, Scenario)
    try:
        scenario: Scenario = yaml_load_typed(schema=Scenario, data=yaml_dump(document), retain_map_defaults=False)
    except (RuntimeError, ValueError, TypeError) as error:
        raise InputError(path, "scenario", path.stem, " ".join(str(error).split())) from None
    check_scenario(path, scenario)
    for part, field in _files(scenario):
        setattr(part, field, os.path.realpath(path.parent / getattr(part, field)))
    return scenario


def _files(scenario: Scenario) -> list[tuple[Any, str]]:
    """The parts of a scenario that name a file by its path, and the field in which they do."""
    named = [*((m, "file") for m in scenario.models), (scenario.believed, "file"), (scenario.believed, "calibration")]
    found = ((part, field, getattr(part, field)) for part, field in named)
    return [(part, field) for part, field, file in found if file is not None and not file.startswith("package://")]


def _quote_numbers(changes: Any) -> None:
    """Makes text of numbers where either is meant, in the beliefs."""
    for key, value in changes.items() if isinstance(changes, dict) else ():
        if isinstance(value, int | float) and not isinstance(value, bool):
            changes[key] = repr(value)


def dump_scenario(scenario: Scenario, folder: Path | None = None) -> str:
    """The resolved scenario as YAML: every field that is not None, in a form that every Drake reads.

    Paths are relative to `folder`, where the text is to be kept; absolute without one.
    """
    scenario = copy.deepcopy(scenario)
    if folder is not None:
        for part, field in _files(scenario):
            setattr(part, field, os.path.relpath(getattr(part, field), folder.resolve()))
    document = yaml_load_data(yaml_dump_typed(scenario))
    document["simulator_config"].pop("publish_every_time_step", None)  # gone from newer Drakes
    text: str = yaml_dump(document)
    return text


def _find(name_or_path: str) -> Path:
    if name_or_path.endswith((".yaml", ".yml")):
        return Path(name_or_path)
    path = SHIPPED / f"{name_or_path}.yaml"
    if name_or_path not in scenario_names():
        raise InputError("scenario", "name", name_or_path, f"not shipped; known: {', '.join(scenario_names())}")
    return path


def _mapping(path: Path, document: Any) -> dict[str, Any]:
    if not isinstance(document, dict):
        raise InputError(path, "file", path.name, "holds no mapping of fields to values")
    return document


def _apply(document: dict[str, Any], override: str) -> None:
    """Puts the value of "a.b=c" into the document; a number between the dots counts along a list."""
    key, equals, text = override.partition("=")
    if not equals or not key:
        raise InputError("--set", "argument", override, "write key=value, such as sensor.sections=3")
    try:
        value = parse_yaml("--set", f"value: {text}")["value"]
    except InputError as error:
        raise InputError("--set", key, text, error.expected) from None
    *parents, last = key.split(".")
    require(len(parents) < _DEEPEST, "--set", "argument", override, f"give no more than {_DEEPEST} names")
    place: Any = document
    for name in parents:
        place = _step_into(place, name, override)
    _assign(place, last, copy.deepcopy(value), override)


def _step_into(place: Any, name: str, override: str) -> Any:
    if isinstance(place, list):
        return place[_index(place, name, override)]
    if not isinstance(place, dict):
        raise InputError("--set", "argument", override, f"nothing lies below '{name}'")
    return place.setdefault(name, {})


def _assign(place: Any, name: str, value: Any, override: str) -> None:
    if isinstance(place, list):
        place[_index(place, name, override)] = value
    elif isinstance(place, dict):
        place[name] = value
    else:
        raise InputError("--set", "argument", override, f"nothing lies below '{name}'")


def _index(place: list[Any], name: str, override: str) -> int:
    known = map(str, range(len(place)))
    if name not in known:
        raise InputError("--set", "argument", override, f"'{name}' is none of the entries 0 to {len(place) - 1}")
    return int(name)
