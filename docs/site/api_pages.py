"""A page for each public name: its docstring, its fields and, of a block, its ports."""

import ast
import inspect
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from example_blocks import example_blocks
from links import ROOT
from port_tables import ports_table
from public_names import public, public_names
from source_comments import field_texts, has_fields
from tables import code, prose, table

_INDEX = """\
# Python API

What a notebook begins with is in `soft_gripper` itself, the rest in a namespace for each of its parts, such as
`sg.fingers`. Everything is typed, and loaded when it is first used.

```python
import soft_gripper as sg
```

Arrays have free leading axes unless their page says otherwise; SI units throughout. What a page calls `Array` is a
numpy array of floats, and `Planar` one of complex numbers z + i x in the bending plane.
"""


def api_pages() -> Iterator[tuple[str, str]]:
    """Where a page goes, and its Markdown: one for each public name, and their index."""
    yield "api/index.md", _index()
    for names in public_names().values():
        for name in names:
            yield f"api/{name}.md", _page(name)


def _index() -> str:
    parts = [_INDEX]
    for space, names in public_names().items():
        rows = [(f"[`{name}`]({name}.md)", prose(summary(name))) for name in names]
        parts += [f"## {f'sg.{space}' if space else 'sg'}", table(("name", ""), rows)]
    return "\n\n".join(parts) + "\n"


def summary(name: str) -> str:
    """The first sentence of a docstring."""
    value = public(name)
    if not (inspect.isclass(value) or inspect.isfunction(value)):
        return ""
    return (inspect.getdoc(value) or "").split("\n\n")[0].replace("\n", " ")


def _page(name: str) -> str:
    value, path = public(name), _source(name)
    where = f"From [{path}](../files/{path}.md)."
    kind = "class" if inspect.isclass(value) else "function" if inspect.isfunction(value) else ""
    # Orphans: so many pages would dominate the table of contents, which is part of every page.
    parts = [f"---\norphan: true\n---\n\n# {name}", where]
    parts.append(
        _autodoc(kind, name)
        if kind
        else f":::{{container}} source\n\n```python\n{_assignment(name.rpartition('.')[2], ROOT / path)}\n```\n:::"
    )
    if has_fields(value):
        rows = [
            (code(text.name), code(text.type), code(text.default), prose(text.values), prose(text.comment))
            for text in field_texts(value)
        ]
        parts += ["## Fields", table(("field", "type", "default", "values", "meaning"), rows)]
    if value.__hash__ and value in example_blocks():
        parts += ["## Ports", "Sizes and names are those of an example.", ports_table(example_blocks()[value])]
    return "\n\n".join(parts) + "\n"


def _autodoc(kind: str, name: str) -> str:
    space, _, own = name.rpartition(".")
    return f"```{{eval-rst}}\n.. currentmodule:: {f'soft_gripper.{space}'.rstrip('.')}\n.. auto{kind}:: {own}\n```"


def _source(name: str) -> str:
    """The file in the repository that a public name is from, which the stub of its namespace says."""
    space, _, own = name.rpartition(".")
    folder = ROOT.joinpath("soft_gripper", *space.split("."))
    for node in ast.parse((folder / "__init__.pyi").read_text(encoding="utf-8")).body:
        if isinstance(node, ast.ImportFrom) and node.module and own in [alias.name for alias in node.names]:
            return str(folder.joinpath(*node.module.split(".")).with_suffix(".py").resolve().relative_to(ROOT))
    raise LookupError(name)


def _assignment(name: str, path: Path) -> str:
    """The lines of a file that give a name its value, with the comment above."""
    source = path.read_text(encoding="utf-8")
    lines = source.splitlines()
    node = next(node for node in ast.parse(source).body if name.rpartition(".")[2] in _assigned(node))
    begin = node.lineno - 1
    while lines[begin - 1].startswith("#"):
        begin -= 1
    return "\n".join(lines[begin : node.end_lineno])


def _assigned(node: Any) -> list[str]:
    targets = node.targets if isinstance(node, ast.Assign) else [getattr(node, "target", None)]
    return [target.id for target in targets if isinstance(target, ast.Name)]
