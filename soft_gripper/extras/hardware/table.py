"""A table of a recording: the columns that are needed of a file, and how they are asked for."""

import difflib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from itertools import compress
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from soft_gripper.arrays import Array
from soft_gripper.errors import InputError
from soft_gripper.extras.hardware.recording_schema import TextConfig

HELD = 0.1  # s, see `Columns.hold`
_LARGEST = 1e20  # largest number: admits a clock that counts nanoseconds since 1970
_MOST_SHOWN = 12  # columns in a message


@dataclass(frozen=True)
class Columns:
    """The columns that are needed of a file, and how they are found in it."""

    names: Mapping[str, str]  # columns of numbers, each with the field that needs it, for messages
    time: str
    time_unit: float = 1.0  # s, of that column
    header: Sequence[str] | None = None  # names of the columns of text; None: they are in the file
    text: TextConfig = field(default_factory=TextConfig)  # how text is written, as far as it is given
    label: str | None = None  # the column of text that is not a number
    points: str = ""  # pattern of the names of a C3D point's columns, with {marker} and {axis}; empty: no points
    point_unit: float = 1.0  # m, of those columns
    hold: float = HELD  # s, age up to which a bag's message of one topic is used in the rows of another

    @property
    def fields(self) -> dict[str, str]:
        """All columns of numbers with the field that needs each, the time first."""
        return {self.time: "time", **{name: of for name, of in self.names.items() if name != self.time}}

    @property
    def wanted(self) -> dict[str, str]:
        """All columns with the field that needs each, that of the label at the end."""
        return self.fields if self.label is None else {**self.fields, self.label: "labels.column"}

    def places(self, path: Path, there: Sequence[str]) -> list[int]:
        """Where the columns of `wanted` are among those of a file.

        Raises:
            InputError: naming the field whose column is missing, with the nearest, or is there several times.
        """
        return [_place(path, field, name, there) for name, field in self.wanted.items()]


def _place(path: Path, field: str, name: str, there: Sequence[str]) -> int:
    places = [i for i, other in enumerate(there) if other == name]
    if not places:
        near = difflib.get_close_matches(name, there, n=1)
        hint = f"did you mean '{near[0]}'? " if near else ""
        shown = ", ".join(there[:_MOST_SHOWN]) + (" ..." if len(there) > _MOST_SHOWN else "")
        raise InputError(path, field, name, f"no such column; {hint}its columns: {shown}")
    if len(places) > 1:
        longer = [other for other in there if other.endswith(f":{name}")]
        how = f"give one of {', '.join(longer)}" if longer else "rename one, or name all of them in `header`"
        raise InputError(path, field, name, f"{len(places)} columns of the file have this name: {how}")
    return places[0]


@dataclass(frozen=True)
class Table:
    """Named columns; NaN where a cell is empty.

    Raises:
        InputError: if a number is infinite or implausibly large.
    """

    path: Path
    names: tuple[str, ...]
    values: Array  # (T, columns)
    rows: NDArray[np.int_]  # (T,) line, frame or message of each sample in the file, counted from 1
    labels: tuple[str, ...] = ()  # of the samples, if a column of text is described

    def __post_init__(self) -> None:
        wrong = np.argwhere(np.abs(self.values) > _LARGEST)
        if len(wrong):
            (row, column), expected = wrong[0], f"give finite numbers, at most {_LARGEST:g} in magnitude"
            value = float(self.values[row, column])
            raise InputError(self.path, self.names[column], value, f"in row {self.rows[row]}: {expected}")

    def columns(self, names: Sequence[str]) -> Array:
        """Columns by name, (T, len(names)), among those that the table was asked for."""
        return self.values[:, [self.names.index(name) for name in names]]

    def kept(self, keep: NDArray[np.bool_]) -> "Table":
        """The samples for which `keep` is true, (T,)."""
        labels = tuple(compress(self.labels, keep))
        return replace(self, values=self.values[keep], rows=self.rows[keep], labels=labels)


def runs_of(table: Table, time: str, pause: float) -> list[Table]:
    """The runs in a table: a gap of time longer than `pause`, in its unit, or time that begins anew, begins another.

    Raises:
        InputError: if a run has a single row.
    """
    t = table.columns([time])[:, 0]
    table, t = table.kept(np.isfinite(t)), t[np.isfinite(t)]
    step = np.diff(t, prepend=t[:1])
    number = np.cumsum((step < 0) | (step > pause))
    runs = [table.kept(number == i) for i in range(int(number[-1]) + 1)] if len(t) else [table]
    for run in runs:
        if len(run.rows) < 2:
            expected = f"is a run by itself in row {run.rows[0]}: is `pause` right, and does time run on?"
            raise InputError(table.path, time, float(run.columns([time])[0, 0]), expected)
    return runs
