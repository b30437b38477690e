"""The links of the pages: they lead somewhere in the repository, and to the same place on the site."""

import re

import pytest
from links import ROOT, linked_path, links, site_path
from stage import repository_pages

PAGES = {**repository_pages(), "README.md": (ROOT / "README.md").read_text(encoding="utf-8")}
DRAWN = "docs/site/diagrams/"  # by the build
DELETED = tuple(f"{path}/" for path in ("studies", "tests/studies") if not (ROOT / path).is_dir())


def anchors(text):
    """Of the headings, as GitHub makes them and the site too."""
    headings = (re.sub(r"[^\w\- ]", "", heading.lower()) for heading in re.findall(r"^#+ (.*)$", text, re.MULTILINE))
    return {heading.strip().replace(" ", "-") for heading in headings}


@pytest.mark.parametrize("page", PAGES)
def test_links_lead_somewhere(page):
    for target in links(page, PAGES[page]):
        path = linked_path(page, target)
        if path is None or path.startswith((DRAWN, *DELETED)):
            continue
        assert (ROOT / path).exists(), target
        if "#" in target:
            assert target.partition("#")[2] in anchors(PAGES[path]), target


@pytest.mark.parametrize("page", PAGES)
def test_tests_that_a_page_names_are_there_and_run_as_it_says(page):
    """By `pytest -m MARKER FILE`, the file has a test with the marker."""
    named = re.findall(r"pytest(?: -m (\w+))? (tests/[\w/]+\.py)", PAGES[page])
    for marker, file in named:
        text = (ROOT / file).read_text(encoding="utf-8")
        assert not marker or f"mark.{marker}" in text, f"pytest -m {marker} {file}"


@pytest.mark.parametrize(
    ("path", "place"),
    [
        ("docs/finger.md", "finger.md"),
        ("docs/site/index.md", "index.md"),
        ("docs/howto/slip.md", "howto/slip.md"),
        ("docs/peers.png", "peers.png"),
        ("notebooks/03_force.ipynb", "notebooks/03_force.ipynb"),
        ("CHANGELOG.md", "changelog.md"),
        ("studies/hardware/README.md", "studies/hardware/README.md"),
        ("models/recordings", "files/models/recordings.md"),
        ("examples/own_diagram/own_sensor.py", "files/examples/own_diagram/own_sensor.py.md"),
    ],
)
def test_everything_has_a_place_on_the_site(path, place):
    assert site_path(path) == place
