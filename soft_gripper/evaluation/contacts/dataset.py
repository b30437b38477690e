"""Single contacts as arrays, in a file."""

import math
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, fields
from io import BytesIO
from pathlib import Path
from typing import Any, NamedTuple
from zipfile import ZipFile

import numpy as np
from numpy.lib import format as npy
from numpy.typing import NDArray

from soft_gripper.arrays import Array, Planar
from soft_gripper.errors import InputError, first_line, shortened
from soft_gripper.evaluation.contacts.bench import MOST_FRICTION, read_finger
from soft_gripper.evaluation.contacts.random_contact import SIDES, Contact
from soft_gripper.files.output import atomic_file
from soft_gripper.files.text import check_regular
from soft_gripper.fingers.finger import Finger

_LARGEST = 2**26  # bytes of all arrays of a file: 200 000 contacts


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


class _Kind(NamedTuple):
    """What an array of a file may hold; of numbers that have either sign, and of complex ones, the size counts."""

    type: type
    least: float = 0.0
    most: float = 0.0
    signed: bool = False
    of_joints: bool = False

    def can_be(self, values: NDArray[Any]) -> NDArray[np.bool_]:
        """Which of the values are in the range; NaN and infinite ones are not."""
        if self.type is str:
            return np.isin(values, list(SIDES))
        sizes = np.abs(values) if self.signed else values
        inside: NDArray[np.bool_] = (self.least <= sizes) & (sizes <= self.most)
        return inside

    @property
    def range(self) -> str:
        """In words."""
        if self.type is str:
            return " or ".join(SIDES)
        return f"numbers of {self.least:g} to {self.most:g}" + (" in size" if self.signed else "")


_ARRAYS = {
    "q": _Kind(float, 0, math.pi, signed=True, of_joints=True),
    "pressure": _Kind(float, 0, 1e6, signed=True),
    "gravity": _Kind(complex, 0, 100, signed=True),
    "force": _Kind(float, 1e-3, 1e3, signed=True),  # errors are shares of it
    "total": _Kind(float, 1e-3, 1e3),
    "arc_length": _Kind(float, 0, 1),
    "torque": _Kind(float, 0, 100, signed=True, of_joints=True),
    "side": _Kind(str),
    "radius": _Kind(float, 1e-4, 1),
    "friction": _Kind(float, 0, MOST_FRICTION),
}


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
    """Reads what `save_contacts` wrote; sizes and shapes are looked at before anything is decompressed.

    Raises:
        InputError: naming the array, if one is missing, damaged, or holds what no contact of this finger can have.
    """
    check_regular(Path(path))
    try:
        with ZipFile(path) as archive:
            _check_members(path, archive)
            arrays = {name: _read_array(path, name, archive.read(f"{name}.npy")) for name in _ARRAYS}
    except InputError:
        raise
    except Exception as error:  # of parsers that do not list what they raise
        expected = f"is damaged, or was not written by `contact-trials`: {shortened(first_line(error), 100)}"
        raise InputError("contacts", "file", str(path), expected) from None
    for name, values in arrays.items():
        if len(values) != len(arrays["q"]):
            raise InputError(path, name, len(values), f"give as many contacts as in q, {len(arrays['q'])}")
    return Contacts(**arrays)


def _check_members(path: Path | str, archive: ZipFile) -> None:
    """Looks at what the directory of the archive announces."""
    members = archive.infolist()
    found, expected = Counter(member.filename for member in members), Counter(f"{name}.npy" for name in _ARRAYS)
    if found != expected:
        (odd, *_) = (found - expected) or (expected - found)
        raise InputError(path, "arrays", odd, f"the file must hold each of these once: {', '.join(_ARRAYS)}")
    size = sum(member.file_size for member in members)
    if size > _LARGEST:
        raise InputError(path, "size", size, f"give arrays of at most {_LARGEST} bytes in all")


def _read_array(path: Path | str, name: str, content: bytes) -> NDArray[Any]:
    """The array of a member of the archive, which fills the shape in its header."""
    file, kind = BytesIO(content), _ARRAYS[name]
    npy.read_magic(file)
    shape, _, dtype = npy.read_array_header_1_0(file)
    joints = (read_finger().segments,) if kind.of_joints else ()
    if np.dtype(kind.type).kind != dtype.kind:
        raise InputError(path, name, str(dtype), f"give an array of {np.dtype(kind.type)}")
    if shape[1:] != joints or len(shape) != 1 + len(joints) or shape[0] < 1:
        raise InputError(
            path, name, shape, f"give an array of shape {('contacts', *joints)}, with at least one contact"
        )
    if math.prod(shape) * dtype.itemsize != len(content) - file.tell():
        raise InputError(path, name, shape, f"does not fit the {len(content) - file.tell()} bytes of the array")
    values: Array = np.asarray(npy.read_array(BytesIO(content), allow_pickle=False), kind.type)
    wrong = values[~kind.can_be(values)]
    if len(wrong):
        raise InputError(path, name, wrong[0].item(), f"give {kind.range}")
    return values
