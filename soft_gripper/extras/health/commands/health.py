"""soft-gripper study health: counts detected and named faults, their delays, and false alarms."""

import argparse
from dataclasses import astuple

from soft_gripper.extras.health.study import health_figure, health_rows, health_runs
from soft_gripper.extras.sweeps.executor import open_executor
from soft_gripper.extras.sweeps.job_progress import count_jobs
from soft_gripper.files.output import lock_folder
from soft_gripper.files.row_table import print_table
from soft_gripper.pictures.style import save_figure

TABLE, RUNS, FIGURE = "health.csv", "health_runs.csv", "health"
_COLUMN_TITLES = ("found [%]", "named right [%]", "false alarms [%]", "median delay [s]", "90 % within [s]")


def run(options: argparse.Namespace) -> None:
    """Runs the command."""
    executor = open_executor(options.jobs, options.scheduler)
    out = lock_folder(options.out)
    console = options.console
    with (
        count_jobs(console, 2 * options.runs, "runs", "nothing is written until the last run") as report,
        executor as workers,
    ):
        runs = health_runs(options.runs, options.seed, workers, lambda key: report())
    rows = health_rows(runs)
    console.table("runs", runs, out / RUNS)
    console.table("health", rows, out / TABLE)
    save_figure(health_figure(runs), out / FIGURE)
    columns = {"stiffness (declared)": "", "fault": "", "runs": "d", **dict.fromkeys(_COLUMN_TITLES, ".3g")}
    print_table(columns, map(astuple, rows))
    console.wrote(*(out / file for file in (TABLE, RUNS, f"{FIGURE}.png", f"{FIGURE}.svg")))
