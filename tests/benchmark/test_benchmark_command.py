"""`soft-gripper benchmark`: what it refuses, and the example of an estimator on recordings."""

import json
import os
from pathlib import Path

import pytest

from soft_gripper.benchmark.tasks import TASKS, missing_files
from soft_gripper.commands import main

EXAMPLES = Path(__file__).parents[2] / "examples"
RECORDINGS = Path(os.environ.get("SOFT_GRIPPER_DATA", "nowhere"))


def test_a_missing_folder_is_named(tmp_path, capsys):
    assert main(["benchmark", "--data", str(tmp_path / "nowhere")]) == 2
    assert "--data" in capsys.readouterr().err


SHIPPED = {"contact_tip", "contact_force", "contact_place"}


def scored(tmp_path, *arguments):
    out = tmp_path / "scores.json"
    assert main(["benchmark", "--out", str(out), *arguments]) == 0
    found = json.loads(out.read_text())["scores"]
    return {(score["task"], score["region"], score["estimator"]): score for score in found}


@pytest.fixture(autouse=True, scope="module")
def no_data_of_the_user():
    """What the environment names is not looked at."""
    with pytest.MonkeyPatch.context() as patch:
        patch.delenv("SOFT_GRIPPER_DATA", raising=False)
        yield


@pytest.fixture(scope="module")
def shipped(tmp_path_factory, no_data_of_the_user):
    return scored(tmp_path_factory.mktemp("benchmark"))


@pytest.fixture(scope="module")
def recorded(tmp_path_factory):
    if any(missing_files(task, RECORDINGS) for task in TASKS if task.folder is None):
        pytest.skip("$SOFT_GRIPPER_DATA has no recordings")
    arguments = ["--data", str(RECORDINGS), "--estimator", "benchmark_estimator:linear"]
    with pytest.MonkeyPatch.context() as patch:
        patch.syspath_prepend(EXAMPLES)
        return scored(tmp_path_factory.mktemp("benchmark"), *arguments)


def test_contacts_that_ship_are_scored_without_data(shipped):
    assert {task for task, _, _ in shipped} == SHIPPED
    assert {name for task, _, name in shipped if task == "contact_tip"} == {
        *("ridge", "nearest", "arcs", "gaussian", "contact")
    }


def documented():
    """The rows of the table in docs/benchmark.md, by task, region and estimator."""
    lines = (Path(__file__).parents[2] / "docs/benchmark.md").read_text().splitlines()
    rows = [[cell.strip() for cell in line.strip("|").split("|")] for line in lines if line.startswith("| ")]
    return {tuple(row[:3]): row[3:] for row in rows if len(row) == 7 and row[0] != "task"}


def assert_as_documented(scores):
    """In mm, N and g."""
    for key, score in scores.items():
        *errors, band = documented()[key]
        factor = 1e3 if score["unit"] == "m" else 1.0
        expected = [factor * score[of] for of in ("mean", "median", "percentile_95")]
        assert [float(error) for error in errors] == pytest.approx(expected, rel=0.02)
        if band == "none":
            assert score["within_band_percent"] is None
        else:
            assert float(band) == pytest.approx(score["within_band_percent"], abs=0.6)


def test_numbers_in_the_docs(shipped):
    assert_as_documented(shipped)


def test_numbers_of_recordings_in_the_docs(recorded):
    ours = {key: score for key, score in recorded.items() if key[2] != "benchmark_estimator:linear"}
    assert ours.keys() == documented().keys()
    assert_as_documented(ours)


def test_what_is_missing_is_where_it_is(tmp_path, capsys):
    scored(tmp_path, "--data", str(tmp_path))
    said = capsys.readouterr().err
    assert all(task.source in said for task in TASKS if task.name not in SHIPPED)


def test_results_are_compared(tmp_path, capsys):
    scored(tmp_path)
    file = str(tmp_path / "scores.json")
    assert main(["benchmark", "--compare", file, file]) == 0
    printed = capsys.readouterr().out
    assert printed.count("scores: contact ") == 2 * 9 - 9  # the same name in both files
    assert "contact_force, near tip [N]" in printed


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("{}", "was not written by"),
        ("nothing", "was not written by"),
        ('{"schema": 7, "sha256": {}, "scores": []}', "schema"),
        ('{"schema": 1, "sha256": {"contact_tip": {}}, "scores": []}', "other data"),
    ],
)
def test_files_that_cannot_be_compared(tmp_path, capsys, text, said):
    (tmp_path / "other.json").write_text(text)
    assert main(["benchmark", "--compare", str(tmp_path / "other.json")]) == 2
    assert said in capsys.readouterr().err


def test_an_estimator_that_does_not_exist_is_named(tmp_path, capsys):
    assert main(["benchmark", "--data", str(tmp_path), "--estimator", "nothing:here"]) == 2
    assert "--estimator" in capsys.readouterr().err


def test_the_example_is_scored_beside_the_baselines(recorded):
    assert {name for task, _, name in recorded if task == "arm_tip"} == {
        "ridge",
        "nearest",
        "benchmark_estimator:linear",
    }
