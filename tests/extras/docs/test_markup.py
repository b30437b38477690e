"""README and the pages, read as GitHub reads them (CommonMark).

No markup is left in what a reader sees, and code is not cut off where it is shown.
"""

import json
import re

import pytest
from links import ROOT
from markdown_it import MarkdownIt
from stage import repository_pages

PAGES = {path: text for path, text in repository_pages().items() if path.endswith(".md")}
PAGES["README.md"] = (ROOT / "README.md").read_text(encoding="utf-8")
READMES = sorted(path for folder in ("soft_gripper", "examples", "models") for path in (ROOT / folder).rglob("*.md"))
SHOWN = {**PAGES, **{path.relative_to(ROOT).as_posix(): path.read_text(encoding="utf-8") for path in READMES}}
CODE_COLUMNS = 76  # of a block of code or output: a page of the site shows 90, in a list fewer
MARKUP = re.compile(r"\*\*|`|\]\(|^#+ |^[-|] ", re.MULTILINE)
UNSEEN = re.compile(r"<!--.*?-->|</?[a-z][^>]*>", re.DOTALL)  # comments and tags


def seen(tokens):
    """The text of a page, without code."""
    for token in tokens:
        if token.type in ("text", "html_block", "html_inline"):
            yield UNSEEN.sub("", token.content) if token.type != "text" else token.content
        yield from seen(token.children or ())


def stray(text):
    """Texts of a page in which markup is left."""
    return [found for found in seen(MarkdownIt("commonmark").enable("table").parse(text)) if MARKUP.search(found)]


@pytest.mark.parametrize("page", PAGES)
def test_a_page_shows_no_markup(page):
    assert stray(PAGES[page]) == []


def wide(text):
    """Line numbers and lines of a page's blocks of code that are too long."""
    for token in MarkdownIt("commonmark").enable("table").parse(text):
        if token.type in ("fence", "code_block"):
            first = token.map[0] + (2 if token.type == "fence" else 1)
            for number, line in enumerate(token.content.splitlines(), first):
                if len(line) > CODE_COLUMNS:
                    yield number, line


@pytest.mark.parametrize("page", SHOWN)
def test_code_is_not_wider_than_a_page(page):
    found = [f"{page}:{number}: {line}" for number, line in wide(SHOWN[page])]
    assert not found, "\n".join(found)


@pytest.mark.parametrize("notebook", [page for page in repository_pages() if page.endswith(".ipynb")])
def test_what_a_notebook_shows_is_not_wider_than_a_page(notebook):
    """Code, which ruff checks too, what it prints, and code in the text."""
    found = []
    for i, cell in enumerate(json.loads(repository_pages()[notebook])["cells"]):
        source = "".join(cell["source"])
        printed = "".join("".join(output.get("text", "")) for output in cell.get("outputs", ()))
        lines = [*source.splitlines(), *printed.splitlines()]
        if cell["cell_type"] == "markdown":
            lines = [line for _, line in wide(source)]
        found += [f"{notebook}: cell {i}: {line}" for line in lines if len(line) > CODE_COLUMNS]
    assert not found, "\n".join(found)
