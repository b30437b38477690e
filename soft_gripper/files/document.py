"""Plain data compared with a schema of dataclasses: types, ranges of numbers, names that become signals and files."""

import difflib
import math
import re
from pathlib import Path
from types import NoneType, UnionType
from typing import Any, get_args, get_origin, get_type_hints

from pydrake.common.schema import Transform

from soft_gripper.errors import InputError


def require(fine: bool, where: Path | str, field: str, value: object, expected: str) -> None:
    """Raises an InputError unless `fine`."""
    if not fine:
        raise InputError(where, field, value, expected)


def positive(value: float) -> bool:
    """Finite and above zero."""
    return math.isfinite(value) and value > 0


def not_negative(value: float) -> bool:
    """Finite and not below zero."""
    return math.isfinite(value) and value >= 0


_TAG = "_tag"  # key under which Drake keeps a tag of YAML
_PRIMITIVES = {float: "a number", int: "a whole number", bool: "true or false", str: "text"}
_LEAST, _MOST = 1e-15, 1e15  # of the size of a number that is not 0; beyond, what follows from it leaves the range
_MOST_WHOLE = 2**32 - 1  # of Drake's seeds


def check_document(where: Path | str, value: Any, schema: Any, field: str = "") -> None:
    """Compares the data of a YAML file, plain or as objects, with a schema of dataclasses and Drake's configs.

    Raises:
        InputError: for an unknown key, with the nearest known one, or a value of the wrong type.
    """
    # X | None; from Python 3.14 on the unions of Drake's configs are of that type too.
    if get_origin(schema) is UnionType and NoneType in get_args(schema) and len(get_args(schema)) == 2:
        if value is not None:
            (inner,) = (part for part in get_args(schema) if part is not NoneType)
            check_document(where, value, inner, field)
    elif schema in _PRIMITIVES:
        if not _converts(value, schema):
            raise InputError(where, field, value, f"give {_PRIMITIVES[schema]}")
        _check_range(where, value, schema, field)
    elif get_origin(schema) is list:
        if not isinstance(value, list):
            raise InputError(where, field, value, "give a list")
        for i, item in enumerate(value):
            check_document(where, item, get_args(schema)[0], f"{field}[{i}]")
    elif get_origin(schema) is dict:
        for key, item in _mapping(where, value, field).items():
            require(key != _TAG, where, field, value, "give a mapping without a tag")
            check_document(where, item, get_args(schema)[1], f"{field}.{key}")
    elif schema is Transform and isinstance(value, Transform):
        pass  # which Drake has checked, where it was made
    elif fields := _fields(schema):
        document = _attributes(value) if isinstance(value, schema) else _mapping(where, value, field)
        for key, item in document.items():
            name = f"{field}.{key}" if field else str(key)
            if key not in fields:
                near = difflib.get_close_matches(str(key), fields, n=1)
                hint = f"did you mean '{near[0]}'?" if near else f"known: {', '.join(fields)}"
                raise InputError(where, name, item, f"no such key; {hint}")
            check_document(where, item, fields[key], name)
        if schema is Transform and isinstance(value, dict):
            _check_transform(where, value, field)


def _check_range(where: Path | str, value: Any, schema: type, field: str) -> None:
    size = abs(float(value)) if schema in (float, int) else 0.0
    if schema is float:
        expected = f"give a finite number: 0, or {_LEAST:g} to {_MOST:g} in size"
        require(size == 0 or _LEAST <= size <= _MOST, where, field, value, expected)
    require(schema is not int or size <= _MOST_WHOLE, where, field, value, f"give a number up to {_MOST_WHOLE}")


def _check_transform(where: Path | str, value: dict[str, Any], field: str) -> None:
    """Poses are known: no random ones, and none in a frame that Drake would leave aside here."""
    base = value.get("base_frame")
    require(base is None, where, f"{field}.base_frame", base, "leave it out; `parent` of a model names a frame")
    _check_three(where, value.get("translation", [0, 0, 0]), f"{field}.translation", "give three numbers, m")
    rotation, expected = value.get("rotation", {}), "write !Rpy { deg: [roll, pitch, yaw] }"
    empty = rotation == {}
    tagged = isinstance(rotation, dict) and rotation.keys() == {_TAG, "deg"} and rotation[_TAG] == "!Rpy"
    require(empty or tagged, where, f"{field}.rotation", rotation, expected)
    if tagged:
        _check_three(where, rotation["deg"], f"{field}.rotation.deg", expected)


def _check_three(where: Path | str, value: Any, field: str, expected: str) -> None:
    fits = isinstance(value, list) and len(value) == 3 and all(_converts(number, float) for number in value)
    require(fits, where, field, value, expected)
    for i, number in enumerate(value):
        _check_range(where, number, float, f"{field}[{i}]")


def _mapping(where: Path | str, value: Any, field: str) -> dict[str, Any]:
    if not isinstance(value, dict):
        raise InputError(where, field, value, "give a mapping of keys to values")
    return value


def _attributes(config: Any) -> dict[str, Any]:
    return {name: getattr(config, name) for name in _fields(type(config))}


def _fields(schema: Any) -> dict[str, Any]:
    if hasattr(schema, "__dataclass_fields__"):
        return get_type_hints(schema)
    return {field.name: field.type for field in getattr(schema, "__fields__", ())}


def _converts(value: Any, schema: type) -> bool:
    if isinstance(value, bool):
        return schema is bool
    if schema in (float, int):
        try:
            return schema(value) == float(value) or math.isnan(float(value))
        except (TypeError, ValueError, OverflowError):
            return False
    return isinstance(value, schema)


NAME_RULE = "give a name of up to 60 letters (a to z), digits, _ and -, a letter first"
_NAME = re.compile(r"[A-Za-z][A-Za-z0-9_-]{0,59}")


def is_name(text: str) -> bool:
    """Whether a text can name a part of a scenario."""
    return _NAME.fullmatch(text) is not None
