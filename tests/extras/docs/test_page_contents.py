"""What pages say is what the code gives: how-to pages, grasps, slips, scenarios, the schema."""

import re
from contextlib import nullcontext
from pathlib import Path

import matplotlib as mpl
import pytest
from command_line import soft_gripper
from here_executor import HereExecutor
from page_session import follow
from printed_numbers import printed
from scenario_pages import STORED, stored_criteria
from schema_page import field_names, scenario_classes, schema_page

import soft_gripper as sg
from soft_gripper.extras.sweeps.measured_runs import run_and_measure
from soft_gripper.runs.success import success_criteria, success_rows
from soft_gripper.truth.contact import combined_friction

DOCS = Path(__file__).parents[3] / "docs"
PAGES = [*sorted((DOCS / "howto").glob("*.md")), DOCS / "start.md", DOCS / "sweeps.md", DOCS / "site" / "concepts.md"]


@pytest.mark.slow
@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.stem)
def test_what_a_page_shows_runs(page, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(
        sg.extras.sweeps, "open_executor", lambda *_, **__: nullcontext(HereExecutor())
    )  # others test processes
    mpl.use("Agg")
    follow(page)


PAGE = (Path(__file__).parents[3] / "docs" / "grasp_quality.md").read_text(encoding="utf-8")
LENGTH, MODULUS = "models.gripper.fingers.all.length", "models.gripper.fingers.all.youngs_modulus"

WEIGHT = 0.06 * 9.81  # N, carried by two fingers
FRICTION = combined_friction(0.8, 0.9)  # of the bottle and the fingers


@pytest.mark.published
def test_the_corners_of_the_sweep():
    """Least and most force; what lies between is in the figure."""
    first = printed(PAGE, r"\| 100 \| (.*) N, (.*) % \|.*\|.*\|")
    last = printed(PAGE, r"\| 140 \|.*\|.*\| (.*) N, (.*) % \|")
    for length, modulus, numbers in ((0.10, "-30 %", first), (0.14, "+30 %", last)):
        found = run_and_measure("bottle_grasp", {LENGTH: length, MODULUS: modulus})
        assert found["grasp"] == "held"
        assert f"{found['normal_force_n']:.2f}" == numbers[0]
        assert f"{100 * found['slip_ratio']:.0f}" == numbers[1]
        assert f"takes {found['least_force_n']:.2f} N per finger" in PAGE
        assert found["friction_force_n"] == pytest.approx(WEIGHT / 2, rel=1e-3)
        assert found["least_force_n"] == pytest.approx(WEIGHT / 2 / FRICTION, rel=1e-3)


SLIP_PAGE = (Path(__file__).parents[3] / "docs" / "howto" / "slip.md").read_text(encoding="utf-8")


@pytest.mark.published
def test_the_run_prints_what_the_page_shows(tmp_path):
    command = re.search(r"^    soft-gripper (run .*)$", SLIP_PAGE, re.MULTILINE)[1].split()
    shown = re.search(r"^```text\n(.*?)^```$", SLIP_PAGE, re.MULTILINE | re.DOTALL)[1].splitlines()
    found = soft_gripper(*command, "--out", tmp_path).out.splitlines()
    assert [line for line in shown if line != "..." and line not in found] == []


LARGEST = 30e3  # bytes of a picture
QUICKEST = "tip_distance_steps"


@pytest.mark.parametrize("name", sg.scenario_names())
def test_a_scenario_meets_its_criteria(name):
    """As `make scenarios` has found; of other criteria than those of the file nothing is kept."""
    rows = stored_criteria(name)
    assert [row["criterion"] for row in rows] == success_criteria(sg.load_scenario(name))
    assert all(row["met"] == "True" for row in rows)
    assert 0 < (STORED / f"{name}.webp").stat().st_size < LARGEST


@pytest.mark.parametrize(
    "name",
    [
        pytest.param(name, marks=pytest.mark.slow if name == QUICKEST else pytest.mark.published)
        for name in sg.scenario_names()
    ],
)
def test_what_is_kept_is_what_a_run_gives(name):
    station = sg.make_station(sg.load_scenario(name))
    rows = success_rows(station, sg.run_station(station))
    for row, kept in zip(rows, stored_criteria(name), strict=True):
        assert (row.criterion, str(row.met)) == (kept["criterion"], kept["met"])
        try:
            assert float(row.measured) == pytest.approx(float(kept["measured"]), rel=0.02)
        except ValueError:
            assert row.measured == kept["measured"]


SECTIONS = {part.partition("\n")[0]: part for part in schema_page().split("\n## ")[1:]}


@pytest.mark.parametrize("cls", scenario_classes(), ids=lambda cls: cls.__name__)
def test_every_field_is_listed(cls):
    listed = re.findall(r"^\| `(\w+)` \|", SECTIONS[cls.__name__], re.MULTILINE)
    assert listed == field_names(cls)
