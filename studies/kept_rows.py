"""Rows of the jobs of a study, kept in a table as each job ends, by which the study is resumed.

In: a function of a job that gives its rows, and the keys of these. Out: all rows.
"""

import argparse
from collections.abc import Callable, Iterator, Mapping, Sequence
from concurrent.futures import Executor
from contextlib import contextmanager
from pathlib import Path
from typing import Any, TypeVar

from soft_gripper.extras.sweeps.executor import open_executor
from soft_gripper.extras.sweeps.job_progress import count_jobs
from soft_gripper.extras.sweeps.study import StudyTables
from soft_gripper.files.output import lock_folder
from soft_gripper.files.row_table import cells, columns, row_from_cells

Row = TypeVar("Row")
Report = Callable[[Any], Any]  # called with each job as it ends, or at once if its rows exist
Keys = Sequence[tuple[str, ...]]  # first cells of the rows of a job, by which they are told from others


@contextmanager
def counted_jobs(
    options: argparse.Namespace, number: int, unit: str, note: str = "--resume goes on with them"
) -> Iterator[tuple[Executor, Report]]:
    """Opens the executor of a study for so many jobs, and counts them; its folder is locked."""
    executor = open_executor(options.jobs, options.scheduler)
    lock_folder(options.out)
    with count_jobs(options.console, number, unit, note) as ended, executor as opened:
        yield opened, lambda job: ended()


def kept_rows(
    file: Path,
    row_type: type[Row],
    rows_of: Callable[..., list[Row]],
    jobs: Mapping[tuple[Any, ...], Keys],
    settings: Mapping[str, Any],
    executor: Executor,
    report: Report,
    resume: bool = False,
    order: Callable[[tuple[str, ...]], Any] = lambda key: 0,
) -> list[Row]:
    """Makes the calls whose rows do not exist, and returns all rows.

    Args:
        file: the table; a text beside it tells the study from others by its settings.
        row_type: dataclass of a row, whose first fields are its key.
        rows_of: module-level function of the entries of a job and the settings.
        jobs: keys of the rows of each job.
        settings: arguments of every call, by their names.
        executor: makes the calls.
        report: see `Report`.
        resume: whether existing rows are kept.
        order: sorts the keys; those for which it is equal stay in the order of `jobs`.

    Raises:
        InputError: if the study to be resumed is another one.
        Exception: that of a job which fails; the others are finished first.
    """
    keys = [key for job_keys in jobs.values() for key in job_keys]
    tables = StudyTables(file.parent, f"{file.stem}.txt", {file.name: columns(row_type)}, len(keys[0]))
    tables.begin("".join(f"{name}: {value}\n" for name, value in settings.items()), resume)

    def keep(job: tuple[Any, ...], rows: list[Row]) -> None:
        for row in rows:
            tables.add(cells(row))

    calls = {job: (*job, *settings.values()) for job in jobs}
    tables.run(executor, rows_of, calls, keep, ended=report, keys=jobs.__getitem__)
    tables.finish(sorted(keys, key=order))
    return [row_from_cells(texts, row_type) for (texts,) in tables.rows.values()]
