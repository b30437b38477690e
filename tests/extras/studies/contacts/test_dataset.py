"""Contacts as arrays: what is saved is what is read."""

import os
import tracemalloc
from dataclasses import fields
from pathlib import Path

import numpy as np
import pytest
from damaged_files import archive, as_npy, damaged_archives

from soft_gripper.errors import InputError
from soft_gripper.extras.studies.contacts.dataset import (
    Contact,
    Contacts,
    RandomContact,
    Settled,
    as_arrays,
    load_contacts,
    save_contacts,
)


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


@pytest.fixture
def file(tmp_path: Path) -> Path:
    path = tmp_path / "contacts.npz"
    save_contacts(as_arrays([contact(0, "inner"), contact(1, "outer")]), path)
    return path


@pytest.mark.slow
def test_a_damaged_file_is_refused_or_gives_finite_contacts(file: Path) -> None:
    arrays = load_contacts(file).__dict__
    kinds, refused = 0, []
    for kinds, (how, content) in enumerate(damaged_archives(arrays, seed=1), 1):  # noqa: B007
        file.write_bytes(content)
        try:
            found = load_contacts(file).__dict__
        except InputError:
            refused.append(how)
        else:
            assert all(np.isfinite(values).all() for name, values in found.items() if name != "side"), how
            assert {values.shape for values in found.values()} <= {(2,), (2, 12)}, how
    assert kinds > 400
    assert len(refused) > 0.9 * kinds
    assert {"a bomb", "q twice", "one more array", "side: text", "radius: nan", "force: 5e-324"} <= set(refused)


@pytest.mark.parametrize(
    ("name", "values", "field", "value"),
    [
        ("q", np.zeros((2, 11)), "q", (2, 11)),
        ("force", np.array([0.5, 0.0]), "force", 0.0),
        ("force", np.array([0.5, -1e308]), "force", -1e308),
        ("gravity", np.array([0j, complex(np.nan, 0)]), "gravity", complex(np.nan, 0)),
        ("side", np.array(["inner", "below"]), "side", "below"),
        ("friction", np.array([0.3, 0.3, 0.3]), "friction", 3),
        ("total", np.array([{}, {}]), "total", "object"),
    ],
)
def test_the_array_and_its_value_are_named(file: Path, name: str, values: object, field: str, value: object) -> None:
    arrays = {**load_contacts(file).__dict__, name: values}
    file.write_bytes(archive([(f"{key}.npy", as_npy(array)) for key, array in arrays.items()]))
    with pytest.raises(InputError) as error:
        load_contacts(file)
    assert error.value.field == field
    np.testing.assert_equal(error.value.value, value)


def test_nothing_large_is_decompressed(file: Path) -> None:
    """80 kB that announce 80 MB, or a shape of gigabytes, take no memory."""
    whole = {f"{name}.npy": as_npy(values) for name, values in load_contacts(file).__dict__.items()}
    whole["pressure.npy"] = as_npy(np.zeros(2), shape="(10000000000,)")
    for bomb in (as_npy(np.zeros((800_000, 12))), whole["q.npy"]):
        file.write_bytes(archive(list({**whole, "q.npy": bomb}.items())))
        tracemalloc.start()
        with pytest.raises(InputError):
            load_contacts(file)
        peak = tracemalloc.get_traced_memory()[1]
        tracemalloc.stop()
        assert peak < 2e6


@pytest.mark.parametrize("kind", ["missing", "folder", "pipe", "text"])
def test_a_file_without_contacts_is_refused(tmp_path: Path, kind: str) -> None:
    path = tmp_path / "contacts.npz"
    if kind == "folder":
        path.mkdir()
    elif kind == "pipe":
        os.mkfifo(path)
    elif kind == "text":
        path.write_bytes(b"no archive")
    with pytest.raises(InputError) as error:
        load_contacts(path)
    assert error.value.field == "file"
