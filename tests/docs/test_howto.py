"""The how-to pages, and the pages that begin: what they show runs as it stands."""

from pathlib import Path

import matplotlib as mpl
import pytest
from page_session import follow

DOCS = Path(__file__).parents[2] / "docs"
PAGES = [*sorted((DOCS / "howto").glob("*.md")), DOCS / "start.md", DOCS / "site" / "concepts.md"]


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.stem)
def test_what_a_page_shows_runs(page, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    mpl.use("Agg")
    follow(page)
