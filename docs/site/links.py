"""Rewrites the links of a page: pages stay pages, other files of the repository get a page that shows them."""

import json
import posixpath
import re
from collections.abc import Callable
from pathlib import Path

ROOT = Path(__file__).parents[2]
PICTURES = (".png", ".svg", ".webp", ".gif")
_PAGES = {"CHANGELOG.md": "changelog.md", "CONTRIBUTING.md": "contributing.md"}
_STUDY = re.compile(r"studies/\w+/README\.md$")  # the evidence beside a study
_FENCE = re.compile(r"^ *(```|~~~)")
_LINK = re.compile(r"(?<=\]\()([^()\s]+)(?=\))")
_CODE = re.compile(r"(`[^`]*`)")


def site_path(path: str) -> str:
    """Where a file or folder of the repository is on the site, before it is built; both relative, with slashes."""
    if path in _PAGES:
        return _PAGES[path]
    if _STUDY.match(path):
        return path
    if path.startswith("docs/") and path.endswith((".md", *PICTURES)):
        return path.removeprefix("docs/").removeprefix("site/")
    return path if path.endswith(".ipynb") else f"files/{path}.md"


def links(page: str, text: str) -> list[str]:
    """Targets of the links of a page of the repository, Markdown or a notebook, without those in code."""
    found: list[str] = []
    _change_page(page, text, lambda target: found.append(target) or target)
    return found


def linked_path(page: str, target: str) -> str | None:
    """Target of a link in the repository, relative to its root; None if it leads elsewhere.

    Both are relative paths with slashes, `target` to the page. What follows # is left out.
    """
    if re.match(r"\w+:", target) or target.startswith("#"):
        return None
    return posixpath.normpath(posixpath.join(posixpath.dirname(page), target.partition("#")[0]))


def on_site(page: str, text: str) -> str:
    """The text of a page of the repository with links that hold on the site."""

    def change(target: str) -> str:
        path = linked_path(page, target)
        if path is None:
            return target
        _, mark, anchor = target.partition("#")
        return posixpath.relpath(site_path(path), posixpath.dirname(site_path(page)) or ".") + mark + anchor

    return _change_page(page, text, change)


def _change_page(page: str, text: str, change: Callable[[str], str]) -> str:
    if not page.endswith(".ipynb"):
        return _change_links(text, change)
    notebook = json.loads(text)
    for cell in notebook["cells"]:
        if cell["cell_type"] == "markdown":
            cell["source"] = _change_links("".join(cell["source"]), change)
    return json.dumps(notebook)


def _change_links(text: str, change: Callable[[str], str]) -> str:
    """The Markdown with each link changed; code, fenced, indented or in a line, stays as it is."""
    lines, fence = [], ""
    for line in text.splitlines(keepends=True):
        mark = _FENCE.match(line)
        if mark and fence in ("", mark[1]):
            fence = "" if fence else mark[1]
        is_code = bool(fence) or line.startswith("    ")
        lines.append(line if is_code else _outside_code(line, change))
    return "".join(lines)


def _outside_code(line: str, change: Callable[[str], str]) -> str:
    parts = _CODE.split(line)
    return "".join(part if part.startswith("`") else _LINK.sub(lambda found: change(found[1]), part) for part in parts)
