"""Drake's configs as values: dataclasses that hold them can be pickled and compared."""

import copyreg
from collections.abc import Mapping
from dataclasses import fields, is_dataclass, replace
from typing import Any

import numpy as np
from pydrake.common.schema import Rotation, Transform
from pydrake.geometry import Rgba
from pydrake.multibody import parsing
from pydrake.multibody.plant import MultibodyPlantConfig
from pydrake.systems.analysis import SimulatorConfig
from pydrake.visualization import VisualizationConfig

_DIRECTIVE_KINDS = ("AddCollisionFilterGroup", "AddDirectives", "AddFrame", "AddModel", "AddModelInstance", "AddWeld")


class ByValue:
    """Compares equal if all its fields do; Drake's own configs are equal to nothing but themselves."""

    def __eq__(self, other: object) -> bool:
        return type(self) is type(other) and plain_values(self) == plain_values(other)

    __hash__ = None  # type: ignore[assignment]


def plain_values(value: Any) -> Any:
    """A value as lists and mappings, which can be compared and do not change when it does."""
    if is_dataclass(value):
        return {field.name: plain_values(getattr(value, field.name)) for field in fields(value)}
    if hasattr(value, "__fields__"):
        return type(value), {name: plain_values(part) for name, part in config_parts(value).items()}
    if isinstance(value, np.ndarray):
        return value.tolist()
    if isinstance(value, Mapping):
        return {key: plain_values(item) for key, item in value.items()}
    return [plain_values(item) for item in value] if isinstance(value, list | tuple) else value


def to_plain_numbers(value: Any) -> Any:
    """A value, or a copy with Python's numbers and lists in place of NumPy's."""
    if isinstance(value, np.generic | np.ndarray):
        return value.tolist()
    if isinstance(value, tuple | list):
        return [to_plain_numbers(item) for item in value]
    if isinstance(value, Mapping):
        return {key: to_plain_numbers(item) for key, item in value.items()}
    if is_dataclass(value) and not isinstance(value, type):
        return replace(value, **{field.name: to_plain_numbers(getattr(value, field.name)) for field in fields(value)})
    return value


def config_parts(config: Any) -> dict[str, Any]:
    return {field.name: getattr(config, field.name) for field in config.__fields__}


def _make_config(kind: type, parts: Mapping[str, Any]) -> Any:
    config = kind()
    for name, part in parts.items():
        setattr(config, name, part)
    return config


for _kind in (
    *(Transform, Rotation, Rotation.Identity, Rotation.Rpy, Rotation.AngleAxis, Rotation.Uniform),
    *(MultibodyPlantConfig, SimulatorConfig, VisualizationConfig, Rgba),
    *(parsing.ModelDirective, *(getattr(parsing, name) for name in _DIRECTIVE_KINDS)),
):
    copyreg.pickle(_kind, lambda config: (_make_config, (type(config), config_parts(config))))
