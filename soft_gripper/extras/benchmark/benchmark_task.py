"""A task of the benchmark: recorded files, what is measured and estimated, and what is trained and tested on."""

import hashlib
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from pathlib import Path

from soft_gripper.arrays import Array
from soft_gripper.errors import InputError


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
    path: Path | None = None  # of a training recording: a copy of what may be used of its file

    def part(self, begin: float, end: float) -> "Recorded":
        """The samples between two shares of them, without a path."""
        first, last = _ends(begin, end, len(self.inputs))
        return Recorded(self.inputs[first:last], self.outputs[first:last])


@dataclass(frozen=True)
class Part:
    """A contiguous share of a recorded file."""

    file: str
    begin: float = 0.0  # share of its samples
    end: float = 1.0


@dataclass(frozen=True, eq=False)
class Task:
    """Question to an estimator, as it is told. The test set is divided into regions, scored one by one."""

    name: str
    source: str  # public repository and folder of the files
    sha256: dict[str, str]  # of every file
    inputs: tuple[Channel, ...]
    outputs: tuple[Channel, ...]
    trained: tuple[Part, ...]
    tested: Mapping[str, tuple[Part, ...]]
    read: Callable[[Path], Recorded]
    folder: Path | None = None  # of files that ship with the package
    period: float | None = None  # s, between samples of a time series, about; None: each sample stands alone
    recognition: bool = False  # the outputs are the probabilities of classes; what is missing to 1 is that of no class


def missing_files(task: Task, folder: Path) -> list[str]:
    """Files of a task that a data folder does not have."""
    return [file for file in task.sha256 if not (folder / file).is_file()]


def read_task(task: Task, folder: Path, copies: Path) -> tuple[list[Recorded], dict[str, list[Recorded]]]:
    """The training recordings, and the test recordings of every region.

    An estimator is given the paths of copies that hold the training samples alone, never those of the files. A motion
    of which nothing is tested is copied whole, with what led to the samples.

    Args:
        task: what is read.
        folder: of its files.
        copies: a folder in which the copies are written.

    Raises:
        InputError: if a file is not the one that the task was defined with.
    """
    files = {file: _read(task, folder, file) for file in task.sha256}
    tested = {region: [_part(files, part) for part in parts] for region, parts in task.tested.items()}
    tested_files = {part.file for parts in task.tested.values() for part in parts}
    trained = []
    for number, part in enumerate(task.trained):
        copy = copies / task.name / str(number) / part.file
        is_whole = task.period is not None and part.file not in tested_files
        _copy(folder / part.file, copy, len(files[part.file].inputs), Part(part.file) if is_whole else part)
        trained.append(replace(_part(files, part), path=copy))
    return trained, tested


def _copy(file: Path, copy: Path, samples: int, part: Part) -> None:
    """Copies a part of a file; one that is divided is a table with a line for every sample, after its header."""
    lines, (begin, end) = file.read_bytes().splitlines(keepends=True), _ends(part.begin, part.end, samples)
    header = len(lines) - samples
    if end - begin < samples:
        lines = lines[:header] + lines[header + begin : header + end]
    copy.parent.mkdir(parents=True)
    copy.write_bytes(b"".join(lines))


def _read(task: Task, folder: Path, file: str) -> Recorded:
    found = hashlib.sha256((folder / file).read_bytes()).hexdigest()
    if found != task.sha256[file]:
        expected = f"must be {task.sha256[file]}, as in {task.source}"
        raise InputError(folder / file, "SHA-256", found, expected)
    return task.read(folder / file)


def _part(files: dict[str, Recorded], part: Part) -> Recorded:
    cut = files[part.file].part(part.begin, part.end)
    for values in (cut.inputs, cut.outputs):
        values.flags.writeable = False  # all estimators are given the same
    return cut


def _ends(begin: float, end: float, samples: int) -> tuple[int, int]:
    return round(begin * samples), round(end * samples)
