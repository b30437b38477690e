"""python -m studies contact-coverage: how often what `contact` states of a force is true."""

import argparse

from soft_gripper.files.output import lock_folder
from soft_gripper.files.row_table import print_table
from soft_gripper.runs.executor import open_executor
from studies.contacts.coverage import (
    COLUMNS,
    FIGURE,
    KEYS,
    TABLE,
    coverage_jobs,
    run_coverage,
)


def run(options: argparse.Namespace) -> None:
    """Runs the command."""
    executor, out = open_executor(options.jobs, options.scheduler), lock_folder(options.out)
    kept = "--resume goes on with them"
    with options.console.jobs(len(coverage_jobs()), "cases", kept) as ended, executor as opened:
        rows = run_coverage(out, options.size, options.seed, opened, lambda job: ended(), options.resume)
    names = [name for name in COLUMNS if not name.endswith("by_tenth")]  # which the table and the figure have
    headings = {name.replace("_", " "): "" if name in KEYS else ">" for name in names}
    print_table(headings, [[row[name] for name in names] for row in rows])
    options.console.document["coverage"] = rows
    options.console.wrote(*(out / file for file in (TABLE, f"{FIGURE}.png", f"{FIGURE}.svg")))
