"""Contact trials: the rows, the reasons, and that processes change nothing."""

import numpy as np

from studies.contacts.peg import (
    RandomContact,
    RestingContact,
    SettledFinger,
    contact_row,
)

DRAWN = RandomContact("outer", 5.0, 80.0, 50.0, 20.0, (np.sqrt(0.5), 0.0, np.sqrt(0.5), 0.0))
FOUND = SettledFinger(np.zeros(12), 0.0, np.zeros(12), np.zeros(13), -0.5, 0.6, 0.082, np.zeros(3))


def test_a_row_says_what_was_drawn_and_what_is_true() -> None:
    row = contact_row(RestingContact(7, DRAWN, FOUND, ("lost", "too weak"), 0.45))
    assert (row.contact, row.side, row.radius_mm, row.place_mm, row.pressure_kpa) == (7, "outer", 5.0, 80.0, 20.0)
    assert (row.arc_length_mm, row.force_n, row.total_n, row.redrawn) == (82.0, -0.5, 0.6, 2)
    np.testing.assert_allclose((row.gravity_x, row.gravity_z), (9.81, 0), atol=1e-12)
