"""The benchmark's protocol and scores, on a synthetic twin of a recorded set."""

import hashlib
import json
from dataclasses import replace
from itertools import pairwise
from operator import attrgetter

import numpy as np
import pytest
from scipy.special import ndtr

from soft_gripper.errors import InputError
from studies.benchmark.baselines import _RIDGE_PENALTY, _fit_linear, ridge
from studies.benchmark.benchmark_task import (
    BenchmarkTask,
    Channel,
    Part,
    Recorded,
    read_tests,
    read_training,
    region_inputs,
)
from studies.benchmark.contacts import FOLDER
from studies.benchmark.estimates import answers
from studies.benchmark.report import document, load_scores
from studies.benchmark.scores import Score, add_unknown, crps, scores
from studies.benchmark.tasks import TASKS

NOISE = 0.1
STDS = (0.0, 0.5 * NOISE, NOISE, 2 * NOISE)


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
    parts = (Part("a.txt", end=0.5),)
    return BenchmarkTask("twin", "nowhere", {"a.txt": digest}, channels, channels, parts, tested, read)


def score(task, folder, estimator):
    return scored(task, estimator, read_training(task, folder, folder / "copies"), read_tests(task, folder))


def scored(task, estimator, train, tested):
    (row,) = scores(task, "mine", answers(task.question, "mine", estimator, train, region_inputs(tested)), tested)
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
    assert (row.mean, row.median, row.percentile_95, row.within_band_percent, row.band) == (0, 0, 0, None, None)


@pytest.mark.parametrize(("width", "within"), [(NOISE, 100), (NOISE / 3, 0)])
def test_a_band_is_as_wide_as_it_states(twin, tmp_path, width, within):
    row = score(twin, tmp_path, oracle(read(tmp_path / "a.txt"), width))
    assert row.within_band_percent == within
    assert row.band == pytest.approx(2 * 1.96 * width, rel=1e-3)
    missed = max(0.0, NOISE - 1.96 * width)  # the distance of what is true from the band
    assert row.interval_score == pytest.approx(row.band + 40 * missed, rel=1e-3)
    assert row.mean == pytest.approx(NOISE * np.sqrt(2))


def test_crps_is_that_of_its_definition():
    """Integral of (F(x) - [x > y])^2 over x; of a point, the size of its error."""
    x = np.linspace(-9, 9, 200001)
    for error, std in ((0.0, 1.0), (1.3, 0.5), (-2.0, 0.8)):
        expected = np.trapezoid((ndtr((x - error) / std) - (x > 0)) ** 2, x)
        assert crps(np.array(error), np.array(std)) == pytest.approx(expected, rel=1e-4)
    assert crps(np.array([-3.0, 0.0]), np.zeros(2)) == pytest.approx([3.0, 0.0])


def test_the_proper_score_is_least_for_a_true_band(twin, tmp_path):
    """The errors of the law are normal, with the standard deviation of the noise."""
    law = lambda inputs: np.stack([inputs[:, 0] + inputs[:, 1] ** 2, inputs[:, 0] * inputs[:, 1]], axis=1)  # noqa: E731
    of = {
        std: score(twin, tmp_path, lambda task, train, std=std: lambda x: (law(x), np.full((len(x), 2), std)))
        for std in STDS
    }
    assert min(of, key=lambda std: of[std].proper) == NOISE
    assert of[NOISE].proper == pytest.approx(NOISE / np.sqrt(np.pi), rel=0.03)
    assert score(twin, tmp_path, lambda task, train: law).proper == of[0.0].proper


def test_ridge_finds_a_quadratic_law_and_its_noise(twin, tmp_path):
    row = score(twin, tmp_path, ridge)
    assert row.mean == pytest.approx(NOISE * np.sqrt(np.pi / 2), rel=0.05)  # of a Rayleigh distribution
    assert row.within_band_percent == pytest.approx(95, abs=1.5)


@pytest.mark.parametrize(
    ("predict", "message"),
    [
        (lambda inputs: inputs[:, :1], r"shape of mean on twin = \(1000, 1\): must be \(1000, 2\)"),
        (lambda inputs: np.nan * inputs, "must be finite"),
        (lambda inputs: (inputs, -np.ones_like(inputs)), "must not be negative"),
        (lambda inputs: inputs - inputs.mean(axis=0), "must use past inputs only"),
        (lambda inputs: (0 * inputs, 0 * inputs + len(inputs)), "must use past inputs only"),
        (lambda inputs: "text", "must be numbers"),
        (lambda inputs: [[10**400, 0]] * len(inputs), "must be numbers"),
    ],
)
def test_a_broken_estimator_is_named(twin, tmp_path, predict, message):
    with pytest.raises(InputError, match=message):
        score(twin, tmp_path, lambda task, train: predict)


def test_an_estimator_cannot_change_what_others_are_given(twin, tmp_path):
    def estimator(task, train):
        train[0].inputs[:] = 0

    with pytest.raises(ValueError, match="read-only"):
        score(twin, tmp_path, estimator)


def test_another_file_of_the_same_name_is_refused(twin, tmp_path):
    with (tmp_path / "a.txt").open("a") as file:
        file.write("0 0 0 0\n")
    with pytest.raises(InputError, match="SHA-256"):
        read_tests(twin, tmp_path)
    with pytest.raises(InputError, match="SHA-256"):
        read_training(twin, tmp_path, tmp_path / "copies")


SHAPES = (Channel("cup", "1"), Channel("box", "1"))


def recognized(stated, held):
    """The score of stated probabilities, `held` being one of two shapes or none."""
    truth = np.eye(3)[held][:, :2]
    recorded = Recorded(np.arange(len(held))[:, None], truth)
    grasps = (Channel("grasp", "1"),)
    task = BenchmarkTask("shape", "", {}, grasps, SHAPES, (), {}, lambda path: recorded, recognition=True)
    predict = lambda inputs: np.asarray(stated, dtype=float)[inputs[:, 0]]  # noqa: E731
    return scored(task, lambda task, train: predict, [], {"all": [recorded]})


def test_wrong_answers_and_unknown_ones_are_counted():
    row = recognized([[0.9, 0.1], [0.2, 0.8], [0.1, 0.1], [0.6, 0.1]], [0, 0, 2, 2])
    assert (row.mean, row.unit, row.unknown_percent) == (50, "%", 25)
    assert (row.median, row.percentile_95) == (None, None)
    brier = [0.01 + 0.01, 0.64 + 0.64, 0.01 + 0.01 + 0.04, 0.36 + 0.01 + 0.49]
    assert row.proper == pytest.approx(np.mean(brier))


def test_scores_of_a_regression_count_as_probabilities():
    found = add_unknown(np.array([[1.2, -0.2], [0.3, 0.3], [2.0, 2.0]]))
    assert found == pytest.approx(np.array([[1, 0, 0], [0.3, 0.3, 0.4], [0.5, 0.5, 0]]))


@pytest.mark.parametrize("task", TASKS, ids=lambda task: task.name)
def test_nothing_is_both_trained_and_tested_on(task):
    for parts in task.tested.values():
        for part in parts:
            assert part.file in task.sha256
            for own in task.trained:
                assert own.file != part.file or part.begin >= own.end or part.end <= own.begin


@pytest.mark.parametrize(
    "task", [task for task in TASKS if task.tested.keys() >= {"near base", "near tip"}], ids=attrgetter("name")
)
def test_regions_are_thirds_of_the_finger(task):
    """Together they are all contacts, each once, in the order of their places along the finger."""
    parts = [part for region in ("near base", "middle", "near tip") for part in task.tested[region]]
    assert [part.begin for part in parts] == [0, *(part.end for part in parts[:-1])]
    assert parts[-1].end == 1
    places = np.genfromtxt(FOLDER / "contacts_test.csv", delimiter=",", names=True)["place"]
    at = [places[round(part.begin * len(places)) : round(part.end * len(places))] for part in parts]
    for nearer, further in pairwise(at):
        assert len(nearer) == pytest.approx(len(further), abs=1)
        assert nearer.max() <= further.min()


@pytest.mark.parametrize("samples", [10, 1000])
def test_the_penalty_is_as_large_as_a_share_of_the_spread_however_many_samples_there_are(samples):
    """A line of slope 1 becomes one of slope 1 / (1 + penalty) if the spread of its input is 1."""
    inputs = np.linspace(-1, 1, samples)[:, None]
    inputs /= inputs.std()
    fit = _fit_linear([Recorded(inputs, inputs + 5.0)], lambda given: given.copy())
    np.testing.assert_allclose(fit(np.array([[0.0], [1.0]]))[:, 0], [5.0, 5 + 1 / (1 + _RIDGE_PENALTY)], rtol=1e-12)


def test_results_keep_the_checksums_of_the_data_of_every_scored_task_and_no_other(tmp_path):
    """Scores on other data are refused."""
    task, file = TASKS[1], tmp_path / "scores.json"
    rows = [Score(task.name, "middle", "mine", 10, "N", 0.1, 0.1, 0.2, 0.1, None, None)]
    found = document(rows, TASKS)
    assert found["sha256"] == {task.name: task.sha256}
    file.write_text(json.dumps(found))
    assert load_scores(file) == rows
    found["sha256"][task.name] = dict.fromkeys(task.sha256, "0" * 64)
    file.write_text(json.dumps(found))
    with pytest.raises(InputError, match="scored on other data"):
        load_scores(file)


def test_a_further_file_is_another_region(twin, tmp_path):
    """A recording that was kept back is scored beside the others, by its name."""
    own = recorded(4, samples=50)
    np.savetxt(tmp_path / "kept.txt", np.hstack([own.inputs, own.outputs]))
    task = replace(twin, kept_back=Part("*.txt", 0.5)).add_kept_back(tmp_path)
    assert [*task.tested] == ["later", "kept"]
    assert task.sha256.keys() == {"a.txt", "kept.txt"}
    (kept,) = read_tests(task, tmp_path)["kept"]
    np.testing.assert_allclose(kept.inputs, own.inputs[25:])
