"""An estimator that reads everything it finds at the paths of the training set gains nothing by it."""

import hashlib
import os
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from scipy.spatial import cKDTree

from soft_gripper.extras.benchmark.benchmark_task import Recorded, missing_files, read_task
from soft_gripper.extras.benchmark.scores import score_task
from soft_gripper.extras.benchmark.tasks import TASKS

RECORDINGS = Path(os.environ.get("SOFT_GRIPPER_DATA", "nowhere"))
DIVIDED = [
    task
    for task in TASKS
    if {part.file for part in task.trained} & {part.file for parts in task.tested.values() for part in parts}
]


def nearest_sample(task, train):
    known, outputs = np.vstack([r.inputs for r in train]), np.vstack([r.outputs for r in train])
    tree = cKDTree(known)
    return lambda inputs: outputs[tree.query(inputs)[1]]


def cheat(task, train):
    """The nearest sample of all files of the task that are where the paths lead."""
    names = {Path(file).name for file in task.sha256}
    files = {file for recorded in train for file in recorded.path.parent.iterdir() if file.name in names}
    return nearest_sample(task, [task.read(file) for file in sorted(files)])


def errors(task, folder, copies):
    """Mean errors in every region: of the cheat, of honest neighbours, and of the cheat with the files themselves."""
    train, tested = read_task(task, folder, copies)
    originals = [replace(recorded, path=folder / part.file) for recorded, part in zip(train, task.trained, strict=True)]
    of = (cheat, train), (nearest_sample, train), (cheat, originals)
    return [[row.mean for row in score_task(task, "it", estimator, given, tested)] for estimator, given in of]


def test_the_cheat_gains_nothing_on_a_made_up_recording(tmp_path):
    task = next(task for task in TASKS if task.name == "tendons_v4_tip")
    (file,), random = task.sha256, np.random.default_rng(3)
    table = np.hstack([random.uniform(0, 5, (400, 9)), random.uniform(-100, 100, (400, 3))])
    (tmp_path / file).parent.mkdir()
    (tmp_path / file).write_text("header\n" + "".join(",".join(["0", "a", *map(str, row)]) + "\n" for row in table))
    task = replace(task, sha256={file: hashlib.sha256((tmp_path / file).read_bytes()).hexdigest()})
    cheating, honest, with_files = errors(task, tmp_path, tmp_path / "copies")
    assert cheating == honest
    assert max(with_files) < 1e-9 < min(honest)


@pytest.mark.parametrize("task", DIVIDED, ids=lambda task: task.name)
def test_the_cheat_gains_nothing_on_recordings(task, tmp_path):
    if missing_files(task, RECORDINGS):
        pytest.skip("$SOFT_GRIPPER_DATA has no recordings")
    cheating, honest, with_files = errors(task, RECORDINGS, tmp_path)
    assert cheating == honest
    assert max(with_files) < 0.2 * min(honest)


@pytest.mark.parametrize("task", TASKS, ids=lambda task: task.name)
def test_a_copy_has_the_training_samples_and_none_that_are_tested(task, tmp_path):
    folder = task.folder or RECORDINGS
    if missing_files(task, folder):
        pytest.skip("$SOFT_GRIPPER_DATA has no recordings")
    train, tested = read_task(task, folder, tmp_path)
    hidden = {row.tobytes() for of in tested.values() for recorded in of for row in samples(recorded)}
    for recorded in train:
        copied = samples(task.read(recorded.path))
        assert np.array_equal(copied[-len(recorded.inputs) :], samples(recorded))
        assert recorded.path.is_relative_to(tmp_path)
        assert hidden.isdisjoint(row.tobytes() for row in copied)


def samples(recorded: Recorded) -> np.ndarray:
    return np.hstack([recorded.inputs, recorded.outputs])
