"""`python -m studies benchmark`: what it refuses, and the example of an estimator on recordings."""

import json
import os
from pathlib import Path

import pytest

from soft_gripper.commands import main
from studies.benchmark.benchmark_task import missing_files
from studies.benchmark.report import SHOWN_UNITS
from studies.benchmark.tasks import TASKS
from studies.commands import STUDIES

EXAMPLES = Path(__file__).parents[3] / "examples"
RECORDINGS = Path(os.environ.get("SOFT_GRIPPER_DATA", "nowhere"))


def test_a_missing_folder_is_named(tmp_path, capsys):
    assert main(["benchmark", "--data", str(tmp_path / "nowhere")], STUDIES) == 2
    assert "--data" in capsys.readouterr().err


SHIPPED = {"contact_tip", "contact_force", "contact_place", "contact_transverse", "grasp_shape", "grasp_new"}


def scored(tmp_path, *arguments):
    out = tmp_path / "scores.json"
    assert main(["benchmark", "--out", str(out), *arguments], STUDIES) == 0
    found = json.loads(out.read_text())["scores"]
    return {(score["task"], score["region"], score["estimator"]): score for score in found}


@pytest.fixture(autouse=True, scope="module")
def no_data_of_the_user():
    """What the environment names is not looked at."""
    with pytest.MonkeyPatch.context() as patch:
        patch.delenv("SOFT_GRIPPER_DATA", raising=False)
        yield


@pytest.fixture(scope="module")
def shipped_file(tmp_path_factory, no_data_of_the_user):
    folder = tmp_path_factory.mktemp("benchmark")
    scored(folder)
    return folder / "scores.json"


@pytest.fixture(scope="module")
def shipped(shipped_file):
    found = json.loads(shipped_file.read_text())["scores"]
    return {(score["task"], score["region"], score["estimator"]): score for score in found}


@pytest.fixture(scope="module")
def recorded(tmp_path_factory):
    if any(missing_files(task, RECORDINGS) for task in TASKS if task.folder is None):
        pytest.skip("$SOFT_GRIPPER_DATA has no recordings")
    arguments = ["--data", str(RECORDINGS), "benchmark_estimator:with_memory"]
    with pytest.MonkeyPatch.context() as patch:
        patch.syspath_prepend(EXAMPLES)
        return scored(tmp_path_factory.mktemp("benchmark"), *arguments)


DOCS = Path(__file__).parents[3] / "docs" / "studies"
LEADERS = Path(__file__).parents[3] / "studies" / "benchmark" / "README.md"


def reference():
    """The results that ship with the documentation, by task, region and estimator."""
    found = json.loads((DOCS / "benchmark.json").read_text())["scores"]
    return {(score["task"], score["region"], score["estimator"]): score for score in found}


def number(score, of):
    """In mm, N, g or %."""
    return f"{SHOWN_UNITS.get(score['unit'], (1.0, ''))[0] * score[of]:.3g}"


def test_the_table_in_the_docs_has_who_leads_in_the_reference_results():
    lines = [
        line
        for line in LEADERS.read_text(encoding="utf-8").partition("## Recognition")[0].splitlines()
        if line.startswith("| ")
    ]
    _, *rows = [[each.strip() for each in line.strip("|").split("|")] for line in lines if line.count("|") == 6]
    tasks = {}
    for (task, region, name), score in reference().items():
        tasks.setdefault(task, {}).setdefault(region, {})[name] = score
    assert [row[0] for row in rows] == [*tasks]
    for (_, *cells), regions in zip(rows, tasks.values(), strict=True):
        best = [min(of.values(), key=lambda score: score["proper"]) for of in regions.values()]
        leads = [f"`{score['estimator']}`" for score in best]
        assert cells == [
            ", ".join(regions),
            ", ".join(leads[:1] if len({*leads}) == 1 else leads),
            ", ".join(number(score, "mean") for score in best),
            ", ".join(number(of["nearest"], "mean") for of in regions.values()),
        ]


def assert_as_the_reference(scores, rel):
    for key, score in scores.items():
        expected = reference()[key]
        for of in ("mean", "median", "percentile_95", "proper", "band"):
            assert score[of] == (None if expected[of] is None else pytest.approx(expected[of], rel=rel)), key
        for of in ("within_band_percent", "unknown_percent"):
            assert score[of] == (None if expected[of] is None else pytest.approx(expected[of], abs=50 * rel)), key


@pytest.mark.slow
def test_shipped_data_give_the_reference_results(shipped):
    assert shipped.keys() == {key for key in reference() if key[0] in SHIPPED}
    assert_as_the_reference(shipped, rel=0.02)


@pytest.mark.slow
def test_recordings_give_the_reference_results(recorded):
    ours = {key: score for key, score in recorded.items() if not key[2].startswith("benchmark_estimator")}
    assert ours.keys() == reference().keys()
    assert_as_the_reference(ours, rel=0.05)


ROW = {"task": "contact_tip", "region": "middle", "estimator": "it", "samples": 1, "unit": "m", "mean": 1.0}
ROW |= {"median": 1.0, "percentile_95": 1.0, "proper": 1.0, "within_band_percent": None, "band": None}


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("{}", "was not written by"),
        ("nothing", "cannot be read as JSON"),
        ("[" * 100_000, "depth = 'more than 40'"),
        ('{"benchmark": 2, "benchmark": 2}', "appears more than once"),
        (json.dumps({"benchmark": 2, "sha256": {}, "scores": [ROW | {"mean": float("nan")}]}), "NaN is not a number"),
        (
            json.dumps({"benchmark": 2, "sha256": {}, "scores": [ROW | {"mean": 10**400}]}),
            "a whole number of 401 digits",
        ),
        ('{"schema": 2, "sha256": {}, "scores": []}', "must be 2: score again"),
        ('{"benchmark": 2, "sha256": {}, "scores": 3}', "was not written by"),
        ('[{"benchmark": 2}]', "was not written by"),
        ('{"benchmark": 2, "sha256": {"contact_tip": {}}, "scores": []}', "other data"),
        ('{"benchmark": 2, "sha256": {}, "scores": [{"task": "contact_tip"}]}', "fields of a score"),
        (f'{{"benchmark": 2, "sha256": {{}}, "scores": [{json.dumps(ROW | {"mean": "small"})}]}}', "scores: mean"),
        (f'{{"benchmark": 2, "sha256": {{}}, "scores": [{json.dumps(ROW | {"task": 3})}]}}', "scores: task"),
    ],
)
def test_files_that_cannot_be_compared(tmp_path, capsys, text, said):
    (tmp_path / "other.json").write_text(text)
    assert main(["benchmark", "--compare", str(tmp_path / "other.json")], STUDIES) == 2
    assert said in capsys.readouterr().err


def test_mistakes_of_a_users_estimator_are_named_before_others_run(tmp_path, monkeypatch, capsys):
    (tmp_path / "broken.py").write_text("def estimator(task, train):\n    return lambda inputs: inputs[:, :9]\n")
    monkeypatch.syspath_prepend(tmp_path)
    out = tmp_path / "scores.json"
    assert main(["benchmark", "--out", str(out), "broken:estimator"], STUDIES) == 2
    error = capsys.readouterr().err
    assert "broken:estimator" in error
    assert "contact_tip" in error
    assert not out.exists()
