"""The report: its claims, in red where they fail, tables and figures are those of the rows of the evaluation."""

import re
from dataclasses import replace
from html import escape
from itertools import product
from pathlib import Path

import numpy as np
import pytest

from soft_gripper.extras.paper.claims import Claim
from soft_gripper.extras.paper.contact_table import ContactRow
from soft_gripper.extras.paper.differences import PaperDifference, TipErrors
from soft_gripper.extras.paper.evaluate import CAPTIONS
from soft_gripper.extras.paper.page import (
    PAPER,
    Evaluation,
    difference_figure,
    estimators_figure,
    write_report,
)
from soft_gripper.runs.scores.poses import PoseRow
from soft_gripper.runs.scores.steps import PhaseRow
from soft_gripper.scenario.scenario_file import load_scenario

HOLDS = Claim("paper", "one sensor is within 3 mm", True, "2.42 mm")
POSES = [
    PoseRow(
        "free_bending", "finger", name, "as simulated", n, pressure, 0.0, part * scale / n, 2 * part * scale / n + 3
    )
    for name, part in (("arcs", 1.0), ("gaussian", 0.1))
    for n in (1, 2, 3, 4)
    for pressure, scale in ((0.0, 0.0), (50.0, 1.0), (100.0, 5.0))
]
CONTACTS = [
    ContactRow("free_bending", "finger", 0.0, 0, 0.0, 0),
    ContactRow("box_grasp", "left", 50.0, 2, 15.04, 0),
    ContactRow("box_grasp", "right", 50.0, 1, 10.0, 1),
]
DIFFERENCES = [PaperDifference("Tip", "hardly depends", "falls to 0.13 mm", "joints & sensors")]
PHASES = [PhaseRow("close", 1.35, 1.113, 55.68, 139.39, 149.98), PhaseRow("lift", 2.0, 1.0, 55.0, -0.04, -9.0)]


def page_of(folder: Path, claims: list[Claim]) -> str:
    """The report of one scenario, of which the pictures and the animation are mere names."""
    scene = folder / "free_bending"
    scene.mkdir()
    for name in ("scene.png", "animation.html", "../phases.png", *(f"../{figure}.svg" for figure in CAPTIONS)):
        (scene / name).write_text(name)
    found = Evaluation(POSES, [], claims, CONTACTS, DIFFERENCES, PHASES, "done & well")
    write_report(folder, ["free_bending"], found, CAPTIONS, folder / "phases.png")
    return (folder / "report.html").read_text()


def rows_of(page: str, kind: str = "<tr") -> list[list[str]]:
    """Cells of the rows of its tables, without what is inside the tags."""
    found = re.findall(rf"{kind}[^>]*>(.*?)</tr>", page, flags=re.DOTALL)
    return [re.findall(r"<t[dh][^>]*>(.*?)</t[dh]>", row, flags=re.DOTALL) for row in found]


def test_names_and_descriptions_are_text_and_no_html(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Whatever a scenario calls itself: it runs no script and loads no picture of a stranger's."""
    hostile = "\"'><script>alert(1)</script><img src=x onerror=alert(2)>&"
    scenario = replace(load_scenario("free_bending"), description=hostile)
    monkeypatch.setattr("soft_gripper.extras.paper.page.load_scenario", lambda name: scenario)
    scripts = page_of(tmp_path, [HOLDS]).count("<script")
    name = hostile.replace("/", "-")  # which no folder's name has
    (tmp_path / "free_bending").rename(tmp_path / name)
    poses = [replace(row, scenario=name, finger=hostile, estimator=hostile) for row in POSES]
    contacts = [replace(row, scenario=name, finger=hostile) for row in CONTACTS]
    differences = [PaperDifference(hostile, hostile, hostile, hostile)]
    claims = [Claim(hostile, hostile, False, hostile)]
    phases = [replace(PHASES[0], phase=hostile)]
    found = Evaluation(poses, [], claims, contacts, differences, phases, hostile)
    write_report(tmp_path, [name], found, CAPTIONS, tmp_path / "phases.png")
    page = (tmp_path / "report.html").read_text()
    assert page.count("<script") == scripts
    assert "onerror=alert(2)>" not in page
    assert escape(hostile) in page


def test_tables_have_means_over_the_steps_the_most_of_contact_and_phases(tmp_path: Path) -> None:
    """Errors of 0, 1 and 5 mm divided by the number of sensors; at the tip twice that and 3 mm more."""
    means = ["2.00", "1.00", "0.67", "0.50", "7.00", "5.00", "4.33", "4.00"]
    page = page_of(tmp_path, [HOLDS])
    rows = rows_of(page)
    for expected in (
        ["Free bending", *means],
        ["Free bending: arcs", *means],
        ["gaussian", "0.20", "0.10", "0.07", "0.05", "3.40", "3.20", "3.13", "3.10"],
        ["Free bending", "0", "0", "no"],
        ["Box grasp", "2", "15", "yes"],
        ["close", "1.35", "1.11", "55.7", "139.4", "150.0"],
        ["lift", "2.00", "1.00", "55.0", "0.0", "-9.0"],
    ):
        assert expected in rows
    assert "Outcome, as estimated: <b>done &amp; well</b>" in page


SCENARIOS = ("free_bending", "box_grasp", "irregular_grasp")
SCALE = {"arcs": 1.0, "gaussian": 0.1}  # mm


def estimator_error(scenario: str, estimator: str, sections: int) -> float:
    return (1 + SCENARIOS.index(scenario)) * SCALE[estimator] / sections


ESTIMATOR_ROWS = [
    PoseRow(s, "finger", name, "as simulated", n, p, 0.0, estimator_error(s, name, n) * p, 99.0)
    for name, s, n, p in product(SCALE, SCENARIOS, (1, 2, 3), (0.5, 1.5))
]


def test_a_line_an_estimator_and_a_panel_a_scenario() -> None:
    figure = estimators_figure(ESTIMATOR_ROWS, SCENARIOS)
    for axes, scenario in zip(figure.axes, SCENARIOS, strict=False):
        assert axes.get_title() == scenario.replace("_", " ").capitalize()
        assert axes.get_yscale() == "log"
        for name in SCALE:
            (line,) = (line for line in axes.lines if line.get_label() == name)
            assert list(line.get_xdata()) == [1, 2, 3]
            assert list(line.get_ydata()) == pytest.approx([estimator_error(scenario, name, n) for n in (1, 2, 3)])
        assert any(list(line.get_ydata()) == [PAPER, PAPER] for line in axes.lines)


BEND = np.radians([0.0, 30.0, 60.0, 30.0])
SIZES = np.arange(16.0).reshape(4, 4) * 1e-3  # m, (sections, steps)
ERRORS = TipErrors((1, 2, 3, 4), SIZES, SIZES + 0.02, SIZES + 0.04)


@pytest.mark.parametrize(
    ("panel", "words", "errors"),
    [
        (0, "joints in the middles of the segments (here)", ERRORS.middles),
        (1, "joints where the segments begin", ERRORS.starts),
        (2, "joints in the middles, readings with 0.1 % noise", ERRORS.noisy),
    ],
)
def test_a_panel_shows_the_errors_of_its_chain(panel: int, words: str, errors: np.ndarray) -> None:
    """In mm against degrees; the second step of the same bend is left out."""
    axes = difference_figure(BEND, ERRORS).axes[panel]
    assert axes.get_title().replace("\n", " ") == words
    assert axes.get_xlabel() == "bend angle [degrees]"
    for n, line in enumerate(axes.lines):
        assert line.get_label() == str(n + 1)
        np.testing.assert_allclose(line.get_xdata(), [0, 30, 60])
        np.testing.assert_allclose(line.get_ydata(), 1e3 * errors[n, :3])
