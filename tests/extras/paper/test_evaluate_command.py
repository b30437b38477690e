"""soft-gripper evaluate: the whole evaluation once, its files, its tables, and the bars that they keep."""

import io
from collections.abc import Sequence
from contextlib import redirect_stdout
from itertools import product
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pytest
from browser import open_offline
from command_line import Outcome, Terminal, soft_gripper
from PIL import Image

from soft_gripper.commands import main
from soft_gripper.extras.paper.claims import Claim
from soft_gripper.extras.paper.contact_table import ContactRow, contact_summary
from soft_gripper.extras.paper.evaluate import CAPTIONS, FREE, RUNS, SCENARIOS
from soft_gripper.extras.paper.page import Evaluation
from soft_gripper.extras.paper.pose_rows import estimator_rows
from soft_gripper.extras.paper.scenario_run import evaluated_scenario
from soft_gripper.files.output import atomic_folder
from soft_gripper.files.row_table import read_csv
from soft_gripper.runs.scores.poses import PoseRow
from soft_gripper.scenario.scenario_file import dump_scenario

pytestmark = pytest.mark.slow

SECTIONS = (1, 2, 3, 4)


PAGE_IS_LOADED = """
    const done = arguments[0];
    const wait = () => document.readyState === "complete" ? done() : setTimeout(wait, 50);
    wait();
"""
ANIMATION_IS_DRAWN = """
    const [scene, done] = arguments;
    const wait = () => {
      const page = scene.querySelector("iframe")?.contentWindow;
      const drawn = page?.document.querySelector("canvas") && page.eval("typeof viewer !== 'undefined'");
      drawn && page.eval("viewer.animator.duration > 0") ? setTimeout(done, 500) : setTimeout(wait, 50);
    };
    wait();
"""


class Evaluated(NamedTuple):
    """What the command printed, and the folder that it wrote."""

    outcome: Outcome
    folder: Path

    def errors(self, sections: int) -> list[float]:
        """Of all fingers in free bending, and of those that touch something in the others, mm."""
        contact = read_csv(self.folder / "contact.csv", ContactRow)
        bent = {(row.scenario, row.finger) for row in contact if row.touching_links or row.scenario == FREE}
        rows = [row for row in read_csv(self.folder / "metrics.csv", PoseRow) if row.sections == sections]
        return [row.pose_error_mm for row in estimator_rows(rows, "arcs") if (row.scenario, row.finger) in bent]


@pytest.fixture(scope="module")
def evaluated(tmp_path_factory: pytest.TempPathFactory) -> Evaluated:
    """One evaluation that all tests of this module look at."""
    folder = tmp_path_factory.mktemp("results") / "evaluation"
    return Evaluated(soft_gripper("evaluate", "--out", folder), folder)


@pytest.mark.published
def test_fingers_are_touched_in_contact_and_not_in_free_bending(evaluated: Evaluated) -> None:
    """A peg bends a finger both ways, and so does the irregular body, which is touched over a third of a finger."""
    free, *contact = contact_summary(read_csv(evaluated.folder / "contact.csv", ContactRow))
    assert [free.scenario, *(row.scenario for row in contact)] == list(SCENARIOS)
    assert (free.touching_links, free.contact_length_mm, free.sign_changes) == (0, 0, 0)
    assert all(row.touching_links >= 1 and row.contact_length_mm > 0 for row in contact)
    assert [row.sign_changes for row in contact if row.scenario.startswith("obstructed")] == [1, 1]
    (wrapped,) = (row for row in contact if row.scenario == "irregular_grasp")
    assert wrapped.sign_changes == 1
    assert wrapped.contact_length_mm >= 40


@pytest.mark.published
def test_prints_every_claim_and_all_hold(evaluated: Evaluated) -> None:
    out = evaluated.outcome.out
    assert out.count(" holds: ") >= 12
    assert "FAILS" not in out
    assert f"all {out.count(' holds: ')} claims hold" in out
    assert all(scenario in out for scenario in SCENARIOS)


POSES = [
    PoseRow(scenario, "finger", name, "as simulated", n, pressure, 0.0, part * scale / n, 2 * part * scale / n + 3)
    for (name, part), scenario, n in product((("arcs", 1.0), ("gaussian", 0.1)), SCENARIOS, SECTIONS)
    for pressure, scale in ((0.0, 0.0), (50.0, 1.0), (100.0, 5.0))
]
HOLDS = Claim("paper", "one sensor is within 3 mm", True, "2.42 mm")
FAILS = Claim("ours", "four sensors are within 1 mm", False, "1.20 mm")

CLAIMED = (HOLDS.text, FAILS.text)


def summarized(claims: list[Claim], folder: Path, monkeypatch: pytest.MonkeyPatch, out: io.StringIO) -> int:
    """Exit code of the command if the scenarios gave POSES and `claims`; it prints to `out`."""
    monkeypatch.setattr("soft_gripper.extras.paper.commands.evaluate.run_scenarios", lambda *_: None)
    monkeypatch.setattr(
        "soft_gripper.extras.paper.commands.evaluate.summarize", lambda _: Evaluation(POSES, [], claims)
    )
    with redirect_stdout(out):
        return main(["evaluate", "--out", str(folder)])


@pytest.mark.parametrize(
    ("claims", "code", "summary"),
    [
        ([HOLDS, HOLDS], 0, "all 2 claims hold"),
        ([HOLDS, FAILS], 1, "1 of 2 claims failed"),
        ([FAILS, HOLDS, FAILS], 1, "2 of 3 claims failed"),
    ],
)
def test_says_of_every_claim_what_it_is_and_fails_if_one_does(
    claims: list[Claim], code: int, summary: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    piped, terminal = io.StringIO(), Terminal()
    assert summarized(claims, tmp_path, monkeypatch, piped) == code
    assert summarized(claims, tmp_path, monkeypatch, terminal) == code
    text, colored = piped.getvalue(), terminal.getvalue()
    words = {True: "holds:", False: "FAILS:"}
    shown = [f"{claim.text} {claim.source} {words[claim.holds]} {claim.number}" for claim in claims]
    assert [" ".join(line.split()) for line in text.splitlines() if line.startswith(CLAIMED)] == shown
    assert summary in text.splitlines()
    assert "\033" not in text
    assert ("\033[31mFAILS\033[0m" in colored) == (f"\033[31m{summary}\033[0m" in colored) == bool(code)
    assert "\033[31mholds" not in colored
    assert colored.replace("\033[31m", "").replace("\033[0m", "") == text


def test_prints_means_over_the_steps_and_of_every_estimator(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Of 0, 1 and 5 mm divided by the number of sensors; at the tip twice that and 3 mm more."""
    out = io.StringIO()
    summarized([HOLDS], tmp_path, monkeypatch, out)
    lines = [line.split() for line in out.getvalue().splitlines()]
    for scenario in SCENARIOS:
        (means,) = (line[1:] for line in lines if line[:1] == [scenario])
        assert means == ["2.00", "1.00", "0.67", "0.50", "7.00", "5.00", "4.33", "4.00"]
        begin = next(i for i, line in enumerate(lines) if line[:1] == [f"{scenario}:"])
        assert lines[begin + 2][:2] == ["arcs", "2.000"]
        assert lines[begin + 3] == ["gaussian", "0.200", "0.100", "0.067", "0.050", "3.400", "3.200", "3.133", "3.100"]


@pytest.fixture
def started(monkeypatch: pytest.MonkeyPatch) -> list[str]:
    """Names of the scenarios that the command is about to run; it is interrupted before the first one."""
    names: list[str] = []

    def interrupt(scenarios: Sequence[str], *_: object) -> None:
        names.extend(scenarios)
        raise KeyboardInterrupt

    monkeypatch.setattr("soft_gripper.extras.paper.commands.evaluate.run_scenarios", interrupt)
    return names


def test_resume_runs_what_is_missing_or_was_another_scenario(started: list[str], tmp_path: Path) -> None:
    missing, changed, *finished = RUNS
    for name in (changed, *finished):
        scenario = evaluated_scenario(name)
        scenario.pressure.settle = 9.0 if name == changed else scenario.pressure.settle
        with atomic_folder(tmp_path / name) as partial:
            (partial / "scenario.yaml").write_text(dump_scenario(scenario))
    soft_gripper("evaluate", "--out", tmp_path, "--resume")
    assert set(started) == {missing, changed}


@pytest.mark.published
def test_report_opens_offline_with_its_figures_and_animations(evaluated: Evaluated, tmp_path: Path) -> None:
    driver = open_offline(evaluated.folder / "report.html", tmp_path / "profile")
    try:
        driver.set_script_timeout(60)
        driver.execute_async_script(PAGE_IS_LOADED)
        widths = driver.execute_script("return [...document.images].map((i) => i.complete ? i.naturalWidth : 0)")
        assert len(widths) >= len(SCENARIOS) + len(CAPTIONS) + 1
        assert min(widths) > 0
        assert len(driver.find_elements("css selector", "td.holds")) == len(
            driver.find_elements("css selector", "tr.claim")
        )
        scenes = driver.find_elements("css selector", ".scene")
        for scene in (scenes[0], scenes[-1]):  # each takes long to draw without a graphics card
            driver.execute_script("arguments[0].scrollIntoView({block: 'center'})", scene)
            scene.find_element("css selector", "button").click()
            driver.execute_async_script(ANIMATION_IS_DRAWN, scene)
            picture = Image.open(io.BytesIO(scene.find_element("css selector", ".stage").screenshot_as_png))
            assert np.asarray(picture.convert("L")).std() > 5, "the animation is blank"
            driver.execute_script("arguments[0].querySelector('iframe').remove()", scene)  # or it goes on drawing
        assert [entry for entry in driver.get_log("browser") if entry["level"] == "SEVERE"] == []
    finally:
        driver.quit()
