"""`soft-gripper benchmark`: what it refuses, and the example of an estimator on recordings."""

import json
import os
from pathlib import Path

import pytest

from soft_gripper.benchmark.tasks import TASKS, missing_files
from soft_gripper.commands import main

EXAMPLES = Path(__file__).parents[2] / "examples"


def test_a_missing_folder_is_named(tmp_path, capsys):
    assert main(["benchmark", "--data", str(tmp_path / "nowhere")]) == 2
    assert "--data" in capsys.readouterr().err


def test_a_folder_without_recordings_is_told_where_they_are(tmp_path, capsys):
    assert main(["benchmark", "--data", str(tmp_path)]) == 2
    printed = capsys.readouterr()
    assert "has the files of no task" in printed.err
    assert all(task.source in printed.out for task in TASKS)


def test_an_estimator_that_does_not_exist_is_named(tmp_path, capsys):
    assert main(["benchmark", "--data", str(tmp_path), "--estimator", "nothing:here"]) == 2
    assert "--estimator" in capsys.readouterr().err


def test_the_example_is_scored_beside_the_baselines(tmp_path, monkeypatch):
    folder = Path(os.environ.get("SOFT_GRIPPER_DATA", "nowhere"))
    if any(missing_files(task, folder) for task in TASKS):
        pytest.skip("$SOFT_GRIPPER_DATA has no recordings")
    monkeypatch.syspath_prepend(EXAMPLES)
    out = tmp_path / "scores.json"
    assert (
        main(["benchmark", "--data", str(folder), "--estimator", "benchmark_estimator:linear", "--out", str(out)]) == 0
    )
    scores = json.loads(out.read_text())["scores"]
    assert {score["estimator"] for score in scores} == {"ridge", "nearest", "benchmark_estimator:linear"}
