"""Configurations compared with their schema of dataclasses: types, and the rules beside the fields (`quantity.py`)."""

import math
import re
from collections import OrderedDict
from copy import deepcopy
from dataclasses import is_dataclass
from functools import cache
from numbers import Integral, Real
from pathlib import Path
from types import NoneType, UnionType
from typing import Any, TypeVar, Union, get_args, get_origin, get_type_hints

import numpy as np
from pydrake.common.schema import Transform
from pydrake.common.yaml import yaml_dump, yaml_load_typed
from pydrake.multibody.parsing import ModelDirective

from soft_gripper.cached import kept
from soft_gripper.errors import InputError, did_you_mean, is_near, meant, near_names
from soft_gripper.extras import added
from soft_gripper.files.number import is_number
from soft_gripper.quantity import Rule, misfits, rules

_T = TypeVar("_T")


def require(fine: bool, where: Path | str, field: str, value: object, expected: str) -> None:
    """Raises an InputError unless `fine`."""
    if not fine:
        raise InputError(where, field, value, expected)


def given(value: _T | None, where: Path | str, field: str, expected: str) -> _T:
    """A value that is required; raises an InputError if it is None."""
    if value is None:
        raise InputError(where, field, None, expected)
    return value


_TAG = "_tag"  # key under which Drake keeps a tag of YAML
_PRIMITIVES: dict[object, tuple[type, str]] = {
    float: (Real, "a number"),
    int: (Integral, "a whole number"),
    bool: (bool, "true or false"),
    str: (str, "text"),
}
_MOST_WHOLE = 2**32 - 1  # of Drake's seeds
_ANY, _FRAMED = Rule(), Rule(framed=True)


def load_config(path: Path, document: Any, schema: type[_T], retain_map_defaults: bool = True) -> _T:
    """The configuration that plain data from a YAML file describe.

    Raises:
        InputError: naming file, field and value, if the data do not fit the schema or its rules.
    """
    check_document(path, document, schema)
    kind: Any = schema
    try:
        found: _T = _filled(kind(), document, retain_map_defaults)
    except (RuntimeError, ValueError, TypeError) as error:
        raise InputError(path, "file", path.name, " ".join(str(error).split())) from None
    _check_misfits(path, found)
    return found


def _filled(config: Any, document: dict[str, Any], retain_map_defaults: bool) -> Any:
    """A dataclass whose fields are set from plain data, in its own order, as Drake does."""
    schema: Any = type(config)
    for name, kind in _fields(schema).items():
        if name in document:
            setattr(config, name, _field(config, name, kind, document[name], retain_map_defaults))
    return config


_MOST_PARTS = 128  # kept, since runs of a sweep differ in a few, and reading the YAML of a scenario takes 4 ms
_parts: OrderedDict[tuple[type, str, str, bool], Any] = OrderedDict()


def _field(config: Any, name: str, schema: Any, value: Any, retain_map_defaults: bool) -> Any:
    """The value of a field of a dataclass that plain data describe; what is not of its type yet, Drake converts."""
    _, kind, inner = _taken_apart(schema)
    if kind in _PRIMITIVES and type(value) is kind:
        return value
    if is_dataclass(kind) and isinstance(value, dict):
        default = getattr(config, name)
        return _filled(kind() if default is None else deepcopy(default), value, retain_map_defaults)  # type: ignore[operator]
    if kind is dict and Any in (inner, *get_args(inner)):  # plain data, as they are
        return value
    if kind is list and is_dataclass(inner) and all(isinstance(each, dict) for each in value):
        return [_filled(inner(), each, retain_map_defaults) for each in value]  # type: ignore[operator]

    def load() -> Any:
        data = yaml_dump({name: value})
        return getattr(yaml_load_typed(schema=type(config), data=data, retain_map_defaults=retain_map_defaults), name)

    return deepcopy(kept(_parts, (type(config), name, repr(value), retain_map_defaults), load, _MOST_PARTS))


def check_config(where: Path | str, config: Any) -> None:
    """Checks a dataclass made in Python, and all that it contains; NumPy numbers count as numbers.

    Raises:
        InputError: for the first field that has another type, is out of range, or contradicts another one.
    """
    check_document(where, config, type(config))
    _check_misfits(where, config)


def _check_misfits(where: Path | str, config: Any, field: str = "") -> None:
    """Checks the rules across fields of a dataclass, and of those inside it; the fields themselves are valid."""
    if isinstance(config, list | tuple | dict):
        for key, part in config.items() if isinstance(config, dict) else enumerate(config):
            _check_misfits(where, part, f"{field}.{key}" if isinstance(config, dict) else f"{field}[{key}]")
    elif is_dataclass(config):
        kind: Any = type(config)
        for name in _fields(kind):
            part = getattr(config, name)
            if not isinstance(part, float | int | str | None):
                _check_misfits(where, part, _below(field, name))
        for name, value, expected in misfits(config):
            raise InputError(where, _below(field, name), value, expected)


class _UnknownKeyError(InputError):
    """A key that a part of a schema does not have, nor one spelt like it; `expected` lists those that it has."""


def check_document(
    where: Path | str, value: Any, schema: Any, field: str = "", rule: Rule = _ANY, strict: bool = False
) -> None:
    """Compares data with a schema of dataclasses and Drake's configs.

    Args:
        where: file or part, for messages.
        value: plain data, as from a YAML file, in which defaults may be left out, or objects.
        schema: the type that it must have.
        field: its place, with dots.
        rule: of that field.
        strict: whether numbers given as text, as YAML reads 1e3, are refused.

    Raises:
        InputError: for an unknown key, with the one that was meant, a value of another type, or one that breaks a rule.
    """
    try:
        _check(where, value, schema, field, rule, strict)
    except _UnknownKeyError as error:
        others = [what for name, what in _kinds_of_documents().items() if name in value and name not in _fields(schema)]
        if others:
            raise InputError(where, error.field, error.value, f"no such key; this seems to be {others[0]}") from None
        hint = did_you_mean(_suggested_places(schema, error.field, error.value)) or f"known: {error.expected}"
        raise InputError(where, error.field, error.value, f"no such key; {hint}") from None


def _kinds_of_documents() -> dict[str, str]:
    """Kinds of documents, by a key that only they have: a scenario, and those that extras declare in `DOCUMENTS`."""
    return {"models": "a scenario"} | {key: what for declared in added("DOCUMENTS") for key, what in declared.items()}


def _suggested_places(schema: Any, field: str, value: Any) -> list[str]:
    """Where a schema has the last key of an unknown field, a key near it, or else the keys below it; not many places.

    Those in the part of the document that has the field come alone.
    """
    key, part, places = field.rpartition(".")[2], _PART.match(field), _places(schema)
    below = [name for name in value if name in places] if isinstance(value, dict) else []
    for names in ([key] if key in places else [], near_names(key, places), below):
        found = [place for name in names for place in places[name]]
        beside = [place for place in found if part and place.startswith(part[0])]
        if 0 < len(beside or found) <= _MAX_PLACES:
            return beside or found
    return []


_MAX_PLACES = 4  # that are suggested: a key in more, such as a name, says little
_PART = re.compile(r"[^.[]+(?=[.[])")  # the first key of several


@cache
def _places(schema: Any, deepest: int = 4) -> dict[str, list[str]]:
    """Where a schema has each key, with dots; an entry of a list or mapping is NAME."""
    _, kind, inner = _taken_apart(schema)
    if kind in (list, tuple, dict):
        return {key: [f"NAME.{place}" for place in places] for key, places in _places(inner, deepest).items()}
    fields = _fields(kind) if deepest else {}
    found = {name: [name] for name in fields}
    for name, part in fields.items():
        for key, places in _places(part, deepest - 1).items():
            found.setdefault(key, []).extend(f"{name}.{place}" for place in places)
    return found


def _check(where: Path | str, value: Any, schema: Any, field: str, rule: Rule, strict: bool) -> None:
    is_optional, kind, inner = _taken_apart(schema)
    if value is None and is_optional:
        return
    if kind in _PRIMITIVES:
        _check_entry(where, value, kind, field, rule, strict)
    elif kind in (list, tuple):
        if not isinstance(value, list | kind):
            raise InputError(where, field, value, "must be a list")
        for i, item in enumerate(value):
            _check(where, item, inner, f"{field}[{i}]", rule, strict)
        _must(rule.of_group(value), where, field, value)
    elif kind is dict:
        for key, item in _mapping(where, value, field).items():
            require(key != _TAG, where, field, value, "must be a mapping without a tag")
            _check(where, item, inner, f"{field}.{key}", rule, strict)
        _must(rule.of_group(value), where, field, value)
    elif kind is Transform and isinstance(value, Transform):
        _must(None if _is_finite(value) else "must be a pose of finite numbers", where, field, value)
    elif kind is np.ndarray:
        _check(where, value.tolist() if isinstance(value, np.ndarray) else value, list[float], field, rule, strict)
    elif fields := _fields(kind):
        rule = _FRAMED if kind is ModelDirective else rule
        _check_fields(where, value, kind, fields, field, rule, strict)


@cache
def _taken_apart(schema: Any) -> tuple[bool, Any, Any]:
    """Whether a type may be None, what it is otherwise, and the type of the entries of a list or mapping."""
    parts = get_args(schema)
    if get_origin(schema) in (UnionType, Union) and NoneType in parts and len(parts) == 2:
        return True, *_taken_apart(*(part for part in parts if part is not NoneType))[1:]
    return False, get_origin(schema) or schema, parts[-1 if get_origin(schema) is dict else 0] if parts else None


def _check_fields(
    where: Path | str, value: Any, schema: Any, fields: dict[str, Any], field: str, rule: Rule, strict: bool
) -> None:
    is_object, is_own = isinstance(value, schema), hasattr(schema, "__dataclass_fields__")
    document = {name: getattr(value, name) for name in fields} if is_object else _mapping(where, value, field)
    known = rules(schema) if is_own else rule.parts
    for key, item in document.items():
        name = _below(field, key)
        if key not in fields:
            if is_near(key, fields):
                raise InputError(where, name, item, f"no such key; {meant(key, fields)}")
            raise _UnknownKeyError(where, name, item, ", ".join(fields))
        _check(where, item, fields[key], name, known.get(key, _FRAMED if rule.framed else _ANY), strict or is_object)
    if schema is Transform:
        _check_transform(where, document, field, rule.framed)
    if schema is ModelDirective:
        kinds = [name for name, item in document.items() if item is not None]
        _must(None if len(kinds) == 1 else f"must have one of {', '.join(fields)}", where, field, kinds)
    for name, item in vars(schema()).items() if is_own and not is_object else ():
        if name not in document:
            _check(where, item, fields[name], _below(field, name), known[name], strict=True)


def _below(field: str, name: object) -> str:
    return f"{field}.{name}" if field else str(name)


def _must(expected: str | None, where: Path | str, field: str, value: object) -> None:
    if expected is not None:
        raise InputError(where, field, value, expected)


def _check_entry(where: Path | str, value: Any, schema: type, field: str, rule: Rule, strict: bool) -> None:
    kind, words = _PRIMITIVES[schema]
    is_one = type(value) is schema or (isinstance(value, kind) and (schema is bool or not isinstance(value, bool)))
    if not is_one and (strict or not _converts(value, schema)):
        raise InputError(where, field, value, f"must be {words}{f', {rule.unit}' if rule.unit else ''}")
    if schema is int and abs(int(value)) > _MOST_WHOLE:
        raise InputError(where, field, value, f"must be a whole number up to {_MOST_WHOLE}")
    if schema is not bool:
        _must(rule.of_text(value) if schema is str else rule.of_number(float(value)), where, field, value)


def _is_finite(pose: Transform) -> bool:
    """Whether a pose is known, and finite."""
    try:
        return bool(np.isfinite(pose.GetDeterministicValue().GetAsMatrix34()).all())
    except RuntimeError:  # it is random, or a rotation is not finite
        return False


_ROTATIONS = {"!Rpy": {"deg"}, "!AngleAxis": {"angle_deg", "axis"}, "!Identity": set[str]()}


def _check_transform(where: Path | str, value: dict[str, Any], field: str, framed: bool) -> None:
    """Poses are fixed: not random and, unless it is `framed`, not in a frame, which Drake would ignore here."""
    base = value.get("base_frame")
    require(
        framed or base is None, where, f"{field}.base_frame", base, "leave it out; `parent` of a model names a frame"
    )
    _check_three(where, value.get("translation", [0, 0, 0]), f"{field}.translation", "must be three numbers, m")
    rotation, expected = value.get("rotation", {}), "write !Rpy { deg: [roll, pitch, yaw] }"
    parts: dict[str, Any] = dict(rotation) if isinstance(rotation, dict) else {_TAG: None}
    known = _ROTATIONS.get(parts.pop(_TAG, "!Identity"))
    require(known is not None and parts.keys() == known, where, f"{field}.rotation", rotation, expected)
    for name, part in parts.items():
        three = [part, 0, 0] if name == "angle_deg" else part
        _check_three(where, three, f"{field}.rotation.{name}", expected)
    axis = parts.get("axis", [1])
    require(any(map(float, axis)), where, f"{field}.rotation.axis", axis, "must not be zero")


def _check_three(where: Path | str, value: Any, field: str, expected: str) -> None:
    fits = isinstance(value, list) and len(value) == 3 and all(_converts(number, float) for number in value)
    require(fits, where, field, value, expected)
    for i, number in enumerate(value):
        _must(_ANY.of_number(float(number)), where, f"{field}[{i}]", number)


def _mapping(where: Path | str, value: Any, field: str) -> dict[str, Any]:
    if not isinstance(value, dict):
        raise InputError(where, field, value, "must be a mapping of keys to values")
    return value


@cache
def _fields(schema: Any) -> dict[str, Any]:
    if is_dataclass(schema):
        return get_type_hints(schema)
    return {field.name: field.type for field in getattr(schema, "__fields__", ())}


def _converts(value: Any, schema: type) -> bool:
    if isinstance(value, bool):
        return schema is bool
    if schema in (float, int):
        if isinstance(value, str) and not is_number(value.strip()):
            return False
        try:
            return schema(value) == float(value) or math.isnan(float(value))
        except (TypeError, ValueError, OverflowError):
            return False
    return isinstance(value, schema)
