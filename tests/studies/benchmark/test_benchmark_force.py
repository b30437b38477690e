"""The task with a measured force, on a synthetic scale that reads late and drifts."""

from shutil import copytree

import numpy as np
import pytest
from benchmark_folders import write_force_folder
from scale_files import FORCES, GRAM

from soft_gripper.errors import InputError
from studies.benchmark.baselines import nearest, ridge
from studies.benchmark.benchmark_task import read_tests, read_training, region_inputs
from studies.benchmark.estimates import answers
from studies.benchmark.measured_force import force_tasks
from studies.benchmark.ours import ours
from studies.benchmark.scores import scores

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
