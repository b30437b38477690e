"""`ImportedModel`, a model file as Drake takes it, and `Form`, which reads one form of files into it.

Another form is a module of `forms` with a `FORM`.
"""

import xml.etree.ElementTree as ET
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import NamedTuple

from soft_gripper.model_import.model_file import ModelFile


class Mimic(NamedTuple):
    """A joint that follows another: position = multiplier * the other's position + offset (rad or m)."""

    joint: str
    leader: str
    multiplier: float
    offset: float


@dataclass(frozen=True)
class ImportOptions:
    """Options of an import beside the file of the model."""

    where: str = "model"  # its place in a scenario, for messages
    is_arm: bool = False  # its joints get actuators, its meshes become convex for contact
    free: bool = False  # it is not welded to anything
    child: str | None = None  # the frame at which it is welded; None: its first link
    without: Sequence[str] = ()  # links that are left out
    mass: float | None = None  # kg, of all its links together; None: as in the file
    friction: float | None = None  # Coulomb; None: as in the file
    # Of a bare mesh: its name, m of its unit of length, its red, green, blue and opacity; what, if it is not rigid,
    # describes it as a link from its file, density, kg/m^3, and friction.
    name: str = "object"
    scale: float = 1.0
    color: Sequence[float] = (0.5, 0.5, 0.5, 1.0)
    add_to_link: Callable[[ET.Element, Path, float, float], None] | None = None


class ImportedModel(NamedTuple):
    text: str | None  # None: the file as it is
    suffix: str = ""  # of the format of the text
    mimics: Sequence[Mimic] = ()
    apart: Sequence[tuple[list[str], list[str]]] = ()  # pairs of groups of bodies that never touch each other
    friction: float | None = None  # that its shapes are to get; None: they have theirs


class Form(NamedTuple):
    """A form of model files, found by the root element of XML, or by the suffix of any other file."""

    name: str
    marks: Sequence[str]  # root elements, or suffixes in lower case
    read: Callable[[ModelFile, ImportOptions], ImportedModel]
    # Multiplies all masses and moments in a text that was read; None: `read` gives the mass and friction of options,
    # and there are no links to leave out.
    scale: Callable[[Path, ET.Element, float], None] | None = None
