"""The numbers of URDF and SDFormat files, checked before Drake reads them: some of Drake's checks end the process."""

import xml.etree.ElementTree as ET
from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np

from soft_gripper.errors import InputError
from soft_gripper.files.xml_text import DRAKE, LEAST, finite_numbers, read_numbers

_MIN_SIZE, _MAX_SIZE = 1e-9, 1e6  # m, of a shape; some mark points by spheres of 0.1 um
_NAMED_TAGS = ("link", "joint", "model")
_NumberTexts = Iterator[tuple[str, str, tuple[int, ...]]]  # field, text, how many numbers it may hold
_LIMIT_FIELDS = ("lower", "upper", "velocity", "effort", "acceleration")  # infinite, or as good as, if there is none
_INERTIA_FIELDS = ("ixx", "iyy", "izz", "ixy", "ixz", "iyz")
# How many numbers: of an attribute in URDF, by element and attribute, and of the text of an element in SDFormat.
_URDF_COUNTS: dict[str, dict[str, tuple[int, ...]]] = {
    "origin": {"xyz": (3,), "rpy": (3,)},
    "axis": {"xyz": (3,)},
    "box": {"size": (3,)},
    "sphere": {"radius": (1,)},
    "cylinder": {"radius": (1,), "length": (1,)},
    "capsule": {"radius": (1,), "length": (1,)},
    "ellipsoid": {"a": (1,), "b": (1,), "c": (1,)},
    "mesh": {"scale": (1, 3)},
    "mass": {"value": (1,)},
    "inertia": dict.fromkeys(_INERTIA_FIELDS, (1,)),
    "limit": dict.fromkeys(_LIMIT_FIELDS, (1,)),
    "dynamics": {"damping": (1,), "friction": (1,)},
    "mimic": {"multiplier": (1,), "offset": (1,)},
    "color": {"rgba": (4,)},
}
_SDF_COUNTS: dict[str, tuple[int, ...]] = {
    "pose": (0, 6, 7),
    "size": (2, 3),
    "scale": (1, 3),
    "radii": (3,),
    "xyz": (3,),
    "normal": (3,),
    **dict.fromkeys(("diffuse", "ambient", "specular", "emissive"), (3, 4)),
    **dict.fromkeys((*_INERTIA_FIELDS, "radius", "length", "mass", "lower", "upper", "velocity", "effort"), (1,)),
    **dict.fromkeys(("damping", "mu", "mu2", "spring_stiffness", "spring_reference"), (1,)),
}
_DRAKE_FIELDS = (
    *("mu_static", "mu_dynamic", "hydroelastic_modulus", "hunt_crossley_dissipation", "mesh_resolution_hint"),
    *("point_contact_stiffness", "relaxation_time", "rotor_inertia", "gear_ratio", "acceleration"),
)
_SIZE_FIELDS = {
    f"{shape}.{name}" for shape in ("box", "sphere", "cylinder", "capsule", "ellipsoid") for name in _URDF_COUNTS[shape]
}
_SIZE_FIELDS |= {"size", "radius", "length", "radii"}
_PRODUCT_FIELDS = ("ixy", "ixz", "iyz")
_ROUNDED_FIELDS: tuple[str, ...] = ("origin.xyz", "origin.rpy", "pose", *_PRODUCT_FIELDS)
_ROUNDED_FIELDS += tuple(f"inertia.{product}" for product in _PRODUCT_FIELDS)
_NONZERO_FIELDS = ("axis.xyz", "xyz", "normal", "mesh.scale", "scale")
_WITHOUT_AXIS = ("fixed", "floating", "ball")  # types of joints in URDF whose axis Drake does not read


def check_numbers(where: Path | str, root: ET.Element) -> None:
    """Checks all numbers of a URDF or SDFormat file, from its root element.

    Raises:
        InputError: for the first that is not a finite number, is one too many or missing, or fits no shape or axis.
    """
    _check_inside(where, root, _sdf_numbers if root.tag == "sdf" else _urdf_numbers)


def _check_inside(where: Path | str, element: ET.Element, numbers: Callable[[ET.Element], _NumberTexts]) -> None:
    has_axis = numbers is _sdf_numbers or element.tag != "joint" or element.get("type") not in _WITHOUT_AXIS
    for child in element:
        if isinstance(child.tag, str) and (has_axis or child.tag != "axis"):  # a comment has no text as its tag
            inside = f"{where}: {child.tag} '{child.get('name')}'" if child.tag in _NAMED_TAGS else where
            for field, text, counts in (*numbers(child), *_drake_numbers(child)):
                _check(inside, field, text, counts)
            _check_inside(inside, child, numbers)


def _urdf_numbers(element: ET.Element) -> _NumberTexts:
    for name, counts in _URDF_COUNTS.get(element.tag, {}).items():
        if (text := element.get(name)) is not None:
            yield f"{element.tag}.{name}", text, counts


def _sdf_numbers(element: ET.Element) -> _NumberTexts:
    if element.tag in _SDF_COUNTS and len(element) == 0:
        yield element.tag, element.text or "", _SDF_COUNTS[element.tag]


def _drake_numbers(element: ET.Element) -> _NumberTexts:
    name = element.tag.rpartition("}")[2]
    if element.tag == DRAKE + name and name in _DRAKE_FIELDS:
        yield f"drake:{name}", element.get("value", element.text or ""), (1,)


def _check(where: Path | str, field: str, text: str, counts: tuple[int, ...]) -> None:
    if field.removeprefix("limit.") in _LIMIT_FIELDS:
        if np.isinf(read_numbers(where, field, text, *counts)).any() and field.startswith("limit."):
            raise InputError(where, field, text, "give a finite number, or leave it out: Drake reads no other in URDF")
        return
    numbers = finite_numbers(where, field, text, *counts, least=0.0 if field in _ROUNDED_FIELDS else LEAST)
    if field in _SIZE_FIELDS and not all(_MIN_SIZE <= number <= _MAX_SIZE for number in numbers):
        raise InputError(where, field, text, f"give sizes from {_MIN_SIZE:g} to {_MAX_SIZE:g} m")
    if field in _NONZERO_FIELDS and not any(numbers):
        raise InputError(where, field, text, "give numbers of which one at least is not 0")
    if field in ("mass", "mass.value") and numbers[0] < 0:
        raise InputError(where, field, text, "give a mass of at least 0, kg")
