"""The table of a sweep: a row is added when its run has ended, and all are put in order when the last has."""

import csv
import io
import os
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from soft_gripper.errors import InputError
from soft_gripper.files.output import atomic_file
from soft_gripper.files.row_sums import note_changed, read_sums, row_sum, sums_file, write_sums
from soft_gripper.files.text import read_text

NUMBER, ERROR = "run", "error"


class SweepTable:
    """A CSV file that is whole whenever it is looked at, but for its last line if the process was killed there.

    The first column numbers the runs; then come what was varied, what was measured, and what went wrong.
    """

    def __init__(self, path: Path, varied: Sequence[str], measured: Sequence[str]):
        """`varied` are keys, `measured` the names of measures; nothing is read or written yet."""
        self._path = path
        self._varied, self._measured = tuple(varied), tuple(measured)
        self.rows: dict[int, list[str]] = {}  # cells, by the numbers of the runs

    @property
    def header(self) -> list[str]:
        """Names of the columns."""
        return [NUMBER, *self._varied, *self._measured, ERROR]

    def begin(self) -> None:
        """Writes a table without rows in the place of any other."""
        self._write([])

    def resume(self) -> None:
        """Reads the rows that are there as they were written; a last line that is not whole is cut off.

        Raises:
            InputError: if there is a table of other columns.
        """
        text = read_text(self._path) if self._path.exists() else ""
        try:
            header, *rows = list(csv.reader(io.StringIO(text[: text.rfind("\n") + 1], newline=""))) or [[]]
        except csv.Error as error:
            raise InputError("sweep", "--resume", str(self._path), f"is not a table: {error}") from None
        if header and header != self.header:
            raise InputError("sweep", "--resume", str(self._path), f"has other columns than {', '.join(self.header)}")
        sums = read_sums(self._path)
        self.rows = {int(row[0]): row for row in rows if row_sum(row) in sums}
        note_changed(self._path, len(rows) - len(self.rows))
        self._write(list(self.rows.values()))

    def add(self, number: int, changes: Mapping[str, Any], results: Mapping[str, Any], error: str = "") -> None:
        """Adds the row of a run.

        Raises:
            InputError: if it cannot be written.
        """
        varied = [cell(changes[key]) for key in self._varied]
        measured = [cell(results[name]) if results else "" for name in self._measured]
        self.rows[number] = [str(number), *varied, *measured, error]
        row = self.rows[number]
        try:
            for path, line in ((self._path, _line(row)), (sums_file(self._path), f"{row_sum(row)}\n")):
                with path.open("ab", buffering=0) as file:
                    self._write_whole(file.fileno(), line.encode())
        except OSError as failure:
            raise InputError("output", "file", str(self._path), f"cannot be written: {failure.strerror}") from None

    @staticmethod
    def _write_whole(descriptor: int, line: bytes) -> None:
        while line:  # a disk that is full takes a part of it, and none the next time
            line = line[os.write(descriptor, line) :]

    def finish(self) -> None:
        """Puts the rows in the order of their numbers."""
        self._write([self.rows[number] for number in sorted(self.rows)])

    def _write(self, rows: Sequence[Sequence[str]]) -> None:
        with atomic_file(self._path) as partial, partial.open("w", encoding="utf-8", newline="") as file:
            file.writelines(map(_line, [self.header, *rows]))
        write_sums(self._path, map(row_sum, rows))


def cell(value: Any) -> str:
    """A value as text; numbers with nine digits."""
    if isinstance(value, float):
        return f"{value + 0.0:.9g}"
    return "" if value is None else str(value)


def _line(cells: Sequence[str]) -> str:
    text = io.StringIO()
    csv.writer(text, lineterminator="\n").writerow(cells)
    return text.getvalue()
