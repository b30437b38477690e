"""Configurations read by their schema of dataclasses, with the rules beside the fields (`quantity.py`).

`read` checks a value, fills in what it leaves out, and asks the rules across fields, in one pass from the leaves up.
"""

import math
import re
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import is_dataclass
from functools import cache
from numbers import Integral, Real
from pathlib import Path
from types import NoneType, UnionType
from typing import Any, NamedTuple, TypeVar, Union, get_args, get_origin, get_type_hints

import numpy as np
from pydrake.common.schema import Rotation, Transform
from pydrake.multibody.parsing import ModelDirective

from soft_gripper.errors import InputError, did_you_mean, first_line, is_near, similar_names, suggestion
from soft_gripper.extras import added
from soft_gripper.files.number import CHANGE, changed, is_number
from soft_gripper.quantity import Rule, rules, violations

_T = TypeVar("_T")
_TAG_KEY = "_tag"  # key under which Drake keeps a tag of YAML
_PRIMITIVE_KINDS: dict[object, tuple[type, str]] = {
    float: (Real, "a number"),
    int: (Integral, "a whole number"),
    bool: (bool, "true or false"),
    str: (str, "text"),
}
_MAX_WHOLE_NUMBER = 2**32 - 1  # of Drake's seeds
_ANY_RULE = Rule()
_FRAMED_RULE = Rule(framed=True)
_MAX_PLACES = 4  # that are suggested: a key in more, such as a name, says little
_FIRST_KEY = re.compile(r"[^.[]+(?=[.[])")  # the first key of several
_ROTATION_KINDS = {"!Rpy": Rotation.Rpy, "!AngleAxis": Rotation.AngleAxis, "!Identity": Rotation.Identity}


def require(is_valid: bool, where: Path | str, field: str, value: object, expected: str) -> None:
    """Raises an InputError unless `is_valid`."""
    if not is_valid:
        raise InputError(where, field, value, expected)


def require_value(value: _T | None, where: Path | str, field: str, expected: str) -> _T:
    """Returns a required value; raises an InputError if it is None."""
    if value is None:
        raise InputError(where, field, None, expected)
    return value


class Place(NamedTuple):
    """Position of a value in a document, for messages."""

    where: Path | str  # file or part
    field: str = ""  # with dots
    schema: Any = None  # of the whole document
    document: Any = None  # the whole
    strict: bool = False  # numbers given as text, as YAML reads 1e3, are refused

    def key(self, key: object) -> "Place":
        return Place(self.where, f"{self.field}.{key}" if self.field else str(key), *self[2:])

    def entry(self, i: int) -> "Place":
        return Place(self.where, f"{self.field}[{i}]", *self[2:])

    def must(self, expected: str | None, value: object) -> None:
        """Raises an InputError if something else is expected."""
        if expected is not None:
            raise InputError(self.where, self.field, value, expected)


def load_config(path: Path, document: Any, schema: type[_T]) -> _T:
    """The configuration that plain data from a YAML file describe; raises an InputError if they break the schema."""
    return read(document, schema, _ANY_RULE, Place(path, "", schema, document))


def check_config(where: Path | str, config: Any) -> None:
    """Raises an InputError for the first wrong field of a dataclass made in Python, or of what it contains."""
    read(config, type(config), _ANY_RULE, Place(where, "", type(config), config))


def read(value: Any, kind: Any, rule: Rule, place: Place, default: Any = None) -> Any:
    """A value as its type and its rule have it.

    Args:
        value: plain data, as from a YAML file, in which defaults may be left out; or an object, which is checked.
        kind: type that it must have: a dataclass, a config of Drake's, numbers, text, or lists and mappings of these.
        rule: of the value; of a list or mapping, of its entries too.
        place: for messages.
        default: object with the fields that a mapping leaves out; None: those of a new one.

    Raises:
        InputError: for an unknown key, with the one that was meant, a value of another type, or one that breaks a rule.
    """
    is_optional, kind, inner = unwrap_optional(kind)
    if value is None and is_optional:
        return None
    if kind in _PRIMITIVE_KINDS:
        result = _read_entry(value, kind, rule, place)
    elif kind in (list, tuple):
        place.must(None if isinstance(value, list | kind) else "must be a list", value)
        result = kind([read(item, inner, rule, place.entry(i)) for i, item in enumerate(value)])
    elif kind is dict:
        place.must("must be a mapping without a tag" if _TAG_KEY in _mapping(value, place) else None, value)
        if rule.paths and inner is str:
            return _read_changes(value, rule.paths, place)
        names = value if Any in (inner, *get_args(inner)) else sorted(value, key=str)  # plain data stay as they are
        result = {name: read(value[name], inner, rule, place.key(name)) for name in names}
    elif kind is np.ndarray:
        return np.array(read(value.tolist() if isinstance(value, np.ndarray) else value, list[float], rule, place))
    elif kind is Transform and isinstance(value, Transform):
        try:
            is_finite = np.isfinite(value.GetDeterministicValue().GetAsMatrix34()).all()
        except RuntimeError:  # it is random, or a rotation is not finite
            is_finite = False
        place.must(None if is_finite else "must be a pose of finite numbers", value)
        return value
    else:
        fields = _fields(kind)
        return _read_fields(value, kind, fields, rule, place, default) if fields else value
    place.must(rule.violation(result), value)
    return result


def dotted_changes(changes: Any, paths: Mapping[str, Rule]) -> Any:
    """Changes by dotted keys, without None; anything but a mapping is returned as it is."""
    if not isinstance(changes, dict):
        return changes
    return {key: _as_text(change) for key, change in _dotted_items(changes, paths) if change is not None}


def _dotted_items(changes: Mapping[Any, Any], paths: Mapping[str, Rule], outer: str = "") -> Iterator[tuple[str, Any]]:
    """The keys of mappings in mappings with dots, down to one of the `paths`, and their values."""
    for name, change in changes.items():
        key = f"{outer}{name}"
        if isinstance(change, dict) and change and key not in paths:
            yield from _dotted_items(change, paths, f"{key}.")
        else:
            yield key, change


def _as_text(change: Any) -> Any:
    return str(change) if isinstance(change, Real) and not isinstance(change, bool) else change


def _read_changes(value: dict[str, Any], paths: Mapping[str, Rule], place: Place) -> dict[str, str]:
    """Changes by dotted keys, see `dotted_changes`, each checked by the rule of its path."""
    changes = dict[str, str]()
    for key, change in _dotted_items(value, paths):
        key_place = place.key(key)
        if key not in paths:
            first_names = ", ".join(dict.fromkeys(path.partition(".")[0] for path in paths))
            key_place.must(f"no such key; {did_you_mean(similar_names(key, paths)) or f'known: {first_names}'}", change)
        key_place.must("appears more than once" if key in changes else None, change)
        if change is not None:
            changes[key] = _as_text(change)
            key_place.must(_change_violation(changes[key], paths[key]), change)
    return changes


def _change_violation(text: Any, rule: Rule) -> str | None:
    """Violated rule of a change, or of the words of a list, in words; None if valid."""
    if rule.known:
        is_known = isinstance(text, str) and set(text.split()) <= set(rule.choices)
        return None if is_known else f"must be text of the words {', '.join(rule.choices)}"
    try:
        value = changed(text, math.nan)
    except (ValueError, AttributeError):
        return f"must be a number{f', {rule.unit},' if rule.unit else ','} {CHANGE}"
    return None if math.isnan(value) else rule.violation(value)


@cache
def unwrap_optional(kind: Any) -> tuple[bool, Any, Any]:
    """Whether a type is optional, the bare type, and its entry type."""
    parts = get_args(kind)
    if get_origin(kind) in (UnionType, Union) and NoneType in parts and len(parts) == 2:
        return True, *unwrap_optional(*(part for part in parts if part is not NoneType))[1:]
    return False, get_origin(kind) or kind, parts[-1 if get_origin(kind) is dict else 0] if parts else None


def _read_entry(value: Any, kind: Any, rule: Rule, place: Place) -> Any:
    base, words = _PRIMITIVE_KINDS[kind]
    is_one = type(value) is kind or (isinstance(value, base) and (kind is bool or not isinstance(value, bool)))
    if not is_one and (place.strict or not _converts(value, kind)):
        place.must(f"must be {words}{f', {rule.unit}' if rule.unit else ''}", value)
    is_too_large = kind is int and abs(int(value)) > _MAX_WHOLE_NUMBER
    place.must(f"must be a whole number up to {_MAX_WHOLE_NUMBER}" if is_too_large else None, value)
    return kind(value)


def _read_fields(value: Any, kind: Any, fields: dict[str, Any], rule: Rule, place: Place, default: Any) -> Any:
    is_own, is_object = is_dataclass(kind), isinstance(value, kind)
    document = {name: getattr(value, name) for name in fields} if is_object else _mapping(value, place)
    missing = [name for name in fields if is_own and name not in document]
    base = value if is_object else kind() if default is None and (missing or not is_own) else default
    rule = _FRAMED_RULE if kind is ModelDirective else rule
    field_rules = rules(kind) if is_own else rule.parts
    strict = place._replace(strict=True)
    values = dict[str, Any]()
    inside = strict if is_object else place
    for name, item in document.items():
        field_place = inside.key(name)
        if name not in fields:
            field_place.must(f"no such key; {_hint(place, name, item, fields)}", item)
        part_rule = field_rules.get(name, _FRAMED_RULE if rule.framed else _ANY_RULE)
        values[name] = read(item, fields[name], part_rule, field_place, getattr(base, name, None))
    if kind is ModelDirective:
        kinds = [name for name, item in document.items() if item is not None]
        place.must(None if len(kinds) == 1 else f"must have one of {', '.join(fields)}", kinds)
    if not is_own:
        parts = _pose_parts(values, rule, place) if kind is Transform else {} if is_object else values
        for name, item in parts.items():
            try:
                setattr(base, name, item)
            except RuntimeError as error:  # Drake's own rule
                inside.key(name).must(first_line(error), document[name])
        return base
    for name in missing:
        values[name] = read(getattr(base, name), fields[name], field_rules[name], strict.key(name))
    try:
        result = value if is_object else kind(**values)
    except InputError as error:  # it asks its rules itself
        raise InputError(place.where, place.key(error.field).field, error.value, error.expected) from None
    for name, item, expected in violations(result):
        place.key(name).must(expected, item)
    return result


def _hint(place: Place, key: str, value: Any, fields: Iterable[str]) -> str:
    """Hint beside a key that a part of a schema does not have."""
    if is_near(key, fields):
        return suggestion(key, fields)
    schema, document = place.schema, place.document
    kinds = {"models": "a scenario"}
    for additions in added("DOCUMENTS"):
        kinds |= additions
    other_kinds = [form for name, form in kinds.items() if name in document and name not in _fields(schema)]
    if other_kinds:
        return f"this seems to be {other_kinds[0]}"
    return did_you_mean(_suggested_places(schema, place.key(key).field, value)) or f"known: {', '.join(fields)}"


def _suggested_places(schema: Any, field: str, value: Any) -> list[str]:
    """Places in a schema of the last key of an unknown field, of a key near it, or of the keys below it; a few at most.

    Those in the part of the document that has the field come alone.
    """
    key, part, places = field.rpartition(".")[2], _FIRST_KEY.match(field), _places(schema)
    value_keys = [name for name in value if name in places] if isinstance(value, dict) else []
    for names in ([key] if key in places else [], similar_names(key, places), value_keys):
        matches = [place for name in names for place in places[name]]
        local_places = [place for place in matches if part and place.startswith(part[0])]
        if 0 < len(local_places or matches) <= _MAX_PLACES:
            return local_places or matches
    return []


@cache
def _places(schema: Any, depth: int = 4) -> dict[str, list[str]]:
    """Places of each key in a schema, with dots; an entry of a list or mapping is NAME."""
    _, kind, inner = unwrap_optional(schema)
    if kind in (list, tuple, dict):
        return {key: [f"NAME.{place}" for place in places] for key, places in _places(inner, depth).items()}
    fields, is_own = _fields(kind) if depth else {}, is_dataclass(kind)
    by_key = {name: [name] for name in fields}
    for name, part in fields.items():
        paths = rules(kind)[name].paths if is_own else ()
        inside = f"{name}.NAME" if get_origin(get_args(part)[-1:] and get_args(part)[-1]) is dict else name
        by_key |= {path: [*by_key.get(path, []), f"{inside}.{path}"] for path in paths}
        for key, places in _places(part, depth - 1).items():
            by_key.setdefault(key, []).extend(f"{name}.{place}" for place in places)
    return by_key


def _pose_parts(value: dict[str, Any], rule: Rule, place: Place) -> dict[str, Any]:
    """Poses are fixed: not random and, unless they are framed, not in a frame, which Drake would ignore here."""
    if not rule.framed and value.get("base_frame") is not None:
        place.key("base_frame").must("leave it out; `parent` of a model names a frame", value["base_frame"])
    translation = _three(value.get("translation", [0, 0, 0]), place.key("translation"), "must be three numbers, m")
    rotation, expected = value.get("rotation", {}), "write !Rpy { deg: [roll, pitch, yaw] }"
    parts: dict[str, Any] = dict(rotation) if isinstance(rotation, dict) else {_TAG_KEY: None}
    kind: Any = _ROTATION_KINDS.get(parts.pop(_TAG_KEY, "!Identity"))
    rotation_place = place.key("rotation")
    rotation_place.must(None if kind is not None and parts.keys() == _fields(kind).keys() else expected, rotation)
    for name, part in parts.items():
        is_angle = name == "angle_deg"
        numbers = _three([part, 0, 0] if is_angle else part, rotation_place.key(name), expected)
        parts[name] = numbers[0] if is_angle else numbers
    if not any(parts.get("axis", [1])):
        rotation_place.key("axis").must("must not be zero", rotation["axis"])
    return value | {"translation": translation, "rotation": kind(**parts)}


def _three(value: Any, place: Place, expected: str) -> list[float]:
    fits = isinstance(value, list) and len(value) == 3 and all(_converts(number, float) for number in value)
    place.must(None if fits else expected, value)
    for i, number in enumerate(value):
        place.entry(i).must(_ANY_RULE.violation(float(number)), number)
    return list(map(float, value))


def _mapping(value: Any, place: Place) -> dict[str, Any]:
    place.must(None if isinstance(value, dict) else "must be a mapping of keys to values", value)
    return value


@cache
def _fields(kind: Any) -> dict[str, Any]:
    if is_dataclass(kind):
        return get_type_hints(kind)
    return {field.name: field.type for field in getattr(kind, "__fields__", ())}


def _converts(value: Any, kind: type) -> bool:
    if isinstance(value, bool):
        return kind is bool
    if kind in (float, int):
        if isinstance(value, str) and not is_number(value.strip()):
            return False
        try:
            return kind(value) == float(value) or math.isnan(float(value))
        except (TypeError, ValueError, OverflowError):
            return False
    return isinstance(value, kind)
