"""Contact trials: the rows, the reasons, and that processes change nothing."""

import numpy as np
import pytest

from soft_gripper.runs.executor import open_executor
from studies.contacts.peg import (
    Contact,
    RandomContact,
    Settled,
    contact_row,
    run_contact,
    run_contacts,
)

DRAWN = RandomContact("outer", 5.0, 80.0, 50.0, 20.0, (np.sqrt(0.5), 0.0, np.sqrt(0.5), 0.0))
FOUND = Settled(np.zeros(12), 0.0, np.zeros(12), np.zeros(13), -0.5, 0.6, 0.082, np.zeros(3))


def test_a_row_says_what_was_drawn_and_what_is_true() -> None:
    row = contact_row(Contact(7, DRAWN, FOUND, ("lost", "too weak"), 0.45))
    assert (row.contact, row.side, row.radius_mm, row.place_mm, row.pressure_kpa) == (7, "outer", 5.0, 80.0, 20.0)
    assert (row.arc_length_mm, row.force_n, row.total_n, row.redrawn) == (82.0, -0.5, 0.6, 2)
    np.testing.assert_allclose((row.gravity_x, row.gravity_z), (9.81, 0), atol=1e-12)


@pytest.mark.slow
def test_contacts_of_processes_are_those_of_one_alone() -> None:
    reported: list[int] = []
    with open_executor(1) as executor:
        contacts = run_contacts(2, 5, executor, lambda: reported.append(1))
    assert len(reported) == 2
    assert [contact.number for contact in contacts] == [0, 1]
    alone = run_contact(5, 1, 0.3)
    assert contacts[1].draw == alone.draw
    np.testing.assert_array_equal(contacts[1].settled.q, alone.settled.q)
