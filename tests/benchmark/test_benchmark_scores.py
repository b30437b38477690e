"""The benchmark's protocol and scores, on a synthetic twin of a recorded set."""

import hashlib
import json
import runpy
from pathlib import Path

import numpy as np
import pytest

from soft_gripper.benchmark.baselines import BASELINES
from soft_gripper.benchmark.report import document
from soft_gripper.benchmark.scores import score_task
from soft_gripper.benchmark.tasks import TASKS, Channel, Part, Recorded, Task, missing_files, read_task
from soft_gripper.errors import InputError

NOISE = 0.1


def recorded(seed, samples=4000):
    random = np.random.default_rng(seed)
    inputs = random.uniform(-1, 1, (samples, 2))
    outputs = np.stack([inputs[:, 0] + inputs[:, 1] ** 2, inputs[:, 0] * inputs[:, 1]], axis=1)
    return Recorded(inputs, outputs + NOISE * random.standard_normal(outputs.shape))


def read(path):
    table = np.loadtxt(path)
    return Recorded(table[:, :2], table[:, 2:])


@pytest.fixture
def twin(tmp_path):
    own = recorded(1)
    np.savetxt(tmp_path / "a.txt", np.hstack([own.inputs, own.outputs]))
    digest = hashlib.sha256((tmp_path / "a.txt").read_bytes()).hexdigest()
    channels = Channel("a", "V"), Channel("b", "V")
    tested = {"later": (Part("a.txt", 0.5),)}
    return Task("twin", "nowhere", {"a.txt": digest}, channels, channels, (Part("a.txt", end=0.5),), tested, read)


def score(task, folder, estimator):
    train, tested = read_task(task, folder)
    (row,) = score_task(task, "mine", estimator, train, tested)
    return row


def oracle(own, width=None):
    known = {tuple(x): y for x, y in zip(own.inputs, own.outputs, strict=True)}

    def predict(inputs):
        mean = np.array([known[tuple(x)] for x in inputs])
        return mean if width is None else (mean + NOISE, np.full_like(mean, width))

    return lambda task, train: predict


def test_an_oracle_has_no_error(twin, tmp_path):
    row = score(twin, tmp_path, oracle(read(tmp_path / "a.txt")))
    assert row.samples == 2000
    assert (row.mean, row.median, row.percentile_95, row.within_band_percent) == (0, 0, 0, None)


@pytest.mark.parametrize(("width", "within"), [(NOISE, 100), (NOISE / 3, 0)])
def test_a_band_is_as_wide_as_it_states(twin, tmp_path, width, within):
    row = score(twin, tmp_path, oracle(read(tmp_path / "a.txt"), width))
    assert row.within_band_percent == within
    assert row.mean == pytest.approx(NOISE * np.sqrt(2))


def test_ridge_finds_a_quadratic_law_and_its_noise(twin, tmp_path):
    row = score(twin, tmp_path, BASELINES["ridge"])
    assert row.mean == pytest.approx(NOISE * np.sqrt(np.pi / 2), rel=0.05)  # of a Rayleigh distribution
    assert row.within_band_percent == pytest.approx(95, abs=1.5)


def test_the_document_is_the_same_each_time(twin, tmp_path):
    one, other = (json.dumps(document([score(twin, tmp_path, BASELINES["nearest"])])) for _ in range(2))
    assert one == other


@pytest.mark.parametrize(
    ("predict", "message"),
    [
        (lambda inputs: inputs[:, :1], r"shape of mean on twin = \(2000, 1\): must be \(2000, 2\)"),
        (lambda inputs: np.nan * inputs, "must be finite"),
        (lambda inputs: (inputs, -np.ones_like(inputs)), "must not be negative"),
        (lambda inputs: inputs - inputs.mean(axis=0), "must use past inputs only"),
        (lambda inputs: "text", "must be numbers"),
        (lambda inputs: 1 / 0, "ZeroDivisionError"),
        (None, "must be a function"),
    ],
)
def test_a_broken_estimator_is_named(twin, tmp_path, predict, message):
    with pytest.raises(InputError, match=message):
        score(twin, tmp_path, lambda task, train: predict)


def test_another_file_of_the_same_name_is_refused(twin, tmp_path):
    with (tmp_path / "a.txt").open("a") as file:
        file.write("0 0 0 0\n")
    with pytest.raises(InputError, match="SHA-256"):
        read_task(twin, tmp_path)


def test_missing_files_are_named(twin, tmp_path):
    (tmp_path / "a.txt").unlink()
    assert missing_files(twin, tmp_path) == ["a.txt"]


@pytest.mark.parametrize("task", TASKS, ids=lambda task: task.name)
def test_nothing_is_both_trained_and_tested_on(task):
    for parts in task.tested.values():
        for part in parts:
            assert part.file in task.sha256
            assert all(part.begin >= own.end or own.file != part.file for own in task.trained)


def test_the_example_follows_the_protocol(twin, tmp_path):
    example = runpy.run_path(str(Path(__file__).parents[2] / "examples/benchmark_estimator.py"))
    row = score(twin, tmp_path, example["linear"])
    assert score(twin, tmp_path, BASELINES["ridge"]).mean < row.mean < 1  # the law is not linear
