"""The page of the scenario's schema, from its dataclasses: name, type, default, range and comment of every field."""

import dataclasses
import inspect
import re
import types
import typing
from collections.abc import Iterator, Mapping

from source_comments import field_texts, values_text
from tables import code, prose, table

from soft_gripper.quantity import Rule, rules
from soft_gripper.scenario.finger_changes import FINGER_PATHS, MODEL_PATHS
from soft_gripper.scenario.schema import Scenario

_INTRODUCTION = """\
# Scenario schema

A scenario is a YAML file of these fields; what it leaves out has its default. Any field can be given on the command
line too, by its dotted key: `soft-gripper run box_grasp --set sensor.sections=2`. SI units. What may be `None` may be
absent.

This page is made from [soft_gripper/scenario/schema.py](../files/soft_gripper/scenario/schema.py.md).
"""
_OF_DRAKE = (
    "A schema of Drake, which explains its fields: `pydrake`'s help of this class. Here are the defaults of a scenario."
)
_CHANGES = """\
## Changes of fingers

`models.NAME.fingers.NAME` and `nominal.finger` have these keys. Each takes a number or a change, such as `+10 %`. A key
of a section, such as `width`, changes every section; `base.width` and `tip.width` change one, `sections.width` those
between, which `sections.at` moves. `tilt` is of a model alone, `pressure_offset` of the nominal finger.
"""
_SECTIONS = ("base.", "tip.", "sections.")


def schema_page() -> str:
    """Markdown, with a section for each class, `Scenario` first, and one for the changes of fingers."""
    classes = (_section(of, default) for of, default in _classes(Scenario, Scenario()))
    paths = {path: rule for path, rule in (MODEL_PATHS | FINGER_PATHS).items() if not path.startswith(_SECTIONS)}
    rows = [(code(path), prose(values_text(rule))) for path, rule in paths.items()]
    return "\n".join([_INTRODUCTION, *classes, f"{_CHANGES}\n{table(('key', 'values'), rows)}"])


def scenario_classes() -> list[type]:
    """All classes that a scenario is made of."""
    return [of for of, _ in _classes(Scenario, Scenario())]


def field_names(of: type) -> list[str]:
    """Of a class of the project's or of Drake's."""
    if dataclasses.is_dataclass(of):
        return [field.name for field in dataclasses.fields(of)]
    return [field.name for field in of.__fields__]


def _classes(of: type, default: object) -> Iterator[tuple[type, object]]:
    """A class, an instance with its defaults, and then all classes of its fields, each once."""
    found = {of: default}
    waiting = [of]
    while waiting:
        outer = waiting.pop(0)
        yield outer, found[outer]
        if not dataclasses.is_dataclass(outer):
            continue
        for name, hint in typing.get_type_hints(outer).items():
            for inner in _parts(hint):
                if inner not in found:
                    value = getattr(found[outer], name)
                    found[inner] = value if isinstance(value, inner) else inner()
                    waiting.append(inner)


def _parts(hint: object) -> Iterator[type]:
    """The classes with fields in a type, such as list[ModelConfig] or ArmConfig | None."""
    if isinstance(hint, types.UnionType) or typing.get_args(hint):
        for argument in typing.get_args(hint):
            yield from _parts(argument)
    elif isinstance(hint, type) and (dataclasses.is_dataclass(hint) or hasattr(hint, "__fields__")):
        yield hint


def _rules_of(of: type) -> Mapping[str, Rule]:
    """The rules of a config of Drake, which are at the field of the scenario that holds it."""
    hints = typing.get_type_hints(Scenario)
    return next((rule.parts for name, rule in rules(Scenario).items() if hints[name] is of), {})


def _section(of: type, default: object) -> str:
    heading = f"({of.__name__.lower()})=\n## {of.__name__}\n"
    if not dataclasses.is_dataclass(of):
        known = _rules_of(of)
        values = {name: prose(values_text(known.get(name, Rule()))) for name in field_names(of)}
        rows = [(code(name), code(getattr(default, name)), text) for name, text in values.items()]
        return f"{heading}\n{_OF_DRAKE}\n\n{table(('field', 'default', 'values'), rows)}"
    rows = [
        (code(text.name), _type(of, text.name, text.type), code(text.default), prose(text.values), prose(text.comment))
        for text in field_texts(of)
    ]
    summary = re.split(r"\n+(?:Args|Raises):", inspect.getdoc(of) or "")[0]
    return f"{heading}\n{prose(summary)}\n\n{table(('field', 'type', 'default', 'values', 'meaning'), rows)}"


def _type(of: type, name: str, text: str) -> str:
    """The type, with a link where it is of classes that have a section."""
    inner = list(_parts(typing.get_type_hints(of)[name]))
    return f"[`{text}`](#{inner[0].__name__.lower()})" if inner else code(text)
