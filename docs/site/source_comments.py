"""What the source of a class says of its fields: the comment beside each, or above it."""

import ast
import inspect
import re
import textwrap
from dataclasses import dataclass
from typing import Any

_TRAILING = re.compile(r"(?<!\S)#\s*(.*)$")


@dataclass(frozen=True)
class FieldText:
    """A field as its source has it."""

    name: str
    type: str
    default: str  # empty: it must be given
    comment: str


def field_texts(of: type) -> list[FieldText]:
    """The fields of a dataclass or NamedTuple in their order, those of its base classes first."""
    found: dict[str, FieldText] = {}
    for base in reversed(of.__mro__):
        if base.__module__.startswith("soft_gripper"):
            found |= {text.name: text for text in _own_fields(base)}
    return list(found.values())


def has_fields(of: Any) -> bool:
    """Whether it is a dataclass or a NamedTuple."""
    return isinstance(of, type) and (hasattr(of, "__dataclass_fields__") or hasattr(of, "_fields"))


def _own_fields(of: type) -> list[FieldText]:
    source = textwrap.dedent(inspect.getsource(of))
    lines = source.splitlines()
    (tree,) = ast.parse(source).body
    nodes = [node for node in tree.body if isinstance(node, ast.AnnAssign) and isinstance(node.target, ast.Name)]
    return [_field(node, lines) for node in nodes if not node.target.id.startswith("_")]


def _field(node: ast.AnnAssign, lines: list[str]) -> FieldText:
    default = "" if node.value is None else _default(node.value)
    return FieldText(node.target.id, ast.unparse(node.annotation), default, _comment(node, lines))


def _default(value: ast.expr) -> str:
    """As the source has it; of `field(default_factory=...)` what the factory makes."""
    if isinstance(value, ast.Call) and ast.unparse(value.func) == "field":
        factory = next(keyword.value for keyword in value.keywords if keyword.arg == "default_factory")
        if isinstance(factory, ast.Lambda):
            return ast.unparse(factory.body)
        return {"list": "[]", "dict": "{}"}.get(ast.unparse(factory), f"{ast.unparse(factory)}()")
    return ast.unparse(value)


def _comment(node: ast.AnnAssign, lines: list[str]) -> str:
    """What stands behind the field, after the whole lines of comment above it."""
    above = []
    for line in reversed(lines[: node.lineno - 1]):
        if not line.lstrip().startswith("#"):
            break
        above.insert(0, line.lstrip().lstrip("#").strip())
    behind = _TRAILING.search(lines[node.end_lineno - 1][node.end_col_offset :])
    return " ".join([*above, *([behind[1]] if behind else [])])
