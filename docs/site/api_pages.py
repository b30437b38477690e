"""A page for each public name: its docstring, its fields and, of a block, its ports."""

import ast
import inspect
import re
from collections.abc import Iterator
from functools import cache
from pathlib import Path
from typing import Any

from example_blocks import example_blocks
from links import ROOT
from port_tables import ports_table
from source_comments import field_texts, has_fields
from tables import code, prose, table

import soft_gripper as sg

_FRONT_DOOR = ROOT / "soft_gripper" / "__init__.py"
_INDEX = """\
# Python API

All public names are in `soft_gripper`; each is loaded when it is first used.

```python
import soft_gripper as sg
```

Arrays have free leading axes unless their page says otherwise; SI units throughout. What a page calls `Array` is a
numpy array of floats, and `Planar` one of complex numbers z + i x in the bending plane.
"""


def api_pages() -> Iterator[tuple[str, str]]:
    """Where a page goes, and its Markdown: one for each public name, and their index."""
    yield "api/index.md", _index()
    for name in sg.__all__:
        yield f"api/{name}.md", _page(name)


@cache
def groups() -> dict[str, list[str]]:
    """The public names under the headings that soft_gripper/__init__.py has for them."""
    found: dict[str, list[str]] = {}
    heading = ""
    for line in _FRONT_DOOR.read_text(encoding="utf-8").partition("_MODULES = {")[2].partition("\n}")[0].splitlines():
        if comment := re.match(r" +# (.*)\.$", line):
            heading = comment[1]
        found.setdefault(heading, []).extend(name for name in re.findall(r"\w+", line.rpartition(":")[2] or line))
    return {heading: [name for name in names if name in sg.__all__] for heading, names in found.items() if heading}


def _index() -> str:
    parts = [_INDEX]
    for heading, names in groups().items():
        rows = [(f"[`{name}`]({name}.md)", prose(_summary(name))) for name in names]
        parts += [f"## {heading}", table(("name", ""), rows)]
    return "\n\n".join(parts) + "\n"


def _summary(name: str) -> str:
    """The first sentence of a docstring."""
    value = getattr(sg, name)
    if not (inspect.isclass(value) or inspect.isfunction(value)):
        return ""
    return (inspect.getdoc(value) or "").split("\n\n")[0].replace("\n", " ")


def _page(name: str) -> str:
    value, path = getattr(sg, name), _source(name)
    where = f"From [{path}](../files/{path}.md)."
    kind = "class" if inspect.isclass(value) else "function" if inspect.isfunction(value) else ""
    # Orphans: in the tree of contents that every page carries, so many pages cost more than all else.
    parts = [f"---\norphan: true\n---\n\n# {name}", where]
    parts.append(_autodoc(kind, name) if kind else f"```python\n{_assignment(name, ROOT / path)}\n```")
    if has_fields(value):
        rows = [
            (code(text.name), code(text.type), code(text.default), prose(text.comment)) for text in field_texts(value)
        ]
        parts += ["## Fields", table(("field", "type", "default", "meaning"), rows)]
    if value.__hash__ and value in example_blocks():
        parts += ["## Ports", "Sizes and names are those of an example.", ports_table(example_blocks()[value])]
    return "\n\n".join(parts) + "\n"


def _autodoc(kind: str, name: str) -> str:
    return f"```{{eval-rst}}\n.. currentmodule:: soft_gripper\n.. auto{kind}:: {name}\n```"


def _source(name: str) -> str:
    """The file in the repository that a name is from; folders of the top level are installed below soft_gripper."""
    parts = Path(*sg._HOMES[name].split(".")).with_suffix(".py")
    return str(parts if (ROOT / parts).exists() else "soft_gripper" / parts)


def _assignment(name: str, path: Path) -> str:
    """The lines of a file that give a name its value, with the comment above."""
    source = path.read_text(encoding="utf-8")
    lines = source.splitlines()
    node = next(node for node in ast.parse(source).body if name in _assigned(node))
    begin = node.lineno - 1
    while lines[begin - 1].startswith("#"):
        begin -= 1
    return "\n".join(lines[begin : node.end_lineno])


def _assigned(node: Any) -> list[str]:
    targets = node.targets if isinstance(node, ast.Assign) else [getattr(node, "target", None)]
    return [target.id for target in targets if isinstance(target, ast.Name)]
