"""Contact trials: random single contacts, simulated many at a time, and what estimators make of them."""

from collections import Counter
from collections.abc import Callable, Sequence
from concurrent.futures import Executor
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from soft_gripper.evaluation.contacts.bench import PEG_FRICTION
from soft_gripper.evaluation.contacts.dataset import Contacts, as_arrays, save_contacts
from soft_gripper.evaluation.contacts.errors import ContactErrorRow, error_rows
from soft_gripper.evaluation.contacts.estimates import (
    CASES,
    ESTIMATOR,
    SHOWN_CASES,
    SHOWN_LAYOUT,
    ContactEstimate,
    contact_estimates,
)
from soft_gripper.evaluation.contacts.figure import contact_errors_figure
from soft_gripper.evaluation.contacts.random_contact import Contact, run_contact
from soft_gripper.evaluation.contacts.sensors import LAYOUTS
from soft_gripper.files.csv_table import write_csv
from soft_gripper.pictures.style import save_figure
from soft_gripper.runs.study import run_study

TABLE, ARRAYS = "contacts.csv", "contacts.npz"


@dataclass(frozen=True)
class ContactRow:
    """What was drawn for a contact, and what is true about it."""

    contact: int
    side: str
    radius_mm: float
    place_mm: float  # arc length at which the peg was put to the finger
    arc_length_mm: float  # where it presses
    force_n: float  # across the finger, positive on the inner side
    total_n: float  # friction included
    pressure_kpa: float
    gravity_x: float  # m/s^2, in B
    gravity_z: float
    redrawn: int  # how often what was drawn was no single contact


def contact_row(contact: Contact) -> ContactRow:
    """The row of a contact."""
    drawn, found = contact.drawn, contact.found
    return ContactRow(
        contact.number,
        drawn.side,
        drawn.radius_mm,
        drawn.place_mm,
        1e3 * found.arc_length,
        found.force,
        found.total,
        drawn.pressure_kpa,
        drawn.gravity.imag,
        drawn.gravity.real,
        len(contact.redrawn),
    )


def run_contacts(
    number: int, seed: int, executor: Executor, report: Callable[[], Any], friction: float = PEG_FRICTION
) -> list[Contact]:
    """Simulates random contacts.

    Args:
        number: contacts 0 to `number` - 1 of the seed.
        seed: of what is random.
        executor: runs the simulations.
        report: called after each contact.
        friction: coefficient of the peg's surface.
    """
    contacts: dict[int, Contact] = {}
    jobs = {i: (seed, i, friction) for i in range(number)}
    run_study(executor, run_contact, jobs, contacts.__setitem__, ended=lambda i: report())
    return [contacts[i] for i in jobs]


def write_contacts(contacts: Sequence[Contact], folder: Path) -> None:
    """Writes the table and the arrays."""
    write_csv(folder / TABLE, [contact_row(contact) for contact in contacts])
    save_contacts(as_arrays(contacts), folder / ARRAYS)


def redrawn(contacts: Sequence[Contact]) -> Counter[str]:
    """How often what was drawn was no single contact, by the reason."""
    return Counter(reason for contact in contacts for reason in contact.redrawn)


ERRORS, FIGURE = "contact_errors.csv", "contact_errors"
SCORES = len(LAYOUTS) * len(CASES)  # of an estimator


def score_contacts(
    contacts: Contacts, folder: Path, report: Callable[[], Any], estimators: Sequence[str] = (ESTIMATOR,)
) -> list[ContactErrorRow]:
    """Writes the table, and the figure of the first estimator; returns the rows.

    `report` is called after each of SCORES of every estimator.
    """
    estimates = []
    for estimate in contact_estimates(contacts, estimators):
        estimates.append(estimate)
        report()
    rows = error_rows(estimates, contacts)
    write_csv(folder / ERRORS, rows)
    shown = [estimate for estimate in estimates if estimate.estimator == estimators[0] and _is_shown(estimate)]
    shown.sort(key=lambda estimate: SHOWN_CASES.index(estimate.case))
    save_figure(contact_errors_figure(shown, contacts), folder / FIGURE)
    return rows


def _is_shown(estimate: ContactEstimate) -> bool:
    sensors = estimate.layout.sections, estimate.layout.borders
    return sensors == SHOWN_LAYOUT and estimate.case in SHOWN_CASES
