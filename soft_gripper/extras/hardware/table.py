"""Tables of recordings: named columns, (T, columns), and the `Columns` that a reader is asked for."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from itertools import compress
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from soft_gripper.arrays import Array
from soft_gripper.errors import InputError, did_you_mean, similar_names
from soft_gripper.extras.hardware.recording_schema import TextConfig
from soft_gripper.files.notes import LEFT_OUT, note

DEFAULT_HOLD = 0.1  # s, see `Columns.hold`
_MAX_NUMBER = 1e20  # largest number: admits a clock that counts nanoseconds since 1970
_AGE_TOLERANCE = 1e-6  # of an age that is `hold`
_MAX_COLUMNS_SHOWN = 12  # columns in a message
_MAX_NAMES_COMPARED = 1000  # names that a mistyped one is compared with
_MIN_CLOCK_JUMP, _MIN_CLOCK_STEPS = (
    60.0,
    100,
)  # s and median intervals: a clock that is set goes from 0 by more than both


@dataclass(frozen=True)
class Columns:
    """Needed columns of a file, and their names in it."""

    names: Mapping[str, str]  # columns of numbers with the field that names each, for messages
    time: str
    time_unit: float = 1.0  # s, of that column
    header: Sequence[str] | None = None  # names of the columns of text; None: they are in the file
    text: TextConfig = field(default_factory=TextConfig)  # form of the text, as far as it is given
    label: str | None = None  # the column of text that is not a number
    points: str = ""  # pattern of the names of a C3D point's columns, with {marker} and {axis}; empty: no points
    point_unit: float = 1.0  # m, of those columns
    # Largest age, s, of the last value of a signal in rows without one; None: `DEFAULT_HOLD` in bags, 0 in tables
    hold: float | None = None

    @property
    def fields(self) -> dict[str, str]:
        """Columns of numbers, each with its naming field; the time is first."""
        return {self.time: "time", **{name: field_name for name, field_name in self.names.items() if name != self.time}}

    @property
    def all_fields(self) -> dict[str, str]:
        """Columns, each with its naming field; that of the label is last."""
        return self.fields if self.label is None else {**self.fields, self.label: "labels.column"}

    def places(self, path: Path, file_names: Sequence[str]) -> list[int]:
        """Indices of the columns of `needed` among those of a file."""
        all_fields = self.all_fields
        places: dict[str, list[int]] = {name: [] for name in all_fields}
        for i, name in enumerate(file_names):
            if name in places:
                places[name].append(i)
        return [_place(path, field, name, file_names, places[name]) for name, field in all_fields.items()]


def _place(path: Path, field: str, name: str, file_names: Sequence[str], places: Sequence[int]) -> int:
    if not places:
        hint = did_you_mean(similar_names(name, file_names[:_MAX_NAMES_COMPARED])[:1])
        hint += " " if hint else ""
        shown = ", ".join(file_names[:_MAX_COLUMNS_SHOWN]) + (" ..." if len(file_names) > _MAX_COLUMNS_SHOWN else "")
        raise InputError(path, field, name, f"no such column; {hint}its columns: {shown}")
    if len(places) > 1:
        longer = [longer_name for longer_name in file_names if longer_name.endswith(f":{name}")]
        remedy = f"give one of {', '.join(longer)}" if longer else "rename one, or name all of them in `header`"
        raise InputError(path, field, name, f"{len(places)} columns of the file have this name: {remedy}")
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
        wrong_cells = np.argwhere(np.abs(self.values) > _MAX_NUMBER)
        if len(wrong_cells):
            (row, column), expected = wrong_cells[0], f"give finite numbers, at most {_MAX_NUMBER:g} in magnitude"
            value = float(self.values[row, column])
            raise InputError(self.path, self.names[column], value, f"in row {self.rows[row]}: {expected}")

    def columns(self, names: Sequence[str]) -> Array:
        """Columns by name, (T, len(names)), among those that the table was asked for."""
        return self.values[:, [self.names.index(name) for name in names]]

    def select(self, keep: NDArray[np.bool_]) -> "Table":
        """Samples for which `keep` is true, (T,)."""
        labels = tuple(compress(self.labels, keep))
        return replace(self, values=self.values[keep], rows=self.rows[keep], labels=labels)


def split_runs(table: Table, time: str, pause: float) -> list[Table]:
    """Runs in a table: a gap of time longer than `pause`, in its unit, or time that begins anew, begins another."""
    t = table.columns([time])[:, 0]
    table, t = table.select(np.isfinite(t)), t[np.isfinite(t)]
    step = np.diff(t, prepend=t[:1])
    run_numbers = np.cumsum((step < 0) | (step > pause))
    if not len(t):
        raise InputError(table.path, time, 0, "no sample has a time")
    runs = [table.select(run_numbers == i) for i in range(int(run_numbers[-1]) + 1)]
    for run in runs:
        if len(run.rows) < 2:
            expected = f"is a run by itself in row {run.rows[0]}: is `pause` right, and does time run on?"
            raise InputError(table.path, time, float(run.columns([time])[0, 0]), expected)
    return runs


def drop_zero_stamps(table: Table, time: str, unit: float) -> Table:
    """Samples since the clock was set, at times from 0 in units of `unit` s.

    Before a clock is set, a time of 0 is recorded.
    """
    t = table.columns([time])[:, 0]
    first_row = int(np.argmax(t != 0)) if len(t) else 0
    steps = np.diff(t[first_row:][np.isfinite(t[first_row:])])
    is_unset = first_row > 0 and not (t[first_row:] == 0).any()  # a clock that fails later is told from its own numbers
    if (
        not is_unset
        or not len(steps)
        or not t[first_row] > max(_MIN_CLOCK_JUMP / unit, _MIN_CLOCK_STEPS * np.median(steps))
    ):
        return table
    reason = f"their time is 0: the clock was set before row {table.rows[first_row]}"
    note(LEFT_OUT, table.path, f"{first_row} of {len(t)} rows", "", reason)
    timed_table = table.select(np.arange(len(t)) >= first_row)
    return replace(timed_table, values=timed_table.values - t[first_row] * (np.array(table.names) == time))


def hold_values(table: Table, columns: Columns) -> Table:
    """Fills empty cells with the last value, if `columns.hold` is given.

    Rows without any value are left out, and rows of one time that have no signal in common are one.
    """
    if columns.hold is None:
        return table
    signals = [i for i, name in enumerate(table.names) if name != columns.time]
    table = table.select(np.isfinite(table.values[:, signals]).any(axis=1))
    t, values = table.columns([columns.time])[:, 0], table.values[:, signals]
    last_rows = np.maximum.accumulate(np.where(np.isfinite(values), np.arange(len(t))[:, None], 0), axis=0)
    run = np.cumsum(np.diff(t, prepend=t[:1]) < 0)  # time that begins anew begins another
    age = (t[:, None] - t[last_rows]) * columns.time_unit
    is_fresh = (run[:, None] == run[last_rows]) & (age <= columns.hold * (1 + _AGE_TOLERANCE))
    filled_values = table.values.copy()
    filled_values[:, signals] = np.where(is_fresh, np.take_along_axis(values, last_rows, axis=0), np.nan)
    return replace(table, values=filled_values).select(_message_group_ends(t, np.isfinite(values)))


def _message_group_ends(t: Array, has_value: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """Mask of the last row of each time, (T,), and of all rows of a time with several values of a signal."""
    begins = np.flatnonzero(np.diff(t, prepend=np.nan) != 0)
    if not len(begins):
        return np.ones(len(t), dtype=bool)
    is_single = (np.add.reduceat(has_value, begins, axis=0, dtype=int) <= 1).all(axis=1)
    is_last = np.diff(t, append=np.nan) != 0
    return is_last | ~np.repeat(is_single, np.diff(begins, append=len(t)))


def leave_out_start(table: Table, columns: Columns, hold: float) -> Table:
    """Drops the samples before every signal has a value, but for signals that begin later than `hold`, s."""
    if not len(table.rows):
        return table
    t = table.columns([columns.time])[:, 0]
    has_value = np.isfinite(table.values)
    begin = t[np.argmax(has_value, axis=0)]
    begin = begin[has_value.any(axis=0) & ((begin - t[:1]) * columns.time_unit <= hold)]
    is_kept = ~(t < begin.max(initial=-np.inf))
    if not is_kept.all():
        note(LEFT_OUT, table.path, f"{len(t) - is_kept.sum()} of {len(t)} rows", "", "some signals began after them")
    return table.select(is_kept)


def note_missing(table: Table, columns: Columns, hold: float | None) -> None:
    """Notes the number of missing cells of each column, except markers, which are noted with their times."""
    reason = "no value there" if hold is None else f"no value there, nor in the {hold:g} s before (`hold`)"
    for name, missing_count in zip(table.names, np.isnan(table.values).sum(axis=0), strict=True):
        if missing_count and columns.fields[name] not in ("time", "markers"):
            note(LEFT_OUT, table.path, f"{missing_count} of {len(table.rows)} cells of {name}", "", reason)
