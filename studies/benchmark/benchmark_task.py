"""Describes a task of the benchmark: its files, its measured and estimated channels, its training and test parts.

An estimator gets a question, the training samples, and copies of files without tests. Of the test samples it gets
the inputs alone.
"""

import hashlib
import shutil
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from soft_gripper.arrays import Array
from soft_gripper.errors import InputError
from soft_gripper.files.text import read_bytes

_RECORDING_SUFFIXES = (".csv", ".txt", ".tsv", ".dat", ".xlsx", ".c3d")  # of published recordings
_OTHER_PREFIXES = (".", "README", "LICENSE")  # of files that are no recordings
VERSION = 2  # of the benchmark: scores and submissions of another are not comparable


@dataclass(frozen=True)
class Channel:
    """A measured or estimated quantity."""

    name: str
    unit: str


@dataclass(frozen=True)
class Recorded:
    """Samples in their recorded order."""

    inputs: Array  # (T, n)
    outputs: Array  # (T, m)
    path: Path | None = None  # of a training recording: a copy of its file, if that is given

    def part(self, begin: float, end: float) -> "Recorded":
        """Copies the samples between two fractions of a recording, without its path and the other samples."""
        first, last = (round(fraction * len(self.inputs)) for fraction in (begin, end))
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
    recognition: bool  # the outputs are the probabilities of classes; the rest to 1 is that of no class


Predicted = Array | tuple[Array, Array]  # mean (T, m), or mean and std
Predict = Callable[[Array], Predicted]  # of inputs (T, n)
Estimator = Callable[[Question, Sequence[Recorded]], Predict]
Tested = Mapping[str, Sequence[Recorded]]  # the recordings of every region
Inputs = Mapping[str, Sequence[Array]]  # inputs of the recordings of every region


@dataclass(frozen=True, eq=False)
class BenchmarkTask:
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
    kept_back: Part | None = None  # pattern of further files; each is another region
    further: tuple[str, ...] = ()  # regions of such files
    given: tuple[str, ...] = ()  # files that an estimator gets copies of: whole ones without tests

    @property
    def question(self) -> Question:
        """The task as an estimator sees it."""
        return Question(self.name, self.inputs, self.outputs, self.period, self.recognition)

    def add_kept_back(self, folder: Path) -> "BenchmarkTask":
        """Copy with a region for every further file in a folder, with the file's name."""
        if self.kept_back is None:
            return self
        files = sorted(path.relative_to(folder).as_posix() for path in folder.glob(self.kept_back.file))
        new_files = [file for file in files if file not in self.sha256]
        regions = {Path(file).stem: (replace(self.kept_back, file=file),) for file in new_files}
        digests = {**self.sha256, **{file: digest(folder / file) for file in new_files}}
        return replace(self, sha256=digests, tested={**self.tested, **regions}, further=tuple(regions))


def digest(file: Path) -> str:
    """SHA-256 of a file."""
    return hashlib.sha256(read_bytes(file)).hexdigest()


def missing_files(task: BenchmarkTask, folder: Path) -> list[str]:
    """Files of a task that a data folder does not have."""
    return [file for file in task.sha256 if not (folder / file).is_file()]


def unread_files(tasks: Sequence[BenchmarkTask], folder: Path) -> list[str]:
    """Recordings beside those of tasks that no task reads, as paths in the folder."""
    task_files = {file for task in tasks for file in task.sha256}
    neighbours = {path for parent in {(folder / file).parent for file in task_files} for path in parent.iterdir()}
    names = {
        path.relative_to(folder).as_posix()
        for path in neighbours
        if path.suffix.lower() in _RECORDING_SUFFIXES and not path.name.startswith(_OTHER_PREFIXES)
    }
    return sorted(names - task_files)


def recorded_folders(tasks: Mapping[BenchmarkTask, Path]) -> set[Path]:
    """Folders of the files of tasks, the files, which may be links, and the repositories around them.

    The values of `tasks` are data folders.
    """
    files = [folder / file for task, folder in tasks.items() for file in task.sha256]
    paths = {path.resolve() for file in files for path in (file, file.parent)}
    return paths | {git for path in paths for parent in path.parents if (git := parent / ".git").exists()}


def read_training(task: BenchmarkTask, folder: Path, copies: Path) -> list[Recorded]:
    """Reads the training recordings, and copies the files that estimators get into a folder.

    Raises:
        InputError: if a file is not the one that the task was defined with.
    """
    parts = _read_parts(task, folder, task.trained)
    files = {file: _copy_file(folder, file, copies / task.name) for file in task.given}
    return [replace(recorded, path=files.get(part.file)) for recorded, part in zip(parts, task.trained, strict=True)]


def read_tests(task: BenchmarkTask, folder: Path) -> Tested:
    """Reads the test recordings of every region, one for each part.

    Raises:
        InputError: if a file is not the one that the task was defined with.
    """
    return {region: _read_parts(task, folder, parts) for region, parts in task.tested.items()}


def region_inputs(tested: Tested) -> Inputs:
    """Inputs of test recordings."""
    return {region: [recorded.inputs for recorded in recordings] for region, recordings in tested.items()}


def _copy_file(folder: Path, file: str, target: Path) -> Path:
    copy = target / file
    copy.parent.mkdir(parents=True, exist_ok=True)
    shutil.copyfile(folder / file, copy)
    return copy


def _read_parts(task: BenchmarkTask, folder: Path, parts: Sequence[Part]) -> list[Recorded]:
    files = {file: _read(task, folder, file) for file in dict.fromkeys(part.file for part in parts)}
    return [_part(files[part.file], part) for part in parts]


def _read(task: BenchmarkTask, folder: Path, file: str) -> Recorded:
    checksum = digest(folder / file)
    if checksum != task.sha256[file]:
        expected = f"must be {task.sha256[file]}, as in {task.source}"
        raise InputError(folder / file, "SHA-256", checksum, expected)
    return task.read(folder / file)


def _part(recording: Recorded, part: Part) -> Recorded:
    part_ = recording.part(part.begin, part.end)
    for values in (part_.inputs, part_.outputs):
        values.flags.writeable = False  # all estimators are given the same
    return part_
