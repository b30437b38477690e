"""What the reference page lists: the namespaces with their names, and the blocks with a line each."""

import inspect
from collections.abc import Iterator

from api_pages import summary
from example_blocks import example_blocks
from public_names import public, public_names
from tables import prose, table

_TOP = "What a notebook begins with: scenarios, stations, simulation, recordings, and the four blocks."


def namespaces() -> str:
    """Markdown, a section for each namespace: what it is for, and its names."""
    return "\n".join(_namespace(space, names) for space, names in public_names().items())


def blocks() -> str:
    """A Markdown table of the blocks that are public names, by namespace."""
    rows = [(f"[`{name}`](api/{name}.md)", prose(summary(name))) for name in _public_blocks()]
    return table(("block", ""), rows)


def _namespace(space: str, names: list[str]) -> str:
    text = (inspect.getdoc(public(space)) if space else _TOP) or ""
    listed = ", ".join(f"[`{name.rpartition('.')[2]}`](api/{name}.md)" for name in names)
    return f"### {f'sg.{space}' if space else 'sg'}\n\n{prose(text)}\n\n{listed}\n"


def _public_blocks() -> Iterator[str]:
    for names in public_names().values():
        yield from (name for name in names if public(name).__hash__ and public(name) in example_blocks())
