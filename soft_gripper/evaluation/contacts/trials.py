"""Contact trials: random single contacts, simulated many at a time, as a table and as arrays."""

from collections import Counter
from collections.abc import Callable, Sequence
from concurrent.futures import Executor, Future
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from soft_gripper.evaluation.contacts.bench import PEG_FRICTION
from soft_gripper.evaluation.contacts.dataset import as_arrays, save_contacts
from soft_gripper.evaluation.contacts.random_contact import Contact, run_contact
from soft_gripper.files.csv_table import write_csv
from soft_gripper.runs.executor import Call, make_calls

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
    number: int, seed: int, executor: Executor, report: Callable[[Contact], Any], friction: float = PEG_FRICTION
) -> list[Contact]:
    """Simulates random contacts.

    Args:
        number: contacts 0 to `number` - 1 of the seed.
        seed: of what is random.
        executor: runs the simulations.
        report: called with each contact.
        friction: coefficient of the peg's surface.
    """
    contacts: dict[Call, Contact] = {}

    def ended(call: Call, future: Future[Contact]) -> None:
        contacts[call] = future.result()
        report(contacts[call])

    calls = [(seed, i, friction) for i in range(number)]
    make_calls(executor, run_contact, calls, ended)
    return [contacts[call] for call in calls]


def write_contacts(contacts: Sequence[Contact], folder: Path) -> None:
    """Writes the table and the arrays."""
    write_csv(folder / TABLE, [contact_row(contact) for contact in contacts])
    save_contacts(as_arrays(contacts), folder / ARRAYS)


def redrawn(contacts: Sequence[Contact]) -> Counter[str]:
    """How often what was drawn was no single contact, by the reason."""
    return Counter(reason for contact in contacts for reason in contact.redrawn)
