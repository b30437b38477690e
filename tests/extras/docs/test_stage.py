"""What the site is put together from."""

import posixpath
import re

import pytest
from links import site_path
from overview import blocks, namespaces
from stage import repository_pages, shown_files

MOST_IN_THE_SIDEBAR = 8  # of a caption, while all groups are folded


def tables_of_contents():
    """The entries of each table, by the page that it is on; all as places on the site."""
    for path, text in repository_pages().items():
        page = site_path(path)
        for block in re.findall(r"^```{toctree}\n(.*?)```", text, re.DOTALL | re.MULTILINE):
            lines = [line for line in block.splitlines() if line and not line.startswith(":")]
            entries = [re.sub(r".*<(.*)>", r"\1", line) for line in lines]  # with a title of their own, or without
            yield page, [posixpath.join(posixpath.dirname(page), entry) for entry in entries]


def test_every_page_is_in_a_table_of_contents_once():
    entries = [entry for _, found in tables_of_contents() for entry in found]
    assert len(set(entries)) == len(entries)
    places = {site_path(path).removesuffix(".md") for path in repository_pages() if path.endswith(".md")}
    assert places - set(entries) == {"index"}
    assert "notebooks/*" in entries


def test_the_sidebar_is_short_while_its_groups_are_folded():
    shown = [entries for page, entries in tables_of_contents() if page == "index.md"]
    assert len(shown) <= 4
    assert all(len(entries) <= MOST_IN_THE_SIDEBAR for entries in shown)


@pytest.mark.slow
def test_the_reference_says_what_namespaces_and_blocks_are_for():
    sections = re.findall(r"^### (\S+)\n\n(.+)\n\n(.+)$", namespaces(), re.MULTILINE)
    assert ("sg.truth", "Ground truth from the simulation, against which estimates are scored.") in [
        s[:2] for s in sections
    ]
    assert all(names.count("](api/") for _, _, names in sections)
    assert "| [`estimators.FingerShape`](api/estimators.FingerShape.md) | The pose of one finger" in blocks()


def test_linked_files_and_folders_are_shown():
    pages = {
        "docs/a.md": "[a](../models/recordings) [b](finger.md) [c](peers.png)",
        "notebooks/b.ipynb": '{"cells": []}',
    }
    shown = shown_files(pages, {"api/x.md": "[x](../files/soft_gripper/signals.py.md)"})
    assert {"models/recordings", "models/recordings/clamped_beam.yaml", "soft_gripper/signals.py"} <= shown
    assert not {"docs/finger.md", "docs/peers.png"} & shown
