"""Reads the source of a class for its fields: unit and range, and the comment next to each, or above it."""

import ast
import inspect
import re
import textwrap
from dataclasses import dataclass
from typing import Any

from soft_gripper.extras import added
from soft_gripper.quantity import Rule, rules

_TRAILING = re.compile(r"(?<!\S)#\s*(.*)$")


@dataclass(frozen=True)
class FieldText:
    """A field as its source has it."""

    name: str
    type: str
    default: str  # empty: it must be given
    values: str  # unit and range, or the choices
    comment: str


def field_texts(of: type) -> list[FieldText]:
    """The fields of a dataclass or NamedTuple in their order, base classes first, those of extras last."""
    found: dict[str, FieldText] = {}
    for base in reversed(of.__mro__):
        if base.__module__.startswith("soft_gripper"):
            found |= {text.name: text for text in _own_fields(base)}
    for declared in added("FIELDS"):
        if of.__name__ in declared:
            found |= {text.name: text for text in _own_fields(declared[of.__name__])}
    return list(found.values())


def has_fields(of: Any) -> bool:
    """Whether it is a dataclass or a NamedTuple."""
    return isinstance(of, type) and (hasattr(of, "__dataclass_fields__") or hasattr(of, "_fields"))


def _own_fields(of: type) -> list[FieldText]:
    source = textwrap.dedent(inspect.getsource(of))
    lines = source.splitlines()
    (tree,) = ast.parse(source).body
    nodes = [node for node in tree.body if isinstance(node, ast.AnnAssign) and isinstance(node.target, ast.Name)]
    known = rules(of) if hasattr(of, "__dataclass_fields__") else {}
    public = [node for node in nodes if not node.target.id.startswith("_")]
    return [_field(node, lines, known.get(node.target.id, Rule())) for node in public]


def _field(node: ast.AnnAssign, lines: list[str], rule: Rule) -> FieldText:
    default = "" if node.value is None else _default(node.value)
    values, comment = values_text(rule), _comment(node, lines)
    return FieldText(node.target.id, ast.unparse(node.annotation), default, values, comment)


def values_text(rule: Rule) -> str:
    """Unit and range of a field in words."""
    size = [f"{rule.length} entries"] if rule.length is not None else ["not empty"] if rule.filled else []
    span = ["[least, most]"] if rule.span else []
    return ", ".join(part for part in (rule.unit, *span, *size, rule.limits, " or ".join(rule.choices)) if part)


def _default(value: ast.expr) -> str:
    """As the source has it; of `field(default_factory=...)` what the factory makes."""
    function = ast.unparse(value.func) if isinstance(value, ast.Call) else ""
    if isinstance(value, ast.Call) and function == "quantity":
        return ast.unparse(value.args[0])
    if function == "like":
        return "None"
    if isinstance(value, ast.Call) and function == "field":
        factories = [keyword.value for keyword in value.keywords if keyword.arg == "default_factory"]
        if not factories:
            return ""
        (factory,) = factories
        if isinstance(factory, ast.Lambda):
            return ast.unparse(factory.body)
        return {"list": "[]", "dict": "{}"}.get(ast.unparse(factory), f"{ast.unparse(factory)}()")
    return ast.unparse(value)


def _comment(node: ast.AnnAssign, lines: list[str]) -> str:
    """The comment after the field, preceded by the comment lines above it."""
    above = []
    for line in reversed(lines[: node.lineno - 1]):
        if not line.lstrip().startswith("#"):
            break
        above.insert(0, line.lstrip().lstrip("#").strip())
    behind = _TRAILING.search(lines[node.end_lineno - 1][node.end_col_offset :])
    return " ".join([*above, *([behind[1]] if behind else [])])
