"""Contacts as arrays: what is saved is what is read."""

from pathlib import Path

import numpy as np
import pytest
from refusals import refused

from soft_gripper.diagrams.recording import Recording
from studies.contacts.contacts import Contacts, load_contacts, save_contacts
from studies.contacts.peg import RandomContact, RestingContact, SettledFinger, contact_arrays


def contact(number: int, side: str) -> RestingContact:
    drawn = RandomContact(side, 5.0, 80.0, 50.0, 20.0 + number, (1.0, 0.0, 0.0, 0.0))
    force = 0.5 if side == "inner" else -0.5
    found = SettledFinger(np.full(12, 0.1 * number), 1e-4, np.full(12, 2.0), np.zeros(13), force, 0.6, 0.07, np.ones(3))
    return RestingContact(number, drawn, found, (), 0.45)


@pytest.fixture
def arrays() -> Contacts:
    return contact_arrays([contact(0, "inner"), contact(1, "outer")])


def test_arrays_are_in_si_units_and_keep_the_order(arrays: Contacts) -> None:
    np.testing.assert_array_equal(arrays.pressure, [20e3, 21e3])
    np.testing.assert_array_equal(arrays.is_inside, [True, False])
    np.testing.assert_array_equal(arrays.friction, [0.45, 0.45])
    np.testing.assert_allclose(arrays.gravity, [[0, 0, -9.81]] * 2)
    np.testing.assert_array_equal(arrays.q, [np.zeros(12), np.full(12, 0.1)])
    np.testing.assert_array_equal([arrays.normal_force, arrays.arc_length], [[0.5] * 2, [0.07] * 2])
    assert arrays.torque.shape == (2, arrays.finger.segments)
    assert arrays.subset(np.array([1])).pressure == 21e3


def test_what_is_saved_is_read(tmp_path: Path, arrays: Contacts) -> None:
    save_contacts(arrays, tmp_path / "contacts.nc")
    for name, values in vars(load_contacts(tmp_path / "contacts.nc")).items():
        np.testing.assert_array_equal(values, getattr(arrays, name))
    assert Recording.load(tmp_path / "contacts.nc")["pressure"].attrs["units"] == "Pa"


@pytest.fixture
def file(tmp_path: Path, arrays: Contacts) -> Path:
    save_contacts(arrays, tmp_path / "contacts.nc")
    return tmp_path / "contacts.nc"


@pytest.mark.parametrize(
    ("name", "values", "value"),
    [
        ("q", np.zeros((2, 11)), "float64 (2, 11)"),
        ("normal_force", np.array([0.5, 0.0]), 0.0),
        ("force", np.full((2, 3), -1e308), -1e308),
        ("arc_length", np.array([-0.01, 0.05]), -0.01),
        ("friction", np.array(["a", "b"]), "<U1 (2,)"),
    ],
)
def test_the_array_and_its_value_are_named(file: Path, name: str, values: np.ndarray, value: object) -> None:
    data = Recording.load(file).data
    axes = [f"axis_{i}" if i else "contact" for i in range(values.ndim)]
    Recording(data.drop_vars(name).assign({name: (axes, values)})).save(file)
    with refused(name):
        load_contacts(file)
