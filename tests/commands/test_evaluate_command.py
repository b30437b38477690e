"""soft-gripper evaluate: the whole evaluation once, its files, its tables, and the bars that they keep."""

import csv
import io
from collections.abc import Sequence
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pytest
import xarray as xr
from browser import open_offline
from command_line import Outcome, soft_gripper
from PIL import Image

from soft_gripper.diagrams.schema.scenario_file import dump_scenario, load_scenario
from soft_gripper.evaluation.csv_table import read_csv
from soft_gripper.evaluation.paper.evaluate import CONTACT, FREE, SCENARIOS
from soft_gripper.evaluation.paper.pose_table import PoseRow

SECTIONS = (1, 2, 3, 4)
OF_A_SCENARIO = {"scenario.yaml", "recording.nc", "metrics.csv", "forces.csv", "replay.html"}
FIGURES = {"fig5_free_bending", "fig6_pose_error", "fig7_fingertip_error", "force_estimate"}


PAGE_IS_LOADED = """
    const done = arguments[0];
    const wait = () => document.readyState === "complete" ? done() : setTimeout(wait, 50);
    wait();
"""
REPLAY_IS_DRAWN = """
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

    @property
    def rows(self) -> list[PoseRow]:
        return read_csv(self.folder / "metrics.csv", PoseRow)

    def errors(self, sections: int, scenarios: Sequence[str] = SCENARIOS) -> list[float]:
        return [r.pose_error_mm for r in self.rows if r.sections == sections and r.scenario in scenarios]


@pytest.fixture(scope="module")
def evaluated(tmp_path_factory: pytest.TempPathFactory) -> Evaluated:
    """One evaluation that all tests of this module look at."""
    folder = tmp_path_factory.mktemp("results") / "evaluation"
    return Evaluated(soft_gripper("evaluate", "--out", folder), folder)


def test_writes_tables_figures_and_a_folder_for_every_scenario(evaluated: Evaluated) -> None:
    assert evaluated.outcome.code == 0
    written = {path.name for path in evaluated.folder.iterdir()}
    drawn = {f"{figure}{ending}" for figure in FIGURES for ending in (".png", ".svg")}
    assert written >= {"metrics.csv", "forces.csv", *drawn, *SCENARIOS}
    assert not [path for path in evaluated.folder.rglob("*") if path.name.startswith(".")]
    for scenario in SCENARIOS:
        assert {path.name for path in (evaluated.folder / scenario).iterdir()} >= OF_A_SCENARIO


def test_every_file_that_is_named_is_there(evaluated: Evaluated) -> None:
    words = [word.strip(",") for word in evaluated.outcome.out.splitlines()[-1].split()]
    names = [word for word in words if word.endswith((".csv", ".html", ".svg", ".png"))]
    assert names
    assert [name for name in names if not (evaluated.folder / name).is_file()] == []


def test_a_row_for_every_finger_number_of_sensors_and_held_step(evaluated: Evaluated) -> None:
    with (evaluated.folder / "metrics.csv").open(newline="") as file:
        header, *records = csv.reader(file)
    columns = "scenario finger estimator belief sections pressure_kpa bend_angle_deg pose_error_mm tip_error_mm"
    assert header == columns.split()
    expected = []
    for name in SCENARIOS:
        with xr.open_dataset(evaluated.folder / name / "recording.nc", engine="scipy") as recording:
            fingers = [str(signal).removesuffix(".strain") for signal in recording if str(signal).endswith(".strain")]
        steps = load_scenario(name).pressure.steps["all"]
        expected += [
            (name, f, "arcs", "as simulated", str(n), p / 1e3) for f in fingers for n in SECTIONS for p in steps
        ]
    assert [(*record[:5], float(record[5])) for record in records] == expected


def test_prints_every_claim_and_all_hold(evaluated: Evaluated) -> None:
    out = evaluated.outcome.out
    assert out.count(" holds: ") >= 12
    assert "FAILS" not in out
    assert all(scenario in out for scenario in SCENARIOS)


def test_one_sensor_is_enough_for_free_bending(evaluated: Evaluated) -> None:
    assert max(evaluated.errors(1, [FREE])) < 3
    assert max(evaluated.errors(4, [FREE])) < 1
    assert max(row.bend_angle_deg for row in evaluated.rows if row.scenario == FREE) >= 120


def test_more_sensors_are_never_worse_than_one(evaluated: Evaluated) -> None:
    rounding = 1e-6
    for sections in SECTIONS[1:]:
        for more, one in zip(evaluated.errors(sections), evaluated.errors(1), strict=True):
            assert more <= one + rounding


def test_one_sensor_is_not_enough_in_contact(evaluated: Evaluated) -> None:
    assert max(evaluated.errors(1, CONTACT)) > 3
    assert max(evaluated.errors(4, CONTACT)) < 2.5


@pytest.fixture
def started(monkeypatch: pytest.MonkeyPatch) -> list[str]:
    """Names of the scenarios that the command is about to run; it is interrupted before the first one."""
    names: list[str] = []

    def interrupt(scenarios: Sequence[str], *_: object) -> None:
        names.extend(scenarios)
        raise KeyboardInterrupt

    monkeypatch.setattr("soft_gripper.commands.evaluate.run_scenarios", interrupt)
    return names


def test_interrupt_says_what_is_missing_and_how_to_go_on(started: list[str], tmp_path: Path) -> None:
    interrupted = soft_gripper("evaluate", "--out", tmp_path)
    assert interrupted.code == 130
    assert f"evaluate --out {tmp_path} --resume" in interrupted.out
    assert all(scenario in interrupted.out for scenario in started)
    assert set(started) == set(SCENARIOS)
    assert "Traceback" not in interrupted.err


def test_resume_runs_what_is_missing_or_was_another_scenario(started: list[str], tmp_path: Path) -> None:
    missing, changed, *finished = SCENARIOS
    for name in (changed, *finished):
        (tmp_path / name).mkdir()
        scenario = load_scenario(name, ["pressure.settle=9"] if name == changed else [])
        (tmp_path / name / "scenario.yaml").write_text(dump_scenario(scenario))
    soft_gripper("evaluate", "--out", tmp_path, "--resume")
    assert set(started) == {missing, changed}


def test_report_opens_offline_with_its_figures_and_replays(evaluated: Evaluated, tmp_path: Path) -> None:
    driver = open_offline(evaluated.folder / "report.html", tmp_path / "profile")
    try:
        driver.set_script_timeout(60)
        driver.execute_async_script(PAGE_IS_LOADED)
        widths = driver.execute_script("return [...document.images].map((i) => i.complete ? i.naturalWidth : 0)")
        assert len(widths) >= len(SCENARIOS) + len(FIGURES)
        assert min(widths) > 0
        assert len(driver.find_elements("css selector", "td.holds")) == len(
            driver.find_elements("css selector", "tr.claim")
        )
        for scene in driver.find_elements("css selector", ".scene"):
            driver.execute_script("arguments[0].scrollIntoView({block: 'center'})", scene)
            scene.find_element("css selector", "button").click()
            driver.execute_async_script(REPLAY_IS_DRAWN, scene)
            picture = Image.open(io.BytesIO(scene.find_element("css selector", ".stage").screenshot_as_png))
            assert np.asarray(picture.convert("L")).std() > 5, "the replay is blank"
        assert [entry for entry in driver.get_log("browser") if entry["level"] == "SEVERE"] == []
    finally:
        driver.quit()
