"""A task of the benchmark: recorded files, what is measured and estimated, and what is trained and tested on.

An estimator is given a question, the training samples, and copies of files of which nothing is tested. Of what is
tested it is given the inputs alone.
"""

import hashlib
import shutil
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from soft_gripper.arrays import Array
from soft_gripper.errors import InputError
from soft_gripper.files.text import read_bytes

_RECORDINGS = (".csv", ".txt", ".tsv", ".dat", ".xlsx", ".c3d")  # forms in which recordings are published
_NO_RECORDING = (".", "README", "LICENSE")  # how names of such files begin that are none
VERSION = 2  # of the benchmark: scores and submissions of another are not comparable


@dataclass(frozen=True)
class Channel:
    """A quantity that is measured or estimated."""

    name: str
    unit: str


@dataclass(frozen=True)
class Recorded:
    """Samples in the order in which they were recorded."""

    inputs: Array  # (T, n)
    outputs: Array  # (T, m)
    path: Path | None = None  # of a training recording: a copy of its file, if that is given

    def part(self, begin: float, end: float) -> "Recorded":
        """A copy of the samples between two shares of them, without a path, which keeps no others in memory."""
        first, last = (round(share * len(self.inputs)) for share in (begin, end))
        return Recorded(self.inputs[first:last].copy(), self.outputs[first:last].copy())


@dataclass(frozen=True)
class Part:
    """A contiguous share of a recorded file."""

    file: str
    begin: float = 0.0  # share of its samples
    end: float = 1.0


@dataclass(frozen=True)
class Question:
    """A task as an estimator sees it."""

    name: str
    inputs: tuple[Channel, ...]
    outputs: tuple[Channel, ...]
    period: float | None  # s, between samples of a time series, about; None: each sample stands alone
    recognition: bool  # the outputs are the probabilities of classes; what is missing to 1 is that of no class


Predicted = Array | tuple[Array, Array]  # mean (T, m), or mean and std
Predict = Callable[[Array], Predicted]  # of inputs (T, n)
Estimator = Callable[[Question, Sequence[Recorded]], Predict]
Tested = Mapping[str, Sequence[Recorded]]  # the recordings of every region
Inputs = Mapping[str, Sequence[Array]]  # theirs


@dataclass(frozen=True, eq=False)
class Task:
    """A question with its data. The test set is divided into regions, scored one by one."""

    name: str
    source: str  # public repository and folder of the files
    sha256: Mapping[str, str]  # of every file
    inputs: tuple[Channel, ...]
    outputs: tuple[Channel, ...]
    trained: tuple[Part, ...]
    tested: Mapping[str, tuple[Part, ...]]
    read: Callable[[Path], Recorded]
    folder: Path | None = None  # of files that are in the repository, or were given; None: the data folder
    period: float | None = None
    recognition: bool = False
    kept_back: Part | None = None  # pattern of further files; what is there of each is another region
    further: tuple[str, ...] = ()  # regions that were found so
    given: tuple[str, ...] = ()  # files that an estimator is given copies of: whole, none of them tested

    @property
    def question(self) -> Question:
        """The task as an estimator sees it."""
        return Question(self.name, self.inputs, self.outputs, self.period, self.recognition)

    def with_kept_back(self, folder: Path) -> "Task":
        """With a region for every further file in a folder, called by the file's name."""
        if self.kept_back is None:
            return self
        found = sorted(path.relative_to(folder).as_posix() for path in folder.glob(self.kept_back.file))
        new = [file for file in found if file not in self.sha256]
        regions = {Path(file).stem: (replace(self.kept_back, file=file),) for file in new}
        digests = {**self.sha256, **{file: digest(folder / file) for file in new}}
        return replace(self, sha256=digests, tested={**self.tested, **regions}, further=tuple(regions))


def digest(file: Path) -> str:
    """The SHA-256 of a file."""
    return hashlib.sha256(read_bytes(file)).hexdigest()


def missing_files(task: Task, folder: Path) -> list[str]:
    """Files of a task that a data folder does not have."""
    return [file for file in task.sha256 if not (folder / file).is_file()]


def unread_files(tasks: Sequence[Task], folder: Path) -> list[str]:
    """Recordings beside those of tasks that none of them reads, by their paths in the folder of these."""
    read = {file for task in tasks for file in task.sha256}
    beside = {path for parent in {(folder / file).parent for file in read} for path in parent.iterdir()}
    names = {
        path.relative_to(folder).as_posix()
        for path in beside
        if path.suffix.lower() in _RECORDINGS and not path.name.startswith(_NO_RECORDING)
    }
    return sorted(names - read)


def recorded_folders(tasks: Mapping[Task, Path]) -> set[Path]:
    """The folders that the files of tasks are in, the files, which may be links, and the repositories around them.

    `tasks` has the data folders.
    """
    files = [folder / file for task, folder in tasks.items() for file in task.sha256]
    found = {path.resolve() for file in files for path in (file, file.parent)}
    return found | {git for path in found for parent in path.parents if (git := parent / ".git").exists()}


def read_training(task: Task, folder: Path, copies: Path) -> list[Recorded]:
    """The training recordings, with copies in a folder of the files that are given.

    Raises:
        InputError: if a file is not the one that the task was defined with.
    """
    found = _read_parts(task, folder, task.trained)
    given = {file: _copied(folder, file, copies / task.name) for file in task.given}
    return [replace(recorded, path=given.get(part.file)) for recorded, part in zip(found, task.trained, strict=True)]


def read_tests(task: Task, folder: Path) -> Tested:
    """The test recordings of every region, one for each part.

    Raises:
        InputError: if a file is not the one that the task was defined with.
    """
    return {region: _read_parts(task, folder, parts) for region, parts in task.tested.items()}


def inputs_of(tested: Tested) -> Inputs:
    """The inputs of test recordings."""
    return {region: [recorded.inputs for recorded in recordings] for region, recordings in tested.items()}


def _copied(folder: Path, file: str, to: Path) -> Path:
    copy = to / file
    copy.parent.mkdir(parents=True, exist_ok=True)
    shutil.copyfile(folder / file, copy)
    return copy


def _read_parts(task: Task, folder: Path, parts: Sequence[Part]) -> list[Recorded]:
    files = {file: _read(task, folder, file) for file in dict.fromkeys(part.file for part in parts)}
    return [_part(files[part.file], part) for part in parts]


def _read(task: Task, folder: Path, file: str) -> Recorded:
    found = digest(folder / file)
    if found != task.sha256[file]:
        expected = f"must be {task.sha256[file]}, as in {task.source}"
        raise InputError(folder / file, "SHA-256", found, expected)
    return task.read(folder / file)


def _part(whole: Recorded, part: Part) -> Recorded:
    cut = whole.part(part.begin, part.end)
    for values in (cut.inputs, cut.outputs):
        values.flags.writeable = False  # all estimators are given the same
    return cut
