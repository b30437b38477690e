"""python -m studies contacts: random single contacts of a finger, and how well they are estimated."""

import argparse
import sys
from collections import Counter
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from soft_gripper.extras.sweeps.executor import open_executor
from soft_gripper.extras.sweeps.job_progress import count_jobs
from soft_gripper.files.output import lock_folder
from soft_gripper.files.row_table import print_rows, write_csv
from studies.contacts.contacts import Contacts, load_contacts, save_contacts
from studies.contacts.estimates import ESTIMATOR, SETUPS, check_estimator
from studies.contacts.peg import PLACE, SIDES, RestingContact, contact_arrays, contact_row, run_contacts
from studies.contacts.trials import BOTH, ERRORS, FIGURE, score_contacts

TABLE, ARRAYS = "contacts.csv", "contacts.nc"
_UNPRINTED = "side", "contacts", "friction", "force_within_2_std_percent", "place_within_2_std_percent"


def run(options: argparse.Namespace) -> None:
    """Runs the command."""
    estimators = options.estimator or [ESTIMATOR]
    for name in estimators:
        check_estimator(name)
    saved_contacts = load_contacts(options.contacts) if options.contacts is not None else None
    out = lock_folder(options.out)
    contacts = _simulate(options, out) if saved_contacts is None else saved_contacts
    with options.console.counter(len(SETUPS) * len(estimators), "scores") as bar:
        rows = score_contacts(contacts, out, bar.update, estimators)
    title = "errors of both sides, relative to force and length; borders of sections in mm"
    print_rows([row for row in rows if row.side == BOTH], title, leave=_UNPRINTED)
    lost = sum(row.found_percent == 0 for row in rows)
    if lost:
        print(f"note: no contact was detected in {lost} of {len(rows)} rows: their errors are NaN", file=sys.stderr)
    files = [*([TABLE, ARRAYS] if saved_contacts is None else []), ERRORS, f"{FIGURE}.png", f"{FIGURE}.svg"]
    options.console.table("errors", rows)
    options.console.wrote(*(out / file for file in files))


def _simulate(options: argparse.Namespace, out: Path) -> Contacts:
    number, note = options.trials, "nothing is written until the last contact"
    executor = open_executor(options.jobs, options.scheduler)
    with count_jobs(options.console, number, "contacts", note) as ended, executor as opened:
        contacts = run_contacts(number, options.seed, opened, ended, options.friction, (options.beyond, PLACE[1]))
    arrays = contact_arrays(contacts)
    write_csv(out / TABLE, [contact_row(contact) for contact in contacts])
    save_contacts(arrays, out / ARRAYS)
    _print_summary(contacts)
    return arrays


def _print_summary(contacts: Sequence[RestingContact]) -> None:
    """Prints the ranges of force and location on each side, and how many contacts were redrawn."""
    for side in SIDES:
        pairs = [(abs(c.settled.force), 1e3 * c.settled.arc_length) for c in contacts if c.draw.side == side]
        if pairs:
            forces, locations = np.array(pairs).T
            span = f"{locations.min():.0f} to {locations.max():.0f} mm from the base"
            print(f"{len(pairs):5} {side}: {forces.min():.2f} to {forces.max():.2f} N, {span}")
    flaws = Counter(flaw for contact in contacts for flaw in contact.flaws)
    reasons = ", ".join(f"{count} {flaw}" for flaw, count in flaws.most_common())
    print(f"{flaws.total():5} drawn again" + (f": {reasons}" if reasons else ""))
