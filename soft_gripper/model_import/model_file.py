"""A model file while it is read: its elements, which are mended for Drake, and the notes on what was changed."""

import xml.etree.ElementTree as ET
from functools import cached_property
from pathlib import Path
from typing import NoReturn

from soft_gripper.errors import InputError
from soft_gripper.files.notes import Note, make_note
from soft_gripper.files.xml_text import read_xml


class ModelFile:
    """A file of a model; readers mend its elements, and leave the notes on that to their caller."""

    def __init__(self, path: Path, root: ET.Element | None = None):
        """`root` is the root element if it is known, as after the expansion of a URDF's fingers."""
        self.path = path
        self.notes: list[Note] = []
        if root is not None:
            self.root = root

    @cached_property
    def root(self) -> ET.Element:
        """The root element of an XML file; raises as `read_xml`."""
        return read_xml(self.path)

    def part(self, element: ET.Element) -> "ModelFile":
        """One of several models in the file, whose notes are those of the file."""
        part = ModelFile(self.path, element)
        part.notes = self.notes
        return part

    def note(self, outcome: str, element: str, value: object, why: str) -> None:
        self.notes.append(make_note(outcome, self.path, element, value, why))

    def refuse(self, field: str, value: object, expected: str) -> NoReturn:
        raise InputError(self.path, field, value, expected) from None
