"""Submissions: what an estimator states of every test sample, scored without its code."""

import json
from dataclasses import replace

import pytest
from study_line import study_line

from studies.benchmark import tasks
from studies.benchmark.benchmark_task import Part, read_tests
from studies.benchmark.submission import read_submission
from studies.commands import benchmark

QUICK = """def estimator(task, train):
    mean = sum(recorded.outputs.mean(axis=0) for recorded in train) / len(train)
    return lambda inputs: (inputs[:, :1] * 0 + mean, inputs[:, :1] * 0 + abs(mean) + 0.1)
"""


@pytest.fixture(scope="module")
def submitted(tmp_path_factory):
    """A submission of an estimator that shipped data were given, the scores beside it, and what was printed."""
    folder = tmp_path_factory.mktemp("submission")
    (folder / "quick.py").write_text(QUICK)
    with pytest.MonkeyPatch.context() as patch:
        patch.delenv("SOFT_GRIPPER_DATA", raising=False)
        patch.setattr(benchmark, "TASKS", tasks.TASKS[1:5])
        patch.setattr(benchmark, "baselines", lambda question: {})
        patch.setattr(benchmark, "ours", lambda task: {})
        patch.setattr(benchmark, "save_figure", lambda figure, path: None)
        how = [f"{folder / 'quick.py'}:estimator", "--submit", folder / "mine.json"]
        outcome = study_line("benchmark", *how, "--out", folder / "scores.json")
        assert outcome.code == 0, outcome.err
        (folder / "quick.py").unlink()
        yield folder


def scored(submitted, file):
    return study_line("benchmark", "--score", file, "--out", submitted / "check_estimate.json")


def test_scores_are_those_of_the_estimator_without_its_code(submitted):
    outcome = scored(submitted, submitted / "mine.json")
    assert outcome.code == 0, outcome.err
    mine, theirs = (json.loads((submitted / f"{name}.json").read_text()) for name in ("scores", "check_estimate"))
    assert mine["sha256"] == theirs["sha256"]
    assert len(theirs["scores"]) == 3 + 3 + 3 + 4
    for row, expected in zip(theirs["scores"], mine["scores"], strict=True):
        numbers = {key for key, value in expected.items() if isinstance(value, float)}
        assert {key: row[key] for key in numbers} == pytest.approx({key: expected[key] for key in numbers}, rel=1e-5)
        assert all(row[key] == expected[key] for key in expected.keys() - numbers)


def test_a_recording_that_was_kept_back_from_the_submitter_is_left_out(submitted):
    (task,) = (task for task in tasks.TASKS if task.name == "contact_force")
    later = {**task.tested, "later": (Part("later.csv"),)}
    with_later = replace(task, sha256={**task.sha256, "later.csv": "0"}, tested=later, further=("later",))
    tested = read_tests(task, task.folder)
    stated = read_submission(submitted / "mine.json").answers(with_later, {**tested, "later": []})
    assert [*stated] == [*tested]


def shorter(found):
    found["tasks"]["contact_force"]["regions"]["middle"][0]["mean"].pop()


def not_a_number(found):
    found["tasks"]["contact_force"]["regions"]["middle"][0]["mean"][3] = [float("nan")]


def negative(found):
    found["tasks"]["contact_force"]["regions"]["middle"][0]["std"][3] = [-1.0]


def without_a_region(found):
    del found["tasks"]["contact_force"]["regions"]["middle"]


def of_other_data(found):
    found["tasks"]["contact_force"]["sha256"]["contacts_test.csv"] = "0" * 64


def of_another_version(found):
    found["benchmark"] = 1


def not_a_list(found):
    found["tasks"]["contact_force"]["regions"]["middle"] = 3


def not_an_object(found):
    found["tasks"]["contact_force"] = []


def of_nothing(found):
    found["tasks"] = {}


@pytest.mark.parametrize(
    ("change", "said"),
    [
        (shorter, "must be (100, 1)"),
        (not_a_number, "NaN is not a number of JSON"),
        (negative, "must not be negative"),
        (without_a_region, "near base, middle, near tip"),
        (of_other_data, "contact_force.sha256.contacts_test.csv"),
        (of_another_version, "must be 2"),
        (not_a_list, "must be a list of 1 parts"),
        (not_an_object, "must be an object"),
        (of_nothing, "has no task whose data are there"),
    ],
)
def test_submissions_that_do_not_fit_are_refused(submitted, change, said):
    found = json.loads((submitted / "mine.json").read_text())
    change(found)
    (submitted / "theirs.json").write_text(json.dumps(found))
    outcome = scored(submitted, submitted / "theirs.json")
    assert outcome.code == 2
    assert said in outcome.err
    assert "Traceback" not in outcome.err
