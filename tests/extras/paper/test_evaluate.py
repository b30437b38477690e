"""The evaluation: whole folders or none, what is left to do, runs that repeat themselves, and Ctrl-C."""

from dataclasses import replace
from pathlib import Path

import pytest
from here_executor import HereExecutor
from refusals import refused

from soft_gripper.extras.paper.evaluate import (
    FREE,
    RUNS,
    SCENARIOS,
    run_scenarios,
    unfinished_runs,
)
from soft_gripper.extras.paper.scenario_run import evaluated_scenario, is_finished
from soft_gripper.files.output import atomic_folder
from soft_gripper.runs.scores.poses import PoseRow
from soft_gripper.scenario.scenario_file import dump_scenario, load_scenario


def test_unfinished_are_those_without_a_whole_folder_of_the_same_scenario(tmp_path):
    assert unfinished_runs(tmp_path) == list(RUNS)
    for name, gravity in ((RUNS[0], [0.0, 0.0, -9.81]), (RUNS[1], [0.0, 0.0, 0.0]), (RUNS[2], [0.0, 0.0, -9.81])):
        with atomic_folder(tmp_path / name) as partial:
            (partial / "scenario.yaml").write_text(dump_scenario(replace(evaluated_scenario(name), gravity=gravity)))
    assert unfinished_runs(tmp_path) == [RUNS[1], *RUNS[3:]]


@pytest.mark.parametrize("harm", ["missing", "truncated", "emptied", "other"])
def test_a_run_whose_results_were_harmed_is_unfinished(tmp_path, harm):
    with atomic_folder(tmp_path / FREE) as partial:
        (partial / "scenario.yaml").write_text(dump_scenario(evaluated_scenario(FREE)))
        (partial / "metrics.csv").write_text("a,b\n1,2\n")
    assert FREE not in unfinished_runs(tmp_path)
    results = tmp_path / FREE / "metrics.csv"
    if harm == "missing":
        results.unlink()
    else:
        results.write_text({"truncated": "a,b\n1", "emptied": "", "other": "a,b\n1,3\n"}[harm])
    assert unfinished_runs(tmp_path) == list(RUNS)


@pytest.mark.slow
def test_one_scenario_that_fails_stops_no_other(short, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    Path("bad.yaml").write_text(dump_scenario(load_scenario(short, ["models.0.segments=5"])))
    Path("good.yaml").write_text(dump_scenario(load_scenario(short)))
    advanced = []
    with refused("sections", 2):
        run_scenarios(["bad.yaml", "good.yaml"], tmp_path / "out", HereExecutor(), advanced.append)
    assert is_finished(tmp_path / "out" / "good.yaml", evaluated_scenario("good.yaml"))
    assert [path.name for path in (tmp_path / "out").iterdir()] == ["good.yaml"]
    assert advanced == pytest.approx([0.5, 0.5])


def pose_rows() -> list[PoseRow]:
    """Errors that differ in everything a row is of; those of a right finger are not to be shown but in free bending."""
    left = [
        PoseRow(scenario, "left", name, "as simulated", n, p, p, part * (1 + i) * p / n, (1 + i) * p / n + 100)
        for name, part in (("arcs", 1.0), ("gaussian", 0.5))
        for i, scenario in enumerate(SCENARIOS)
        for n in (1, 2, 3, 4)
        for p in (10.0, 20.0)
    ]
    wrong = {"finger": "right", "pose_error_mm": 1e3, "tip_error_mm": 1e3}
    return left + [replace(row, **wrong) for row in left if row.scenario != FREE]
