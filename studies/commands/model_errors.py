"""python -m studies model-errors: coverage of contact forces where the finger differs from its nominal model."""

import argparse

from soft_gripper.files.output import lock_folder
from soft_gripper.files.row_table import print_rows
from soft_gripper.runs.executor import open_executor
from studies.contacts.model_errors import CASES, TABLE, run_model_errors
from studies.contacts.situations import DIFFERENCES


def run(options: argparse.Namespace) -> None:
    """Runs the command."""
    executor, out = open_executor(options.jobs, options.scheduler), lock_folder(options.out)
    number = len(DIFFERENCES) * len(CASES)
    with options.console.jobs(number, "cases", "nothing is written until the last case") as ended, executor as opened:
        rows = run_model_errors(out, options.contacts, options.seed, opened, lambda job: ended())
    print_rows(rows)
    options.console.table("model_errors", rows)
    options.console.wrote(out / TABLE)
