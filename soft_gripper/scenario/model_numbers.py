"""The numbers of URDF and SDFormat files, checked before Drake reads them: some of Drake's checks end the process."""

import xml.etree.ElementTree as ET
from collections.abc import Callable, Collection, Iterator
from pathlib import Path

import numpy as np

from soft_gripper.arrays import Array
from soft_gripper.errors import InputError
from soft_gripper.files.xml_text import LEAST, finite_numbers, number
from soft_gripper.fingers.finger_links import DRAKE

_SMALLEST, _LARGEST = 1e-6, 1e6  # m, of a shape
_NAMED = ("link", "joint", "model")
_Found = Iterator[tuple[str, str, tuple[int, ...]]]  # field, text, how many numbers it may hold
_INERTIA = ("ixx", "iyy", "izz", "ixy", "ixz", "iyz")
# How many numbers: of an attribute in URDF, by element and attribute, and of the text of an element in SDFormat.
_ATTRIBUTES: dict[str, dict[str, tuple[int, ...]]] = {
    "origin": {"xyz": (3,), "rpy": (3,)},
    "axis": {"xyz": (3,)},
    "box": {"size": (3,)},
    "sphere": {"radius": (1,)},
    "cylinder": {"radius": (1,), "length": (1,)},
    "capsule": {"radius": (1,), "length": (1,)},
    "ellipsoid": {"a": (1,), "b": (1,), "c": (1,)},
    "mesh": {"scale": (1, 3)},
    "mass": {"value": (1,)},
    "inertia": dict.fromkeys(_INERTIA, (1,)),
    "limit": dict.fromkeys(("lower", "upper", "velocity", "effort", "acceleration"), (1,)),
    "dynamics": {"damping": (1,), "friction": (1,)},
    "mimic": {"multiplier": (1,), "offset": (1,)},
    "color": {"rgba": (4,)},
}
_TEXTS: dict[str, tuple[int, ...]] = {
    "pose": (0, 6, 7),
    "size": (2, 3),
    "scale": (1, 3),
    "radii": (3,),
    "xyz": (3,),
    "normal": (3,),
    **dict.fromkeys(("diffuse", "ambient", "specular", "emissive"), (3, 4)),
    **dict.fromkeys((*_INERTIA, "radius", "length", "mass", "lower", "upper", "velocity", "effort"), (1,)),
    **dict.fromkeys(("damping", "mu", "mu2", "spring_stiffness", "spring_reference"), (1,)),
}
_DRAKE_IN_SDF = "{drake.mit.edu}"
_OF_DRAKE = (
    *("mu_static", "mu_dynamic", "hydroelastic_modulus", "hunt_crossley_dissipation", "mesh_resolution_hint"),
    *("point_contact_stiffness", "relaxation_time", "rotor_inertia", "gear_ratio", "acceleration"),
)
_SIZES = {
    f"{shape}.{name}" for shape in ("box", "sphere", "cylinder", "capsule", "ellipsoid") for name in _ATTRIBUTES[shape]
}
_SIZES |= {"size", "radius", "length", "radii"}
_PRODUCTS = ("ixy", "ixz", "iyz")
_ROUNDED = ("origin.xyz", "origin.rpy", "pose", *_PRODUCTS, *(f"inertia.{product}" for product in _PRODUCTS))
_NOT_ZERO = ("axis.xyz", "xyz", "normal", "mesh.scale", "scale")


def check_numbers(where: Path | str, root: ET.Element) -> None:
    """Checks all numbers of a URDF or SDFormat file, from its root element.

    Raises:
        InputError: for the first that is not a finite number, is one too many or missing, or fits no shape or axis.
    """
    _check_inside(where, root, _of_sdf if root.tag == "sdf" else _of_urdf)


def _check_inside(where: Path | str, element: ET.Element, numbers: Callable[[ET.Element], _Found]) -> None:
    for child in element:
        if isinstance(child.tag, str):  # not a comment
            inside = f"{where}: {child.tag} '{child.get('name')}'" if child.tag in _NAMED else where
            for field, text, counts in (*numbers(child), *_of_drake(child)):
                _check(inside, field, text, counts)
            _check_inside(inside, child, numbers)


def _of_urdf(element: ET.Element) -> _Found:
    for name, counts in _ATTRIBUTES.get(element.tag, {}).items():
        if (text := element.get(name)) is not None:
            yield f"{element.tag}.{name}", text, counts


def _of_sdf(element: ET.Element) -> _Found:
    if element.tag in _TEXTS and len(element) == 0:
        yield element.tag, element.text or "", _TEXTS[element.tag]


def _of_drake(element: ET.Element) -> _Found:
    name = element.tag.rpartition("}")[2]
    if element.tag in (DRAKE + name, _DRAKE_IN_SDF + name) and name in _OF_DRAKE:
        yield f"drake:{name}", element.get("value", element.text or ""), (1,)


def _check(where: Path | str, field: str, text: str, counts: tuple[int, ...]) -> None:
    numbers = finite_numbers(where, field, text, *counts, least=0.0 if field in _ROUNDED else LEAST)
    if field in _SIZES and not all(_SMALLEST <= number <= _LARGEST for number in numbers):
        raise InputError(where, field, text, f"give sizes from {_SMALLEST:g} to {_LARGEST:g} m")
    if field in _NOT_ZERO and not any(numbers):
        raise InputError(where, field, text, "give numbers of which one at least is not 0")
    if field in ("mass", "mass.value") and numbers[0] < 0:
        raise InputError(where, field, text, "give a mass of at least 0, kg")


_SPECK = (1e-3, 4e-8 * np.eye(3))  # kg, kg m^2: a ball of 1 g and 1 cm radius
_THINNEST = 1e-3  # m, spread of the mass along any axis
_ENTRIES = {"ixx": (0, 0), "iyy": (1, 1), "izz": (2, 2), "ixy": (0, 1), "ixz": (0, 2), "iyz": (1, 2)}


def possible_inertia(mass: float, inertia: Array) -> Array:
    """The nearest rotational inertia (3, 3), kg m^2, about the centre of mass, that a body of this mass can have.

    An inertia is possible if no principal moment is larger than the sum of the others, that is, if no second moment
    of the mass, tr(I)/2 1 - I, is negative. A possible one is kept, unless a principal moment is zero, which would
    make the mass matrix singular. A changed one is that of a body at least 1 mm thick.
    """
    moments, axes = np.linalg.eigh(np.trace(inertia) / 2 * np.eye(3) - inertia)
    if moments[0] >= 0 and moments[0] + moments[1] > 0:
        return inertia
    second_moments = (axes * np.maximum(moments, mass * _THINNEST**2)) @ axes.T
    nearest: Array = np.trace(second_moments) * np.eye(3) - second_moments
    return nearest


def repair_inertia(path: Path, robot: ET.Element, jointed: Collection[str]) -> None:
    """Makes the inertias of all links of a URDF possible.

    Files leave out inertias that hardly matter, or give zeros. Links named in `jointed`, which have a degree of
    freedom of their own, then get a tiny mass, since the mass matrix would be singular; the others are fixed to
    something that has a mass.

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
