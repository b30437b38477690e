"""What the site is put together from."""

import posixpath
import re

from links import site_path
from stage import repository_pages

MOST_IN_THE_SIDEBAR = 8  # of a caption, while all groups are folded


def tables_of_contents():
    """The entries of each table, by the page that it is on; all as places on the site."""
    for path, text in repository_pages().items():
        page = site_path(path)
        for block in re.findall(r"^```{toctree}\n(.*?)```", text, re.DOTALL | re.MULTILINE):
            lines = [line for line in block.splitlines() if line and not line.startswith(":")]
            entries = [re.sub(r".*<(.*)>", r"\1", line) for line in lines]  # with a title of their own, or without
            yield page, [posixpath.join(posixpath.dirname(page), entry) for entry in entries]


def test_the_sidebar_is_short_while_its_groups_are_folded():
    shown = [entries for page, entries in tables_of_contents() if page == "index.md"]
    assert len(shown) <= 4
    assert all(len(entries) <= MOST_IN_THE_SIDEBAR for entries in shown)
