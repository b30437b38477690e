"""README and the pages, read as GitHub reads them (CommonMark): no markup is left in what a reader sees."""

import re
from itertools import takewhile

import pytest
from links import ROOT
from markdown_it import MarkdownIt
from stage import repository_pages

PAGES = {path: text for path, text in repository_pages().items() if path.endswith(".md")}
PAGES["README.md"] = (ROOT / "README.md").read_text(encoding="utf-8")
MARKUP = re.compile(r"\*\*|`|\]\(|^#+ |^[-|] ", re.MULTILINE)
# Pages without pictures and commands: decisions, and what not to rely on.
IN_WORDS = {"docs/limitations.md", *(page for page in PAGES if page.startswith("docs/decisions/"))}
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


@pytest.mark.parametrize(
    ("text", "count"),
    [
        ("- <!-- make --> **Bold** and `code`\n", 1),  # a block of HTML to the end of the line
        ("- <!-- make -->\n  **Bold** and `code`\n", 0),
        ("<p>\n`code`\n</p>\n", 1),
        ("**Bold and 2 * 3\n", 1),
        ("`**` is bold, <b>this</b> too\n", 0),
        ("a [link] (elsewhere) and [another](there\n", 1),
        ("| a |\n|---|\n| b |\n\n| c |\n", 1),  # a row that has lost its table
    ],
)
def test_markup_that_is_left_is_found(text, count):
    assert len(stray(text)) == count


@pytest.mark.parametrize("page", [page for page in PAGES if page.startswith("docs/") and page not in IN_WORDS])
def test_a_page_begins_with_a_picture_or_a_command(page):
    """After two or three lines that say what it is for."""
    _, *lines = PAGES[page].splitlines()
    before = takewhile(lambda line: not re.match(r"!\[| {4}\S|```|:::|\|", line), lines)
    assert len(" ".join(before).split()) <= 75
