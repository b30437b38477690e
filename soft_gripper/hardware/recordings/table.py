"""The columns of a recorded file: comma-separated text, or C3D.

C3D files of motion capture (https://www.c3d.org), read with ezc3d.

A damaged file can crash ezc3d or keep it busy without end, so that it reads in a process of its own.
"""

import difflib
import importlib.util
import pickle
import subprocess
import sys
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from soft_gripper.arrays import Array
from soft_gripper.errors import InputError, first_line
from soft_gripper.files import text as reading
from soft_gripper.files.document import require
from soft_gripper.files.text import check_regular
from soft_gripper.hardware.recordings.schema import LENGTH

_LARGEST = 1e20  # of a number: a clock that counts nanoseconds since 1970 fits in


@dataclass(frozen=True)
class Table:
    """Named columns; NaN where a cell is empty.

    Raises:
        InputError: if a number is infinite, or of a size that nothing measured has.
    """

    path: Path
    names: tuple[str, ...]
    values: Array  # (T, columns)
    rows: NDArray[np.int_]  # (T,) where in the file every sample is: line, or frame, counted from 1
    dropped: tuple[int, ...] = ()  # rows of the file that do not parse

    def __post_init__(self) -> None:
        wrong = np.argwhere(np.abs(self.values) > _LARGEST)
        if len(wrong):
            (row, column), expected = wrong[0], f"give finite numbers, up to {_LARGEST:g} in size"
            value = float(self.values[row, column])
            raise InputError(self.path, self.names[column], value, f"in row {self.rows[row]}: {expected}")

    def columns(self, field: str, names: list[str]) -> Array:
        """Columns by their names, (T, len(names)).

        Raises:
            InputError: naming the file, the field that requires a column, and the nearest existing column.
        """
        for name in names:
            if name not in self.names:
                near = difflib.get_close_matches(name, self.names, n=1)
                hint = f"did you mean '{near[0]}'?" if near else f"its columns: {', '.join(self.names[:12])} ..."
                raise InputError(self.path, field, name, f"no such column; {hint}")
        return self.values[:, [self.names.index(name) for name in names]]

    def kept(self, keep: NDArray[np.bool_]) -> "Table":
        """The samples for which `keep` is true, (T,)."""
        return Table(self.path, self.names, self.values[keep], self.rows[keep], self.dropped)


def read_text(path: Path, header: list[str] | None) -> Table:
    """Reads comma-separated text; square brackets in it are ignored, and rows that do not parse are dropped.

    Args:
        path: of the file.
        header: names of its columns; None: the first row has them.

    Raises:
        InputError: if the file cannot be read, or no row of it parses.
    """
    lines = reading.read_text(path).splitlines()
    begin = 0 if header else 1
    require(len(lines) > begin, path, "file", path.name, "is empty: it has no samples")
    names = tuple(header or (cell.strip() for cell in lines[0].split(",")))
    parsed = [_numbers(line, len(names)) for line in lines[begin:]]
    good = [i for i, row in enumerate(parsed) if row is not None]
    bad = [i for i, row in enumerate(parsed) if row is None and lines[begin + i].strip()]
    expected = f"no row parses: each has to contain {len(names)} numbers, separated by commas"
    require(len(good) > 0, path, "file", path.name, expected)
    values = np.array([parsed[i] for i in good])
    return Table(path, names, values, np.array(good) + begin + 1, tuple(i + begin + 1 for i in bad))


def _numbers(line: str, count: int) -> list[float] | None:
    cells = [cell.strip() for cell in line.replace("[", "").replace("]", "").split(",")]
    try:
        return [float(cell or "nan") for cell in cells] if len(cells) == count and any(cells) else None
    except ValueError:
        return None


_PATIENCE = 120.0  # s
_MOST_RATE = 1e6  # Hz
_READS = """
import pickle, resource, sys
import ezc3d
resource.setrlimit(resource.RLIMIT_AS, (8 << 30, 8 << 30))
try:
    data = ezc3d.c3d(sys.argv[1])
    found = {"points": data["data"]["points"][:3]}
    found |= {name: data["parameters"]["POINT"][name]["value"] for name in ("RATE", "LABELS", "UNITS")}
except Exception as error:
    found = " ".join(str(error).split()) or type(error).__name__
sys.stdout.buffer.write(pickle.dumps(found))
"""


def read_c3d(path: Path, time: str, columns: str, unit: float) -> Table:
    """The points of a C3D file as a table; NaN where a point is not seen.

    Args:
        path: of the file.
        time: name of the column of time, s, which begins at 0.
        columns: pattern of the names of a point's columns, with {marker} for its label and {axis} for x, y, z.
        unit: of those columns, m.

    Raises:
        InputError: if ezc3d is missing, or the file cannot be read or holds no points.
    """
    data = _read(path)
    points, rate = data["points"], float(data["RATE"][0]) if len(data["RATE"]) else 0.0
    labels = [str(label).strip().rpartition(":")[2] for label in data["LABELS"]][: points.shape[1]]
    require(points.size > 0 and len(labels) > 0, path, "file", path.name, "is empty: it has no points")
    require(0 < rate <= _MOST_RATE, path, "POINT:RATE", rate, f"must be above 0, and {_MOST_RATE:g} Hz at most")
    own = str((data["UNITS"] or ["mm"])[0]).strip() or "mm"
    require(own in LENGTH, path, "POINT:UNITS", own, f"one of {', '.join(LENGTH)}")
    frames = np.arange(points.shape[2])
    names = [columns.format(marker=label, axis=axis) for label in labels for axis in "xyz"]
    flat = points[:, : len(labels)].transpose(2, 1, 0).reshape(len(frames), -1) * (LENGTH[own] / unit)
    return Table(path, (time, *names), np.column_stack((frames / rate, flat)), frames + 1)


def _read(path: Path) -> dict[str, Any]:
    """The points, (3, markers, frames), and their attributes."""
    check_regular(path)
    if importlib.util.find_spec("ezc3d") is None:  # an optional extra: needed for these files alone
        raise InputError(path, "file", path.name, "C3D files require ezc3d: pip install 'soft-gripper[c3d]'")
    command = [sys.executable, "-c", _READS, str(path.resolve())]
    try:
        ended = subprocess.run(command, stdin=subprocess.DEVNULL, capture_output=True, timeout=_PATIENCE, check=True)
    except subprocess.TimeoutExpired:
        raise InputError(path, "file", path.name, f"is damaged: it could not be read within {_PATIENCE:g} s") from None
    except subprocess.CalledProcessError as error:
        expected = f"is damaged: ezc3d ended with code {error.returncode}"
        raise InputError(path, "file", path.name, expected) from None
    found = pickle.loads(ended.stdout)
    if isinstance(found, str):
        raise InputError(path, "file", path.name, f"cannot be read: {first_line(ValueError(found))}")
    return dict(found)
