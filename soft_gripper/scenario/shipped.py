"""Shipped scenarios and presets of sensor errors, found by name without Drake, so that commands answer quickly."""

from functools import cache
from pathlib import Path
from typing import Any

import yaml

from soft_gripper.errors import InputError, suggestion

SHIPPED = Path(__file__).parents[1] / "diagrams" / "scenarios"
_OF_EXTRAS = Path(__file__).parents[1] / "extras"
PRESETS = Path(__file__).with_name("sensor_presets.yaml")
_YAML_LOADER = getattr(yaml, "CBaseLoader", yaml.BaseLoader)  # libyaml, where PyYAML has it, is ten times as fast


def scenario_names() -> list[str]:
    """Names of the shipped scenarios."""
    return sorted(_files())


def scenario_path(name_or_path: str) -> Path:
    """The file of a shipped scenario, or the path itself; raises an InputError if no such scenario is shipped."""
    if name_or_path.endswith((".yaml", ".yml")):
        return Path(name_or_path)
    if Path(name_or_path).is_file():
        raise InputError("scenario", "file", name_or_path, "must be a YAML file, *.yaml")
    if name_or_path not in scenario_names():
        raise InputError("scenario", "name", name_or_path, f"not shipped; {suggestion(name_or_path, scenario_names())}")
    return _files()[name_or_path]


@cache  # as of the extras: looking for files takes long, and every run of a sweep asks
def _files() -> dict[str, Path]:
    """The shipped scenarios by name, those of extras among them."""
    return {path.stem: path for path in (*SHIPPED.glob("*.yaml"), *_OF_EXTRAS.glob("*/scenarios/*.yaml"))}


def descriptions() -> dict[str, str]:
    return {name: _read_shipped(scenario_path(name))["description"] for name in scenario_names()}


def _read_shipped(file: Path) -> dict[str, Any]:
    """Data of a shipped file, with text for every value."""
    return yaml.load(file.read_text(encoding="utf-8"), Loader=_YAML_LOADER)
