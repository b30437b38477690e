"""python -m studies drift: shape and force during an hour of grasping with sensors that drift."""

import argparse
from dataclasses import asdict

from soft_gripper.extras.paper.commands.printing import print_claims
from soft_gripper.files.output import lock_folder
from soft_gripper.files.row_table import columns, headings, print_table
from soft_gripper.runs.executor import open_executor
from studies.drift.study import (
    FIGURE,
    SUMMARY,
    TABLE,
    PolicyRow,
    drift_claims,
    run_drift,
)


def run(options: argparse.Namespace) -> int:
    """Runs the command; the exit code is 1 if a claim does not hold."""
    executor, console, out = open_executor(options.jobs, options.scheduler), options.console, lock_folder(options.out)
    with (
        console.jobs(options.parts, "hours", "--resume goes on with them") as ended,
        executor as opened,
    ):
        rows = run_drift(out, options.parts, options.seed, opened, lambda job: ended(), options.resume)
    claims = drift_claims(rows)
    print_table(headings(PolicyRow, columns(PolicyRow)), [list(asdict(row).values()) for row in rows])
    console.table("drift", rows)
    print_claims(claims)
    console.table("claims", claims)
    console.wrote(*(out / file for file in (SUMMARY, TABLE, f"{FIGURE}.png", f"{FIGURE}.svg")))
    return 0 if all(claim.holds for claim in claims) else 1
