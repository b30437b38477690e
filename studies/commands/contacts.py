"""python -m studies contacts: random single contacts of a finger, and how well they are estimated."""

import argparse
import sys
from collections import Counter
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from soft_gripper.files.output import lock_folder
from soft_gripper.files.row_table import print_rows, write_csv
from soft_gripper.runs.executor import open_executor
from studies.contacts.contacts import Contacts, load_contacts, save_contacts
from studies.contacts.estimates import ESTIMATOR, SETUPS, check_estimator
from studies.contacts.peg import PLACE, SIDES, Contact, as_arrays, contact_row, run_contacts
from studies.contacts.trials import BOTH, ERRORS, FIGURE, score_contacts

TABLE, ARRAYS = "contacts.csv", "contacts.nc"
_UNPRINTED = "side", "contacts", "friction", "force_within_2_std_percent", "place_within_2_std_percent"


def run(options: argparse.Namespace) -> None:
    """Runs the command."""
    estimators = options.estimator or [ESTIMATOR]
    for name in estimators:
        check_estimator(name)
    kept = load_contacts(options.contacts) if options.contacts is not None else None
    out = lock_folder(options.out)
    contacts = _simulate(options, out) if kept is None else kept
    with options.console.counter(len(SETUPS) * len(estimators), "scores") as bar:
        rows = score_contacts(contacts, out, bar.update, estimators)
    title = "errors of both sides, relative to force and length; borders of sections in mm"
    print_rows([row for row in rows if row.side == BOTH], title, leave=_UNPRINTED)
    lost = sum(row.found_percent == 0 for row in rows)
    if lost:
        print(f"note: no contact was detected in {lost} of {len(rows)} rows: their errors are NaN", file=sys.stderr)
    written = [*([TABLE, ARRAYS] if kept is None else []), ERRORS, f"{FIGURE}.png", f"{FIGURE}.svg"]
    options.console.table("errors", rows)
    options.console.wrote(*(out / file for file in written))


def _simulate(options: argparse.Namespace, out: Path) -> Contacts:
    number, kept = options.trials, "nothing is written until the last contact"
    executor = open_executor(options.jobs, options.scheduler)
    with options.console.jobs(number, "contacts", kept) as ended, executor as opened:
        contacts = run_contacts(number, options.seed, opened, ended, options.friction, (options.beyond, PLACE[1]))
    arrays = as_arrays(contacts)
    write_csv(out / TABLE, [contact_row(contact) for contact in contacts])
    save_contacts(arrays, out / ARRAYS)
    _print_summary(contacts)
    return arrays


def _print_summary(contacts: Sequence[Contact]) -> None:
    """Prints the ranges of force and location on each side, and how many contacts were redrawn."""
    for side in SIDES:
        found = [contact.found for contact in contacts if contact.drawn.side == side]
        if found:
            forces, places = np.abs([each.force for each in found]), 1e3 * np.array([each.arc_length for each in found])
            where = f"{places.min():.0f} to {places.max():.0f} mm from the base"
            print(f"{len(found):5} {side}: {forces.min():.2f} to {forces.max():.2f} N, {where}")
    reasons = Counter(reason for contact in contacts for reason in contact.redrawn)
    listed = ", ".join(f"{count} {reason}" for reason, count in reasons.most_common())
    print(f"{reasons.total():5} drawn again" + (f": {listed}" if listed else ""))
