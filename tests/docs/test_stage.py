"""What the site is put together from."""

import re

from links import ROOT, site_path
from stage import repository_pages, shown_files

INDEX = (ROOT / "docs" / "site" / "index.md").read_text(encoding="utf-8")


def test_every_page_is_in_the_tree_of_contents():
    entries = {line for block in re.findall(r"```{toctree}\n(.*?)```", INDEX, re.DOTALL) for line in block.splitlines()}
    places = {site_path(path).removesuffix(".md") for path in repository_pages() if path.endswith(".md")}
    assert places - entries == {"index"}
    assert "notebooks/*" in entries


def test_linked_files_and_folders_are_shown():
    pages = {
        "docs/a.md": "[a](../models/recordings) [b](finger.md) [c](peers.png)",
        "notebooks/b.ipynb": '{"cells": []}',
    }
    shown = shown_files(pages, {"api/x.md": "[x](../files/soft_gripper/signals.py.md)"})
    assert {"models/recordings", "models/recordings/clamped_beam.yaml", "soft_gripper/signals.py"} <= shown
    assert not {"docs/finger.md", "docs/peers.png"} & shown
