"""Input that is refused: by a call, with the field and the value in its error, and by a command, in one line."""

import xml.etree.ElementTree as ET
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from unittest.mock import ANY

import pytest
from command_line import soft_gripper

from soft_gripper.commands.options import Program
from soft_gripper.commands.parser import SOFT_GRIPPER
from soft_gripper.errors import InputError
from soft_gripper.fingers.finger_element import read_finger_element

_LONGEST = 1000  # characters of a line


@contextmanager
def refused(field: str, value: object = ANY) -> Iterator[pytest.ExceptionInfo[InputError]]:
    """Expects an InputError in one line, of a field and of its value, which may be any."""
    with pytest.raises(InputError) as caught:
        yield caught
    assert (field, value) == (caught.value.field, caught.value.value)  # in this order: arrays compare themselves
    assert "\n" not in str(caught.value)


def refused_finger(element: ET.Element, field: str, value: object, part: str = "") -> None:
    """Expects that a <finger> is refused in a line that names the file, the finger, a part of it, field and value."""
    with refused(field, value) as caught:
        read_finger_element("gripper.urdf", element)
    assert str(caught.value).startswith(f"gripper.urdf: finger '{element.get('name')}': {part}")


def refusal(*arguments: object, program: Program = SOFT_GRIPPER) -> str:
    """The line in which a command refuses its input: it says and writes nothing else, here or below.

    Notes on a recording come before it.
    """
    before = _written()
    outcome = soft_gripper(*arguments, program=program)
    assert (outcome.code, outcome.out) == (2, "")
    *notes, line = outcome.err.splitlines()
    assert all(note.startswith("note: ") for note in notes)
    assert line.startswith(f"{program.name}: ")
    assert len(line) < _LONGEST
    assert _written() == before
    return line


def _written() -> dict[Path, bytes | None]:
    """Files of the present folder with their contents, and all else in it."""
    return {path: path.read_bytes() if path.is_file() else None for path in Path().rglob("*")}
