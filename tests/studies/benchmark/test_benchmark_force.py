"""Forces of a benchmark, and that cheats gain nothing."""

import os
from pathlib import Path
from shutil import copytree

import numpy as np
import pytest
from benchmark_folders import write_force_folder
from scale_files import FORCES, GRAM
from scipy.spatial import cKDTree

from soft_gripper.errors import InputError
from studies.benchmark.baselines import nearest, ridge
from studies.benchmark.benchmark_task import missing_files, read_tests, read_training, region_inputs
from studies.benchmark.estimates import answers
from studies.benchmark.measured_force import force_tasks
from studies.benchmark.ours import ours
from studies.benchmark.scores import scores
from studies.benchmark.tasks import TASKS

TRAINED, TESTED = FORCES.values()


@pytest.fixture(scope="module")
def data(tmp_path_factory):
    folder = tmp_path_factory.mktemp("data")
    write_force_folder(folder)
    return folder


def score(task, copies, name, estimator):
    train, tested = read_training(task, task.folder, copies), read_tests(task, task.folder)
    (row,) = scores(task, name, answers(task.question, name, estimator, train, region_inputs(tested)), tested)
    return row


def test_each_press_is_a_sample_without_the_zero_and_drift_of_the_scale(data, tmp_path):
    (task,) = force_tasks(data)
    assert task.name == "force_scale"
    (train,), tested = read_training(task, task.folder, tmp_path), read_tests(task, task.folder)
    np.testing.assert_allclose(train.outputs[:, 0], TRAINED, atol=2 * GRAM)
    np.testing.assert_allclose(tested["test"][0].outputs[:, 0], TESTED, atol=2 * GRAM)
    assert [channel.name for channel in task.inputs][4:6] == ["pressure", "free_reading_0"]
    assert train.inputs[:, 4] == pytest.approx(60e3)
    assert train.inputs[:, -1] == pytest.approx(0)


def test_contact_finds_the_force_and_neighbours_do_not(data, tmp_path):
    (task,) = force_tasks(data)
    found = score(task, tmp_path / "1", "contact", ours(task)["contact"])
    assert found.mean < 0.04  # N, as by `replay`
    assert found.within_band_percent == 100
    for other in (nearest, ridge):
        assert score(task, tmp_path / other.__name__, "it", other).mean > 3 * found.mean


@pytest.mark.parametrize(
    ("file", "change", "said"),
    [
        ("test.csv", None, r"test\*.csv"),
        ("bench.yaml", ("measured_force", "measured_torque"), "measured_"),
        ("bench.yaml", ("column: scale", "column: sclae"), "must have 'sclae'"),
        ("train.csv", lambda text: text[: len(text) // 40], "has no press"),
    ],
)
def test_folders_that_do_not_fit_are_refused(data, tmp_path, file, change, said):
    copytree(data, tmp_path, dirs_exist_ok=True)
    path = tmp_path / "measured_force/scale" / file
    text = path.read_text()
    path.unlink()
    if change is not None:
        path.write_text(text.replace(*change) if isinstance(change, tuple) else change(text))
    with pytest.raises(InputError, match=said):
        [read_training(task, task.folder, tmp_path / "copies") for task in force_tasks(tmp_path)]


RECORDINGS = Path(os.environ.get("SOFT_GRIPPER_DATA", "nowhere"))
TASK = {task.name: task for task in TASKS}


def nearest_sample(question, train):
    """The mean output of the nearest inputs, of which several samples may be."""
    inputs, outputs = np.vstack([r.inputs for r in train]), np.vstack([r.outputs for r in train])
    known, of = np.unique(inputs, axis=0, return_inverse=True)
    means = np.stack([np.bincount(of, values) / np.bincount(of) for values in outputs.T], axis=1)
    tree = cKDTree(known)
    return lambda new: means[tree.query(new)[1]]


def cheat(task, root):
    """The nearest sample of all that is trained on, and of all files of the task below a folder."""

    def estimator(question, train):
        assert all(recorded.path is None or recorded.path.is_relative_to(root) for recorded in train)
        names = {Path(file).name for file in task.sha256}
        found = sorted(file for file in root.rglob("*") if file.name in names and file.suffix != ".yaml")
        return nearest_sample(question, [*train, *map(task.read, found)])

    return estimator


def mean_errors(task, folder, estimator, train):
    tested = read_tests(task, folder)
    return [
        row.mean
        for row in scores(task, "it", answers(task.question, "it", estimator, train, region_inputs(tested)), tested)
    ]


def assert_cheat_gains_nothing(task, folder, copies):
    train = read_training(task, folder, copies)
    cheating, honest = (
        mean_errors(task, folder, estimator, train) for estimator in (cheat(task, copies), nearest_sample)
    )
    assert all(mine >= other * (1 - 1e-9) for mine, other in zip(cheating, honest, strict=True))
    return train


@pytest.mark.parametrize("task", TASKS, ids=lambda task: task.name)
def test_the_cheat_gains_nothing(task, tmp_path):
    folder = task.folder or RECORDINGS
    if missing_files(task, folder):
        pytest.skip("$SOFT_GRIPPER_DATA has no recordings")
    assert_cheat_gains_nothing(task, folder, tmp_path)


def test_the_cheat_gains_nothing_where_a_force_is_measured(tmp_path):
    write_force_folder(tmp_path)
    (task,) = force_tasks(tmp_path)
    train = assert_cheat_gains_nothing(task, task.folder, tmp_path / "copies")
    assert {file.name for file in train[0].path.parent.iterdir()} == {"bench.yaml", "finger.yaml", "train.csv"}


@pytest.mark.parametrize("task", TASKS, ids=lambda task: task.name)
def test_no_file_that_is_given_is_tested(task):
    tested = {part.file for parts in task.tested.values() for part in parts}
    assert tested.isdisjoint(task.given)
    assert {*task.given} <= {part.file for part in task.trained}


def test_commands_that_are_tested_were_not_trained_on_with_another_load():
    """Recordings of the trunk are of the same commands."""
    for name in ("trunk_shape", "trunk_load", "trunk_dc_shape"):
        task = TASK[name]
        last = max(part.end for part in task.trained)
        tested = [part for parts in task.tested.values() for part in parts]
        assert min(part.begin for part in [*tested, task.kept_back]) > last
        assert {part.file for part in tested}.isdisjoint(part.file for part in task.trained)
