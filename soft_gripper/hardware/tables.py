"""Files of numbers -> tables of named columns.

| file | columns |
|---|---|
| text | numbers between commas; names are in the first row, or given |
| text of JSON objects | one object a line; the entries of a list are `name[0]`, `name[1]` ... |
| `.c3d`, motion capture | of each point, in a pattern, and analog channels, by their labels |
| `.nc`, netCDF 3 | variables over the dimension of the time, `name` or `name[0]`, `name[0,1]` ... |
| `.bag`, `.db3`, `.mcap`, folder of a ROS 2 bag | fields of messages, see `bag_messages` |
"""

import difflib
import importlib.util
from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from itertools import compress
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from soft_gripper.arrays import Array
from soft_gripper.diagrams.recording import Recording
from soft_gripper.errors import InputError
from soft_gripper.files import text as reading
from soft_gripper.files.document import require
from soft_gripper.files.text import check_regular
from soft_gripper.hardware.bag_messages import bag_columns
from soft_gripper.hardware.c3d_points import c3d_points
from soft_gripper.hardware.live.messages import MalformedError, decoded
from soft_gripper.hardware.reading_apart import read_apart
from soft_gripper.hardware.recording_schema import LENGTH

BAGS = (".bag", ".db3", ".mcap")
OTHER_THAN_TEXT = (*BAGS, ".nc", ".c3d")
HELD = 0.1  # s, see `Columns.hold`
_LARGEST = 1e20  # largest number: admits a clock that counts nanoseconds since 1970


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
    dropped: tuple[int, ...] = ()  # rows of the file that do not parse
    labels: tuple[str, ...] = ()  # of the samples, if a column of text is described

    def __post_init__(self) -> None:
        wrong = np.argwhere(np.abs(self.values) > _LARGEST)
        if len(wrong):
            (row, column), expected = wrong[0], f"give finite numbers, at most {_LARGEST:g} in magnitude"
            value = float(self.values[row, column])
            raise InputError(self.path, self.names[column], value, f"in row {self.rows[row]}: {expected}")

    def columns(self, field: str, names: list[str]) -> Array:
        """Columns by name, (T, len(names)).

        Raises:
            InputError: naming the file, the field that requires a column, and the nearest existing column.
        """
        for name in names:
            if name not in self.names:
                near = difflib.get_close_matches(name, self.names, n=1)
                hint = f"did you mean '{near[0]}'? " if near else ""
                there = ", ".join(self.names[:12]) + (" ..." if len(self.names) > 12 else "")
                raise InputError(self.path, field, name, f"no such column; {hint}its columns: {there}")
        return self.values[:, [self.names.index(name) for name in names]]

    def kept(self, keep: NDArray[np.bool_]) -> "Table":
        """The samples for which `keep` is true, (T,)."""
        labels = tuple(compress(self.labels, keep))
        return replace(self, values=self.values[keep], rows=self.rows[keep], labels=labels)


@dataclass(frozen=True)
class Columns:
    """What is needed of a file, and how its columns are named."""

    names: Sequence[str]  # of the columns, but for the time
    time: str
    header: list[str] | None = None  # of text between commas; None: in its first row
    label: str | None = None  # the column of such text that is not a number
    points: str = ""  # pattern of the names of a C3D point's columns, with {marker} and {axis}; empty: no points
    point_unit: float = 1.0  # m, of those columns
    hold: float = HELD  # s, age up to which a bag's message of one topic is used in the rows of another


def read_table(path: Path, columns: Columns) -> Table:
    """Reads a file; its name says which kind it is.

    Raises:
        InputError: if it cannot be read, has no samples, or (bags, text) not the columns.
    """
    if path.suffix.lower() in BAGS or is_bag_folder(path):
        return _read_bag(path, columns)
    if path.suffix.lower() == ".c3d":
        return _read_c3d(path, columns)
    return _read_netcdf(path, columns.time) if path.suffix.lower() == ".nc" else _read_text(path, columns)


def is_bag_folder(path: Path) -> bool:
    """Whether a path leads to a ROS 2 bag that is a folder."""
    return (path / "metadata.yaml").is_file()


def _read_text(path: Path, columns: Columns) -> Table:
    """Text: JSON, or between commas, with square brackets ignored; rows that do not parse are dropped."""
    lines = reading.read_text(path).splitlines()
    if lines and lines[0].lstrip().startswith("{"):
        return _read_json(path, lines)
    header, label = columns.header, columns.label
    begin = 0 if header else 1
    require(len(lines) > begin, path, "file", path.name, "is empty: it has no samples")
    names = tuple(header or (cell.strip() for cell in lines[0].split(",")))
    if label is not None and label not in names:
        raise InputError(path, "labels.column", label, f"no such column; its columns: {', '.join(names[:12])}")
    place = None if label is None else names.index(label)
    parsed = [_numbers(line, len(names), place) for line in lines[begin:]]
    good = [i for i, row in enumerate(parsed) if row is not None]
    bad = [i for i, row in enumerate(parsed) if row is None and lines[begin + i].strip()]
    expected = f"no row parses: each must contain {len(names)} numbers, separated by commas"
    require(len(good) > 0, path, "file", path.name, expected)
    values = np.array([parsed[i] for i in good])
    labels = () if place is None else tuple(lines[begin + i].split(",")[place].strip() for i in good)
    return Table(path, names, values, np.array(good) + begin + 1, tuple(i + begin + 1 for i in bad), labels)


def _numbers(line: str, count: int, text: int | None) -> list[float] | None:
    """The cells of a row, NaN in the column of text; None if it does not parse."""
    cells = [cell.strip() for cell in line.replace("[", "").replace("]", "").split(",")]
    if text is not None and text < len(cells):
        cells[text] = ""
    try:
        return [float(cell or "nan") for cell in cells] if len(cells) == count and any(cells) else None
    except ValueError:
        return None


def _read_json(path: Path, lines: Sequence[str]) -> Table:
    rows: list[dict[str, float]] = []
    for line in lines:
        with suppress(MalformedError):  # a line that was cut, as a log may end
            rows.append(decoded(line.encode(), "json", ()))
    require(len(rows) > 0, path, "file", path.name, "no line of it is a JSON object of numbers")
    names = tuple(rows[0])
    values = np.array([[row.get(name, np.nan) for name in names] for row in rows])
    return Table(path, names, values, np.arange(len(rows)) + 1)


def _read_netcdf(path: Path, time: str) -> Table:
    data = Recording.load(path).data
    if time not in data.variables or data[time].ndim != 1:
        known = ", ".join(str(name) for name in data.variables if data[name].ndim == 1)
        raise InputError(path, "time", time, f"is not a variable with one dimension; these are: {known}")
    (along,) = data[time].dims
    names, values = list[str](), list[Array]()
    for name in data.variables:
        variable = data[name]
        if along in variable.dims and variable.dtype.kind in "biufmM":
            flat = variable.transpose(along, ...).values.reshape(data.sizes[along], -1)
            flat = flat if flat.dtype.kind not in "mM" else (flat - flat[:1]) / np.timedelta64(1, "s")
            sizes = [size for dim, size in variable.sizes.items() if dim != along]
            places = [",".join(map(str, place)) for place in np.ndindex(*sizes)]
            names += [f"{name}[{place}]" if place else str(name) for place in places]
            values.append(flat)
    require(data.sizes[along] > 0, path, "file", path.name, "is empty: it has no samples")
    return Table(path, tuple(names), np.concatenate(values, axis=1).astype(float), np.arange(data.sizes[along]) + 1)


_MOST_RATE = 1e6  # Hz


def _read_c3d(path: Path, columns: Columns) -> Table:
    """Points, NaN where one is not seen, and analog channels at their times, which start at 0."""
    _require_extra(path, "c3d", "ezc3d")
    data = read_apart(c3d_points, path)
    points, rate = data["points"], float(data["RATE"][0]) if len(data["RATE"]) else 0.0
    labels = _labels(data["LABELS"])[: points.shape[1]] if columns.points else []
    channels = _labels(data["CHANNELS"])[: len(data["analogs"])]
    require(points.shape[2] > 0, path, "file", path.name, "is empty: it has no points")
    require(bool(labels or channels), path, "markers", None, "it has no analog channels: describe its markers")
    require(0 < rate <= _MOST_RATE, path, "POINT:RATE", rate, f"must be above 0, and at most {_MOST_RATE:g} Hz")
    own = str((data["UNITS"] or ["mm"])[0]).strip() or "mm"
    require(own in LENGTH, path, "POINT:UNITS", own, f"one of {', '.join(LENGTH)}")
    frames = np.arange(points.shape[2])
    names = [columns.points.format(marker=label, axis=axis) for label in labels for axis in "xyz"]
    scale = LENGTH[own] / columns.point_unit
    flat = points[:, : len(labels)].transpose(2, 1, 0).reshape(len(frames), -1) * scale
    analogs = data["analogs"][: len(channels)].T
    together = (
        analogs[:: max(len(analogs) // len(frames), 1)][: len(frames)] if channels else np.empty((len(frames), 0))
    )
    values = np.column_stack((frames / rate, flat, together))
    return Table(path, (columns.time, *names, *channels), values, frames + 1)


def _labels(labels: Sequence[object]) -> list[str]:
    """Labels without the subject that is in front of some."""
    return [str(label).strip().rpartition(":")[2] for label in labels]


def _read_bag(path: Path, columns: Columns) -> Table:
    _require_extra(path, "ros", "rosbags", "mcap")
    if not is_bag_folder(path):
        check_regular(path)
    names = tuple(dict.fromkeys(name for name in columns.names if name != columns.time))
    values = read_apart(bag_columns, path, columns.time, names, columns.hold)
    return Table(path, (columns.time, *names), values, np.arange(len(values)) + 1)


def _require_extra(path: Path, extra: str, *libraries: str) -> None:
    if any(importlib.util.find_spec(library) is None for library in libraries):
        needs = f"such files require {' and '.join(libraries)}: pip install 'soft-gripper[{extra}]'"
        raise InputError(path, "file", path.name, needs)
