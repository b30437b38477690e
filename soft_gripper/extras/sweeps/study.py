"""A study: many calls of one function by an executor, whose results are saved as each call ends.

Jobs are plain data, and so are results. They are saved as rows of tables (`StudyTables.run`), as folders
(`write_folder`) or in memory (`results`); checksums show which ones are complete, so that an interrupted study can be
resumed.
"""

import csv
import hashlib
import io
import logging
import os
from collections.abc import Callable, Iterable, Mapping, Sequence
from concurrent.futures import Executor, as_completed
from pathlib import Path
from typing import Any, TypeVar

from soft_gripper.errors import InputError, SimulationDivergedError, WorkerDiedError
from soft_gripper.extras.sweeps.executor import MainScriptError
from soft_gripper.files.output import atomic_file
from soft_gripper.files.row_table import write_rows
from soft_gripper.files.text import MAX_BYTES, read_text
from soft_gripper.interrupts import delayed_signals

_LOGGER = logging.getLogger(__name__)
Key = TypeVar("Key")
Result = TypeVar("Result")


def run_study(
    executor: Executor,
    work: Callable[..., Any],
    jobs: Mapping[Key, Sequence[Any]],
    keep: Callable[[Key, Any], Any],
    failed: Callable[[Key, str], Any] | None = None,
    ended: Callable[[Key], Any] = lambda key: None,
) -> None:
    """Calls `work` for each job, and returns when the last call has ended.

    Args:
        executor: makes the calls.
        work: a module-level function that takes and returns plain data.
        jobs: the arguments of each call, by job key.
        keep: called in this process, as each call ends, with the key and the result.
        failed: makes the result of a job whose call failed, from the key and the error in words; None: such a job has
            no result.
        ended: called after each call, whether it failed or not.

    Raises:
        MainScriptError: if worker processes cannot import the main script, or what is called.
        Exception: the first exception of a failed call, if `failed` is None; the other calls are finished
            first.
    """
    keys = {executor.submit(work, *call): key for key, call in jobs.items()}
    errors = []
    for future in as_completed(keys):
        key = keys.pop(future)
        error = future.exception()
        if isinstance(error, MainScriptError):
            raise error
        with delayed_signals():  # a result that is kept is counted as well
            if error is None:
                keep(key, future.result())
            elif failed is not None:
                keep(key, failed(key, describe(error)))
            else:
                errors.append(error)
            ended(key)
    if errors:
        raise errors[0]


def results(
    executor: Executor,
    work: Callable[..., Result],
    jobs: Mapping[Key, Sequence[Any]],
    ended: Callable[[Key], Any] = lambda key: None,
) -> dict[Key, Result]:
    """The results of all jobs, in their order; arguments and exceptions as for `run_study`."""
    results_by_key: dict[Key, Result] = {}
    run_study(executor, work, jobs, results_by_key.__setitem__, ended=ended)
    return {key: results_by_key[key] for key in jobs}


def describe(error: BaseException) -> str:
    """An error as one line of text."""
    is_expected = isinstance(error, InputError | SimulationDivergedError | WorkerDiedError)
    return " ".join(f"{'' if is_expected else type(error).__name__ + ': '}{error}".split())


class StudyTables:
    """CSV files in a folder, with rows that start with a key, and a file that describes them.

    A table is complete at any time, except for its last line if the process was killed while writing it. A row is valid
    if it is in all tables and its cells match the checksum stored next to the first table.
    """

    def __init__(self, folder: Path, about: str, columns: Mapping[str, Sequence[str]], keys: int):
        """Reads and writes nothing yet.

        Args:
            folder: folder of the files.
            about: name of the file that describes the study.
            columns: columns of each table, by file name; the same `keys` come first in each.
            keys: number of columns that make up the key of a row.
        """
        self._folder, self._about, self._columns, self._keys = folder, folder / about, columns, keys
        self._first = folder / next(iter(columns))
        self._sums = folder / f"{self._first.name}.sha256"
        self.rows: dict[tuple[str, ...], list[list[str]]] = {}  # cells of each row in every table

    def begin(self, about: str, resume: bool) -> None:
        """Starts new tables, replacing others, or reads existing ones of the same study.

        Args:
            about: description of the study.
            resume: whether existing rows are kept.

        Raises:
            InputError: if it is to be resumed, and the existing tables are of another study or have other columns.
        """
        if resume and self._about.is_file():
            if read_text(self._about, MAX_BYTES) != about:
                expected = "contains another study, or one by other versions; repeat that one, or give another --out"
                raise InputError("study", "--resume", str(self._folder), expected)
            self._read_rows()
        self._write(list(self.rows))
        with atomic_file(self._about) as partial:
            partial.write_text(about, encoding="utf-8")

    def run(
        self,
        executor: Executor,
        work: Callable[..., Any],
        jobs: Mapping[Key, Sequence[Any]],
        keep: Callable[[Key, Any], Any],
        failed: Callable[[Key, str], Any] | None = None,
        ended: Callable[[Key], Any] = lambda job: None,
        keys: Callable[[Any], Iterable[tuple[str, ...]]] = lambda job: [job],
    ) -> None:
        """Makes the calls of the jobs without rows; see `run_study`.

        Args:
            executor, work, jobs, failed: as for `run_study`, with its exceptions.
            keep: adds the rows of a job, from its key and its result.
            ended: called with each job, at once if its rows exist, otherwise after its call.
            keys: the keys of the rows of a job; by default that of the job is that of its only row.
        """
        missing = {job: call for job, call in jobs.items() if not self.rows.keys() >= set(keys(job))}
        for job in jobs:
            if job not in missing:
                ended(job)
        run_study(executor, work, missing, keep, failed, ended)

    def add(self, *rows: Sequence[str]) -> None:
        """Adds a row, as its cells in each table.

        Raises:
            InputError: if they cannot be written.
        """
        self.rows[tuple(rows[0][: self._keys])] = kept_cells = [list(row) for row in rows]
        files = [*(self._folder / table for table in self._columns), self._sums]
        lines = [*map(_line, kept_cells), f"{_sum(kept_cells)}\n"]
        for file, line in zip(files, lines, strict=True):
            try:
                with file.open("ab", buffering=0) as opened:
                    _write_whole(opened.fileno(), line.encode())
            except OSError as failure:
                raise InputError("output", "file", str(file), f"cannot be written: {failure.strerror}") from None

    def finish(self, order: Iterable[tuple[str, ...]]) -> None:
        """Sorts the rows in the order of these keys, which must be the keys of all rows."""
        self._write(list(order))

    def _read_rows(self) -> None:
        """Reads the rows as they were written, without an incomplete last line."""
        tables = [self._rows_of(table) for table in self._columns]
        sums = set(read_text(self._sums, MAX_BYTES).split()) if self._sums.is_file() else set()
        complete = {key: [rows[key] for rows in tables] for key in tables[0] if all(key in rows for rows in tables)}
        self.rows = {key: rows for key, rows in complete.items() if _sum(rows) in sums}
        if changed := max(map(len, tables)) - len(self.rows):
            _LOGGER.warning("%s: %d rows are incomplete or were changed; they are run again", self._first, changed)

    def _rows_of(self, table: str) -> dict[tuple[str, ...], list[str]]:
        file = self._folder / table
        columns = list(self._columns[table])
        text = read_text(file, MAX_BYTES) if file.exists() else ""
        try:
            header, *rows = list(csv.reader(io.StringIO(text[: text.rfind("\n") + 1], newline=""))) or [columns]
        except csv.Error as error:
            raise InputError("study", "--resume", str(file), f"is not a table: {error}") from None
        if header != columns:
            raise InputError("study", "--resume", str(file), f"must have the columns {', '.join(columns)}")
        # A NUL in the place of a comma has the same checksum.
        return {tuple(row[: self._keys]): row for row in rows if len(row) == len(columns)}

    def _write(self, order: Sequence[tuple[str, ...]]) -> None:
        self.rows = {key: self.rows[key] for key in order}
        for i, (table, columns) in enumerate(self._columns.items()):
            write_rows(self._folder / table, columns, (rows[i] for rows in self.rows.values()))
        with atomic_file(self._sums) as partial:
            partial.write_text("".join(f"{_sum(rows)}\n" for rows in self.rows.values()), encoding="ascii")


def _sum(rows: Sequence[Sequence[str]]) -> str:
    cells = "\0".join(cell for row in rows for cell in row)
    return hashlib.sha256(cells.encode("utf-8", "surrogateescape")).hexdigest()


def _line(cells: Sequence[str]) -> str:
    text = io.StringIO()
    csv.writer(text, lineterminator="\n").writerow(cells)
    return text.getvalue()


def _write_whole(descriptor: int, line: bytes) -> None:
    while line:  # a full disk accepts part of it, and nothing the next time
        line = line[os.write(descriptor, line) :]
