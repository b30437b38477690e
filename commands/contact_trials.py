"""soft-gripper contact-trials: random single contacts of a finger, with what is true about them."""

import argparse
import os
from collections.abc import Sequence
from pathlib import Path

import numpy as np
from tqdm import tqdm

from soft_gripper.commands.options import Subparsers, whole_number
from soft_gripper.evaluation.contacts.contact_trials import ARRAYS, TABLE, redrawn, run_contacts, write_contacts
from soft_gripper.evaluation.contacts.random_contact import Contact
from soft_gripper.evaluation.contacts.resting import SIDES
from soft_gripper.files import writable_folder

NAME = "contact-trials"


def add_parser(subparsers: Subparsers) -> None:
    """Declares the command."""
    parser = subparsers.add_parser(NAME, help="press a finger against random pegs: force and place of the contact")
    parser.add_argument("--trials", metavar="N", default="200", help="contacts (default: %(default)s)")
    parser.add_argument("--seed", metavar="S", default="1", help="of what is random (default: %(default)s)")
    parser.add_argument("--jobs", metavar="J", help="processes (default: one a core)")
    folder = Path("results/contact_trials")
    parser.add_argument("--out", metavar="DIR", type=Path, default=folder, help="default: %(default)s")
    parser.set_defaults(command=_run)


def _run(options: argparse.Namespace) -> None:
    number, seed = whole_number(NAME, "--trials", options.trials, 1), whole_number(NAME, "--seed", options.seed, 0)
    jobs = whole_number(NAME, "--jobs", options.jobs, 1) if options.jobs is not None else os.cpu_count() or 1
    out = writable_folder(options.out)
    with tqdm(total=number, desc="contacts", dynamic_ncols=True, disable=None) as bar:
        try:
            contacts = run_contacts(number, seed, jobs, lambda contact: bar.update())
        except KeyboardInterrupt:
            bar.close()
            print("\nnothing is written before the last contact")
            raise
    write_contacts(contacts, out)
    _print_summary(contacts)
    print(f"\nWritten to {out}: {TABLE}, {ARRAYS}")


def _print_summary(contacts: Sequence[Contact]) -> None:
    """What forces and places were reached on both sides, and what was drawn again."""
    for side in SIDES:
        found = [contact.found for contact in contacts if contact.drawn.side == side]
        if found:
            forces, places = np.abs([each.force for each in found]), 1e3 * np.array([each.arc_length for each in found])
            where = f"{places.min():.0f} to {places.max():.0f} mm from the base"
            print(f"{len(found):5} {side}: {forces.min():.2f} to {forces.max():.2f} N, {where}")
    reasons = redrawn(contacts)
    listed = ", ".join(f"{count} {reason}" for reason, count in reasons.most_common())
    print(f"{reasons.total():5} drawn again" + (f": {listed}" if listed else ""))
