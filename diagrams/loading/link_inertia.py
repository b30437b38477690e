"""Inertias of links as they stand in third-party URDF files, made such that a body can have them."""

import xml.etree.ElementTree as ET
from collections.abc import Collection
from pathlib import Path

import numpy as np

from soft_gripper.arrays import Array
from soft_gripper.xml_numbers import number

_SPECK = (1e-3, 4e-8 * np.eye(3))  # kg, kg m^2: a ball of 1 g and 1 cm radius
_THINNEST = 1e-3  # m, spread of the mass along any axis
_ENTRIES = {"ixx": (0, 0), "iyy": (1, 1), "izz": (2, 2), "ixy": (0, 1), "ixz": (0, 2), "iyz": (1, 2)}


def possible_inertia(mass: float, inertia: Array) -> Array:
    """The nearest rotational inertia (3, 3), kg m^2, about the centre of mass, that a body of this mass can have.

    An inertia is possible if no principal moment is larger than the sum of the others, which is to say if the
    second moments of the mass, tr(I)/2 1 - I, are nowhere negative. One that is possible stays as it is, unless a
    principal moment is zero, which would leave the mass matrix singular. What is changed is 1 mm thick at least.
    """
    moments, axes = np.linalg.eigh(np.trace(inertia) / 2 * np.eye(3) - inertia)
    if moments[0] >= 0 and moments[0] + moments[1] > 0:
        return inertia
    second_moments = (axes * np.maximum(moments, mass * _THINNEST**2)) @ axes.T
    nearest: Array = np.trace(second_moments) * np.eye(3) - second_moments
    return nearest


def repair_inertia(path: Path, robot: ET.Element, jointed: Collection[str]) -> None:
    """Makes the inertias of all links of a URDF possible.

    Files leave out what hardly moves anything, or give zeros. Links named in `jointed`, which have a degree of
    freedom of their own, get a tiny mass then, since the mass matrix would be singular; the others are
    fixed to something that has a mass.

    Raises:
        InputError: if a mass or a moment is not a number.
    """
    for link in robot.findall("link"):
        mass, inertia = _read(f"{path}: link '{link.get('name')}'", link)
        if mass > 0:
            possible = possible_inertia(mass, inertia)
            if possible is not inertia:
                _write(link, mass, possible)
        elif link.get("name") in jointed:
            _write(link, *_SPECK)
        else:
            for inertial in link.findall("inertial"):
                link.remove(inertial)


def _read(where: str, link: ET.Element) -> tuple[float, Array]:
    entries, inertia = link.find("inertial/inertia"), np.zeros((3, 3))
    for key, (i, j) in _ENTRIES.items():
        inertia[i, j] = inertia[j, i] = number(where, entries, key)
    return number(where, link.find("inertial/mass"), "value"), inertia


def _write(link: ET.Element, mass: float, inertia: Array) -> None:
    inertial = _child(link, "inertial")
    _child(inertial, "mass").set("value", repr(mass))
    for key, index in _ENTRIES.items():
        _child(inertial, "inertia").set(key, repr(float(inertia[index])))


def _child(element: ET.Element, tag: str) -> ET.Element:
    child = element.find(tag)
    return ET.SubElement(element, tag) if child is None else child
