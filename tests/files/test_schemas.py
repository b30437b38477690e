"""Every field of every schema takes its whole range, refuses all else by name, and is written as it is read.

The schemas are found: the dataclasses of the package whose fields have rules, and which plain data can describe.
"""

import math
import pkgutil
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import fields, is_dataclass, replace
from importlib import import_module
from pathlib import Path
from types import NoneType, UnionType
from typing import Any, NamedTuple, get_args, get_origin, get_type_hints

import numpy as np
import pytest
from pydrake.common.schema import Transform
from pydrake.common.yaml import yaml_dump_typed, yaml_load_data
from pydrake.multibody.parsing import ModelDirective
from refusals import refused

import soft_gripper
import soft_gripper.files.document as document_module
from soft_gripper.errors import InputError
from soft_gripper.estimators.uncertainty import Uncertainty
from soft_gripper.files.document import Place, dotted_changes, load_config, read
from soft_gripper.fingers.finger import Finger
from soft_gripper.quantity import Rule, rules
from soft_gripper.sensors.path_sensors import SensorPath
from soft_gripper.sensors.pressure_errors import PressureErrors
from soft_gripper.sensors.strain_errors import StrainErrors

FILE = Path("a.yaml")
ANY = Rule()
LARGEST_WHOLE = 2**32 - 1
WORDS = {float: "must be a number", int: "must be a whole number", bool: "must be true or false", str: "must be text"}
OF_ANOTHER_TYPE: dict[type, Sequence[object]] = {
    float: ("wide", True, None, [], {}),
    int: ("two", True, None, [], {}, 2.5, math.inf),
    bool: ("yes", 1, 0.0, None, [], {}),
    str: (1.5, True, None, [], {}),
}


class Wrong(NamedTuple):
    """A value that a field does not take: where the mistake is in it, the mistake, and words of the complaint."""

    value: object
    place: str
    mistake: object
    words: str


class Cases(NamedTuple):
    """Values that a field takes, and those that it does not."""

    right: list[Any]
    wrong: list[Wrong]


def schemas() -> Iterator[type]:
    for found in pkgutil.walk_packages(soft_gripper.__path__, "soft_gripper."):
        module = import_module(found.name)
        for kind in vars(module).values():
            is_own = isinstance(kind, type) and is_dataclass(kind) and kind.__module__ == module.__name__
            if is_own and any(rule != ANY for rule in rules(kind).values()) and has_defaults(kind):
                yield kind


def has_defaults(kind: Any) -> bool:
    """Whether a document may leave out each field of a schema, and of those inside it."""
    if not is_dataclass(kind):
        return all(map(has_defaults, get_args(kind)))
    hints = get_type_hints(kind).values()
    return all(part.default is not part.default_factory for part in fields(kind)) and all(map(has_defaults, hints))


def cases(kind: Any, rule: Rule) -> Cases:
    """Values on both sides of every limit of a field; without mistakes if its type is anything."""
    parts = get_args(kind)
    if get_origin(kind) is UnionType and NoneType in parts:
        right, wrong = cases(next(part for part in parts if part is not NoneType), rule)
        return Cases([*right, None], [case for case in wrong if case.value is not None])
    if kind in (float, int):
        return numbers(kind, rule)
    if kind is str:
        return texts(rule)
    if kind is bool:
        return Cases([False, True], other_types(bool))
    if get_origin(kind) in (list, tuple):
        return groups(cases(parts[0], rule), rule)
    if get_origin(kind) is dict:
        is_change = rule.paths and parts[-1] is str
        return changes(rule.paths) if is_change else mappings(cases(parts[-1], rule), rule)
    if kind is Transform:
        return POSES
    if kind is np.ndarray:  # three numbers, of which Drake makes a color
        right, wrong = cases(list[float], rule)
        return Cases([3 * value[:1] for value in right if value], wrong)
    if kind is ModelDirective:
        return DIRECTIVES
    inside = is_dataclass(kind) or hasattr(kind, "__fields__")
    return parts_of(kind, rule) if inside else Cases([0, "a"], [])


DIRECTIVES = Cases(
    [
        {"add_weld": {"parent": "world", "child": "thing::base"}},
        {"add_model": {"default_free_body_pose": {"b": {"base_frame": "world", "translation": [0, 0, 1]}}}},
        {"add_frame": {"X_PF": {"base_frame": "world", "rotation": {"_tag": "!Identity"}}}},
    ],
    [
        Wrong("x", "", "x", "must be a mapping"),
        Wrong({}, "", [], "must have one of add_model, "),
        Wrong({"add_model": {}, "add_weld": {}}, "", ["add_model", "add_weld"], "must have one of add_model, "),
        Wrong({"add_model": 0}, ".add_model", 0, "must be a mapping"),
        Wrong({"add_model": {"nmae": "a"}}, ".add_model.nmae", "a", "did you mean 'name'?"),
        Wrong({"add_model": {"name": ["a"]}}, ".add_model.name", ["a"], "must be text"),
        Wrong({"add_model": {"default_joint_positions": 0.1}}, ".add_model.default_joint_positions", 0.1, "a mapping"),
        Wrong(
            {"add_model": {"default_joint_positions": {"a": 1}}}, ".add_model.default_joint_positions.a", 1, "a list"
        ),
        Wrong({"add_frame": {"X_PF": math.inf}}, ".add_frame.X_PF", math.inf, "must be a mapping"),
        Wrong({"add_frame": {"X_PF": {"base_frame": 1}}}, ".add_frame.X_PF.base_frame", 1, "must be text"),
        Wrong({"add_collision_filter_group": {"members": "a"}}, ".add_collision_filter_group.members", "a", "a list"),
    ],
)


def other_types(kind: type) -> list[Wrong]:
    return [Wrong(value, "", value, WORDS[kind]) for value in OF_ANOTHER_TYPE[kind]]


def numbers(kind: type, rule: Rule) -> Cases:
    """Just inside and just outside of the range, and what is not a finite number."""

    def beside(limit: float, side: int) -> float:
        return limit + side if kind is int else limit + side * max(1e-9 * abs(limit), 2 * rule.sizes[0])

    right, wrong = [], other_types(kind)
    for limit, side, is_inside in (
        (rule.above, 1, False),
        (rule.least, 1, True),
        (rule.below, -1, False),
        (rule.most, -1, True),
    ):
        if limit is not None:
            number = kind(limit)
            right.append(number if is_inside else beside(number, side))
            outside = beside(number, -side) if is_inside else number
            wrong.append(Wrong(outside, "", outside, f"{limit:g}{f' {rule.unit}' if rule.unit else ''}"))
    if kind is float:
        smallest, largest = 0.9 * rule.sizes[0], 1.1 * rule.sizes[1]
        beyond = (math.inf, -math.inf, largest, -largest) if largest < math.inf else ()
        wrong += [Wrong(size, "", size, "must be ") for size in (math.nan, *beyond, smallest, -smallest) if size]
    else:
        wrong.append(Wrong(LARGEST_WHOLE + 1, "", LARGEST_WHOLE + 1, str(LARGEST_WHOLE)))
    return Cases(right or [kind(0), kind(-1), kind(1)], wrong)


def texts(rule: Rule) -> Cases:
    wrong = other_types(str)
    if rule.known:
        known = rule.known() if callable(rule.known) else rule.known
        return Cases(list(known), [*wrong, Wrong("nosuch", "", "nosuch", ", ".join(known))])
    if rule.is_name:
        misnamed = ("", "a b", "a.b", "a::b", "1st", "_a", "ä", "x" * 61)
        return Cases(["a", "Z-9_", "x" * 60], [*wrong, *(Wrong(name, "", name, "must be a name") for name in misnamed)])
    empty = [Wrong("", "", "", "must not be empty")] if rule.filled else []
    return Cases(["a", *([] if rule.filled else [""])], wrong + empty)


def groups(entry: Cases, rule: Rule) -> Cases:
    length = rule.length or 2
    right = [length * [value] for value in entry.right[:3]] + ([] if rule.filled or rule.length or rule.span else [[]])
    wrong = [Wrong([right[0][0], case.value], f"[1]{case.place}", case.mistake, case.words) for case in entry.wrong]
    wrong += [Wrong(value, "", value, "must be a list") for value in ("x", 1.0, None, {})]
    if rule.length:
        other = (length + 1) * [entry.right[0]]
        wrong.append(Wrong(other, "", other, f"must have {length} entries"))
    if rule.filled:
        wrong.append(Wrong([], "", [], "must not be empty"))
    if rule.span:
        low, high = sorted(entry.right)[0], sorted(entry.right)[0] + 0.1
        right.append([low, high])
        wrong += [Wrong(span, "", span, "[least, most]") for span in ([high, low], [low], [low, low, high])]
    return Cases(right, wrong)


def changes(paths: Mapping[str, Rule]) -> Cases:
    """Numbers by dotted keys, each in its range, or what is added to one; null leaves it as it is."""
    right = [{name: value} for name in paths for value in ("+10 %", None) if not paths[name].known]
    wrong = [Wrong(value, "", value, "must be a mapping") for value in ("x", [], None)]
    for name, rule in paths.items():
        entry = texts(rule) if rule.known else numbers(float, rule)
        right += [{name: value} for value in entry.right]
        wrong += [Wrong({name: c.value}, f".{name}", c.value, c.words) for c in entry.wrong if c.value is not None]
        others = [] if rule.known else ["nan", "10 %", "3 mm", "+0.1", [0.1], {"mean": 0.1}]
        wrong += [Wrong({name: value}, f".{name}", value, f"must be a number, {rule.unit}") for value in others]
        outer, *inner = name.split(".", 1)
        if inner:
            right.append({outer: {inner[0]: entry.right[0]}})
            twice = {outer: {inner[0]: entry.right[0]}, name: entry.right[0]}
            wrong.append(Wrong(twice, f".{name}", entry.right[0], "appears more than once"))
    return Cases(right, [*wrong, Wrong({"widht": 0.1}, ".widht", 0.1, "did you mean 'width'?")])


def mappings(entry: Cases, rule: Rule) -> Cases:
    right = [{"any": value} for value in entry.right] + ([] if rule.filled else [{}])
    wrong = [Wrong({"any": case.value}, f".any{case.place}", case.mistake, case.words) for case in entry.wrong]
    wrong += [Wrong(value, "", value, "must be a mapping") for value in ("x", [], None)]
    tagged = {"_tag": "!Rpy"}
    wrong += [Wrong(tagged, "", tagged, "without a tag"), *([Wrong({}, "", {}, "not be empty")] if rule.filled else [])]
    return Cases(right, wrong)


def parts_of(kind: Any, rule: Rule) -> Cases:
    """A schema inside another: fields of the outer one are refused with both names."""
    hints, known = described(kind, rule)
    right = [example(kind, rule)]
    wrong = [Wrong(value, "", value, "must be a mapping") for value in ("x", 3, [], None)]
    for name, hint in hints.items():
        found = cases(hint, known.get(name, ANY)).wrong
        wrong += [Wrong(right[0] | {name: c.value}, f".{name}{c.place}", c.mistake, c.words) for c in found[:1]]
    near, far = f"{next(iter(hints))}_", "§"
    wrong.append(Wrong({near: 1}, f".{near}", 1, "did you mean"))
    return Cases(right, [*wrong, Wrong({far: 1}, f".{far}", 1, f"known: {next(iter(hints))}")])


def described(kind: Any, rule: Rule = ANY) -> tuple[dict[str, Any], dict[str, Rule]]:
    """The types and the rules of the fields of a schema, or of a config of Drake's."""
    if is_dataclass(kind):
        return get_type_hints(kind), rules(kind)
    return {field.name: field.type for field in kind.__fields__}, dict(rule.parts)


def example(kind: Any, rule: Rule = ANY) -> dict[str, Any]:
    """A valid document of a schema, with each field that has a right value."""
    hints, known = described(kind, rule)
    found = {name: cases(hint, known.get(name, ANY)).right for name, hint in hints.items()}
    return {name: right[0] for name, right in found.items() if right}


def _pose(place: str, mistake: Any, **pose: Any) -> Wrong:
    return Wrong(pose, place, mistake, "")


def _turned(tag: str, value: Any) -> dict[str, Any]:
    return {"_tag": tag, "deg": value}


_AXIS = {"_tag": "!AngleAxis", "angle_deg": 3, "axis": [0, 0, 0]}
POSES = Cases(
    [
        {},
        {"translation": [0, 1, 2.5]},
        {"rotation": _turned("!Rpy", [0, 0, 90])},
        {"rotation": _AXIS | {"axis": [0, 0, 2]}},
    ],
    [
        _pose(".translation", [0, 1], translation=[0, 1]),
        _pose(".translation[2]", math.inf, translation=[0, 0, math.inf]),
        _pose(".rotation.deg[1]", math.nan, rotation=_turned("!Rpy", [0, math.nan, 0])),
        _pose(".rotation.deg", [0, 0], rotation=_turned("!Rpy", [0, 0])),
        _pose(".rotation.deg", ["up"], rotation=_turned("!Rpy", ["up"])),
        _pose(".rotation", {"deg": [0, 0, 0]}, rotation={"deg": [0, 0, 0]}),
        _pose(".rotation", {"_tag": "!Uniform"}, rotation={"_tag": "!Uniform"}),
        _pose(".rotation.axis", [0, 0, 0], rotation=_AXIS),
        _pose(".rotation", 90, rotation=90),
        _pose(".base_frame", "world", base_frame="world"),
        Wrong(None, "", None, "must be a mapping"),
    ],
)
SCHEMAS = pytest.mark.parametrize("schema", list(schemas()), ids=lambda schema: schema.__name__)


@SCHEMAS
def test_a_field_takes_its_range_and_refuses_all_else_with_its_name_and_what_would_be_right(
    schema: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Each field by itself: what a rule between fields would refuse is right here."""
    monkeypatch.setattr(document_module, "violations", lambda config: iter(()))
    hints, known = described(schema)
    document = example(schema)
    load_config(FILE, document, schema)
    for name, hint in hints.items():
        right, wrong = cases(hint, known[name])
        for value in right:
            load_config(FILE, document | {name: value}, schema)
        for case in wrong:
            with refused(f"{name}{case.place}", case.mistake) as caught:
                load_config(FILE, document | {name: case.value}, schema)
            assert caught.value.where == FILE
            assert case.words in caught.value.expected


@SCHEMAS
def test_a_document_that_is_written_is_the_one_that_was_read(schema: Any) -> None:
    """With each field in turn, where it goes with the others' defaults."""
    if schema.__dataclass_params__.frozen:
        return  # made in Python
    hints, known = described(schema)
    required = {name: value for name, value in example(schema).items() if not default_is_valid(schema, name)}
    kept = 0
    for name, hint in hints.items():
        for value in cases(hint, known[name]).right[:3]:
            try:
                text = yaml_dump_typed(load_config(FILE, required | {name: value}, schema))
            except InputError:  # it breaks a rule between fields
                continue
            again = load_config(FILE, yaml_load_data(text), schema)
            assert yaml_dump_typed(again) == text
            assert not isinstance(value, float | int | str) or getattr(again, name) == value
            kept += 1
    assert kept or hasattr(schema, "violations")


def default_is_valid(schema: Any, name: str) -> bool:
    try:
        read(getattr(schema(), name), get_type_hints(schema)[name], rules(schema)[name], Place(FILE, name, strict=True))
    except InputError:
        return False
    return True


def checked_objects(finger: Finger) -> list[Any]:
    """Objects that are made in Python too, and check themselves."""
    path = SensorPath("a", (0.0,), (0.0,), (0.0, 1.0))
    return [StrainErrors(), PressureErrors(), Uncertainty(), path, finger]


def mistakes(checked: Any) -> Iterator[tuple[list[str], Wrong]]:
    """Names of the fields with rules of an object and of its parts, each with a value that the field does not take."""
    known = rules(type(checked))
    for name, hint in get_type_hints(type(checked)).items():
        if is_dataclass(part := getattr(checked, name)):
            yield from (([name, *names], case) for names, case in mistakes(part))
        elif known[name] != ANY:
            yield from (([name], case) for case in cases(hint, known[name]).wrong)


def changed(checked: Any, name: str, *names: str, value: object) -> Any:
    """An object with another value of a field, or of one of its parts."""
    return replace(checked, **{name: changed(getattr(checked, name), *names, value=value) if names else value})


def test_an_object_of_python_refuses_what_a_document_may_not_hold(shipped_finger: Finger) -> None:
    for checked in checked_objects(shipped_finger):
        for names, case in mistakes(checked):
            with pytest.raises(InputError) as caught:
                changed(checked, *names, value=case.value)
            assert caught.value.field == f"{'.'.join(names)}{case.place}", (checked, case)


def test_keys_have_dots_down_to_a_path_and_what_is_none_is_left_out():
    changes = {"a": {"b": 1, "c": {"d": None}}, "e": {"f": 2.5, "g": True}, "h.i": "+1 %"}
    assert dotted_changes(changes, {"e": Rule()}) == {"a.b": "1", "e": {"f": 2.5, "g": True}, "h.i": "+1 %"}
    assert dotted_changes([changes], {}) == [changes]
