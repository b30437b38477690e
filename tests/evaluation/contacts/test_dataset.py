"""Contacts as arrays: what is saved is what is read."""

from dataclasses import fields
from pathlib import Path

import numpy as np
import pytest

from soft_gripper.errors import InputError
from soft_gripper.evaluation.contacts.bench import Settled
from soft_gripper.evaluation.contacts.dataset import Contacts, as_arrays, load_contacts, save_contacts
from soft_gripper.evaluation.contacts.random_contact import Contact, RandomContact


def contact(number: int, side: str) -> Contact:
    drawn = RandomContact(side, 5.0, 80.0, 50.0, 20.0 + number, (1.0, 0.0, 0.0, 0.0))
    found = Settled(np.full(12, 0.1 * number), 1e-4, np.full(12, 2.0), np.zeros(13), 0.5, 0.6, 0.07)
    return Contact(number, drawn, found, (), 0.45)


def test_arrays_are_in_si_units_and_keep_the_order() -> None:
    arrays = as_arrays([contact(0, "inner"), contact(1, "outer")])
    np.testing.assert_array_equal(arrays.pressure, [20e3, 21e3])
    np.testing.assert_array_equal(arrays.side, ["inner", "outer"])
    np.testing.assert_allclose(arrays.radius, 5e-3)
    np.testing.assert_array_equal(arrays.friction, [0.45, 0.45])
    np.testing.assert_allclose(arrays.gravity, -9.81 + 0j)
    np.testing.assert_array_equal(arrays.q, [np.zeros(12), np.full(12, 0.1)])
    np.testing.assert_array_equal([arrays.force, arrays.total, arrays.arc_length], [[0.5] * 2, [0.6] * 2, [0.07] * 2])
    assert arrays.torque.shape == (2, arrays.finger.segments)


def test_what_is_saved_is_read(tmp_path: Path) -> None:
    arrays = as_arrays([contact(0, "inner"), contact(1, "outer")])
    save_contacts(arrays, tmp_path / "contacts.npz")
    found = load_contacts(tmp_path / "contacts.npz")
    for field in fields(Contacts):
        np.testing.assert_array_equal(getattr(found, field.name), getattr(arrays, field.name))


@pytest.mark.parametrize("content", [None, b"no archive"])
def test_a_file_without_contacts_is_refused(tmp_path: Path, content: bytes | None) -> None:
    path = tmp_path / "contacts.npz"
    if content is not None:
        path.write_bytes(content)
    with pytest.raises(InputError, match="contact-trials"):
        load_contacts(path)
