"""Single contacts as arrays, in a file."""

from collections.abc import Sequence
from dataclasses import dataclass, fields
from pathlib import Path
from zipfile import BadZipFile

import numpy as np
from numpy.typing import NDArray

from soft_gripper.arrays import Array, Planar
from soft_gripper.errors import InputError
from soft_gripper.evaluation.contacts.bench import read_finger
from soft_gripper.evaluation.contacts.random_contact import Contact
from soft_gripper.files import atomic_file
from soft_gripper.fingers.finger import Finger


@dataclass(frozen=True, eq=False)
class Contacts:
    """What is true about M single contacts of one finger with N joints, at rest; see `TrueContact`."""

    q: Array  # (M, N) rad, joint angles
    pressure: Array  # (M,) Pa
    gravity: Planar  # (M,) m/s^2, in the bending plane, z + i x in B
    force: Array  # (M,) N, across the finger, positive on the inner side
    total: Array  # (M,) N, friction included
    arc_length: Array  # (M,) m, from the base
    torque: Array  # (M, N) N m, true external torque
    side: NDArray[np.str_]  # (M,) "inner" or "outer"
    radius: Array  # (M,) m, of the peg
    friction: Array  # (M,) Coulomb, between finger and peg

    @property
    def finger(self) -> Finger:
        """The finger that was pressed, the same in all."""
        return read_finger()


def as_arrays(contacts: Sequence[Contact]) -> Contacts:
    """Contacts one after the other."""
    drawn, found = [contact.drawn for contact in contacts], [contact.found for contact in contacts]
    of_found = {name: np.array([getattr(each, name) for each in found]) for name in ("q", "force", "total", "torque")}
    return Contacts(
        pressure=1e3 * np.array([each.pressure_kpa for each in drawn]),
        gravity=np.array([each.gravity for each in drawn]),
        arc_length=np.array([each.arc_length for each in found]),
        side=np.array([each.side for each in drawn]),
        radius=1e-3 * np.array([each.radius_mm for each in drawn]),
        friction=np.array([contact.friction for contact in contacts]),
        **of_found,
    )


def save_contacts(contacts: Contacts, path: Path) -> None:
    """Writes a file (.npz) with an array for every field."""
    arrays = {field.name: getattr(contacts, field.name) for field in fields(contacts)}
    with atomic_file(path) as partial, partial.open("wb") as file:
        np.savez_compressed(file, **arrays)


def load_contacts(path: Path | str) -> Contacts:
    """Reads what `save_contacts` wrote.

    Raises:
        InputError: if there is no such file, or it holds no contacts.
    """
    try:
        with np.load(path) as file:
            return Contacts(**{field.name: file[field.name] for field in fields(Contacts)})
    except (OSError, ValueError, KeyError, EOFError, BadZipFile) as error:
        raise InputError("contacts", "file", str(path), f"give one of `contact-trials`: {error}") from None
