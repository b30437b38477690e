"""The how-to pages, and the pages that begin: what they show runs as it stands."""

from contextlib import nullcontext
from pathlib import Path

import matplotlib as mpl
import pytest
from here_executor import HereExecutor
from page_session import follow

import soft_gripper as sg

DOCS = Path(__file__).parents[3] / "docs"
PAGES = [*sorted((DOCS / "howto").glob("*.md")), DOCS / "start.md", DOCS / "sweeps.md", DOCS / "site" / "concepts.md"]


@pytest.mark.slow
@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.stem)
def test_what_a_page_shows_runs(page, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(sg.runs, "open_executor", lambda *_, **__: nullcontext(HereExecutor()))  # others test processes
    mpl.use("Agg")
    follow(page)
