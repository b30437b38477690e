"""The columns of a recorded file: comma-separated text, or C3D."""

import difflib
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from soft_gripper import reading
from soft_gripper.arrays import Array
from soft_gripper.diagrams.schema.ranges import require
from soft_gripper.errors import InputError

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
            InputError: naming the file, the field that asks for a column, and the nearest column there is.
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
    require(len(lines) > begin, path, "file", path.name, "is empty: it holds no samples")
    names = tuple(header or (cell.strip() for cell in lines[0].split(",")))
    parsed = [_numbers(line, len(names)) for line in lines[begin:]]
    good = [i for i, row in enumerate(parsed) if row is not None]
    bad = [i for i, row in enumerate(parsed) if row is None and lines[begin + i].strip()]
    expected = f"no row parses: each is to hold {len(names)} numbers between commas"
    require(len(good) > 0, path, "file", path.name, expected)
    values = np.array([parsed[i] for i in good])
    return Table(path, names, values, np.array(good) + begin + 1, tuple(i + begin + 1 for i in bad))


def _numbers(line: str, count: int) -> list[float] | None:
    cells = [cell.strip() for cell in line.replace("[", "").replace("]", "").split(",")]
    try:
        return [float(cell or "nan") for cell in cells] if len(cells) == count and any(cells) else None
    except ValueError:
        return None
