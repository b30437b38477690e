"""Replaces impossible inertias of links by possible ones."""

import xml.etree.ElementTree as ET
from collections.abc import Collection
from pathlib import Path

import numpy as np

from soft_gripper.arrays import Array
from soft_gripper.errors import InputError
from soft_gripper.files.notes import MENDED
from soft_gripper.files.xml_text import joint_end, number, take
from soft_gripper.model_import.model_file import ModelFile

SPECK = (1e-3, 4e-8 * np.eye(3))  # kg, kg m^2: a ball of 1 g and 1 cm radius
NEXT_TO_NONE = (1e-9, 1e-15 * np.eye(3))  # kg, kg m^2
SPECK_WHY = "it moves on a joint of its own, and weighs 1 g now"
_MIN_MASS_SPREAD = 1e-3  # m, spread of the mass along any axis
_ROUNDING_TOLERANCE = 1e-3  # change relative to the trace, below which an inertia was only rounded in its file
DEFAULT_DENSITY = "1000"  # kg/m^3, of SDFormat and MJCF
INERTIA_ENTRIES = {"ixx": (0, 0), "iyy": (1, 1), "izz": (2, 2), "ixy": (0, 1), "ixz": (0, 2), "iyz": (1, 2)}


def possible_inertia(mass: float, inertia: Array) -> Array:
    """The nearest rotational inertia (3, 3), kg m^2, about the centre of mass, that a body of this mass can have.

    An inertia is possible if no principal moment is larger than the sum of the others, that is, if no second moment
    of the mass, tr(I)/2 1 - I, is negative. A possible one is kept, unless a principal moment is zero, which would
    make the mass matrix singular. A changed one is that of a body at least 1 mm thick.
    """
    moments, axes = np.linalg.eigh(np.trace(inertia) / 2 * np.eye(3) - inertia)
    if moments[0] >= 0 and moments[0] + moments[1] > 0:
        return inertia
    second_moments = (axes * np.maximum(moments, mass * _MIN_MASS_SPREAD**2)) @ axes.T
    return np.trace(second_moments) * np.eye(3) - second_moments


def repair_inertia(model: ModelFile, jointed: Collection[str]) -> None:
    """Makes the inertias of all links of a URDF or SDFormat model possible; raises an InputError for what is no number.

    Files leave out inertias that hardly matter, or give zeros. Links named in `jointed`, which have a degree of
    freedom of their own, then get a tiny mass, since the mass matrix would be singular, unless something that has a
    mass is fixed to them; the others are fixed to something that has a mass.
    """
    is_sdf = model.root.tag == "model"
    loaded_links = _links_with_load(model, is_sdf)
    for link in model.root.findall("link"):
        name = link.get("name")
        if is_sdf and (link.find("inertial") is None or link.find("inertial[@auto]") is not None):
            continue  # 1 kg and 1 kg m^2, or computed by Drake
        mass, inertia = _read_inertial(f"{model.path}: link '{name}'", link, is_sdf)
        if mass > 0:
            mended_inertia = possible_inertia(mass, inertia)
            if mended_inertia is not inertia:
                _write_inertial(link, mass, mended_inertia, is_sdf)
                is_rounded = np.abs(mended_inertia - inertia).max() <= _ROUNDING_TOLERANCE * np.trace(mended_inertia)
                if not (is_rounded and np.linalg.eigvalsh(inertia)[0] > 0):
                    note_impossible(model, f"link '{name}': inertia ixx, iyy, izz", inertia)
        elif name in jointed and name not in loaded_links:
            _write_inertial(link, *SPECK, is_sdf)
            model.note(MENDED, f"link '{name}': mass", "0", SPECK_WHY)
        else:
            massless(link, is_sdf)


def note_impossible(model: ModelFile, element: str, inertia: Array) -> None:
    """Notes an inertia (3, 3), kg m^2, that was replaced by a possible one."""
    moments = ", ".join(f"{moment:.3g}" for moment in np.diag(inertia))
    model.note(MENDED, element, moments, "no body has it; the nearest that a body can have takes its place")


def scale_inertias(path: Path, model: ET.Element, factor: float) -> None:
    """Multiplies the masses and moments of all links of a URDF or SDFormat model; raises as `repair_inertia`."""
    is_sdf = model.tag == "model"
    for link in model.findall("link"):
        auto = link.find("inertial[@auto='true']")
        if auto is not None:  # computed by Drake, from the densities of the shapes or that of the link
            density = _child(auto, "density")
            density.text = density.text or DEFAULT_DENSITY
            for element in (density, *link.findall("collision/density")):
                element.text = repr(factor * float(element.text or DEFAULT_DENSITY))
        elif is_sdf or link.find("inertial") is not None:
            mass, inertia = _read_inertial(f"{path}: link '{link.get('name')}'", link, is_sdf)
            _write_inertial(link, factor * mass, factor * inertia, is_sdf)


def _links_with_load(model: ModelFile, is_sdf: bool) -> set[str]:
    """The links that carry a fixed link with a mass, directly or through others."""
    masses = {
        link.get("name", ""): _read_inertial(f"{model.path}: link '{link.get('name')}'", link, is_sdf)[0]
        for link in model.root.findall("link")
    }
    fixed_joints = [joint for joint in model.root.findall("joint") if joint.get("type") == "fixed"]
    parents = {joint_end(joint, "child"): joint_end(joint, "parent") for joint in fixed_joints}
    loaded_links = set[str]()
    for name in [name for name, mass in masses.items() if mass > 0]:
        while (name := parents.get(name, "")) and name not in loaded_links:
            loaded_links.add(name)
    return loaded_links


def massless(link: ET.Element, is_sdf: bool) -> ET.Element:
    """Removes the mass of a link, or nearly all of it in SDFormat, where one without mass weighs 1 kg; returns it."""
    take(link, "inertial")
    if is_sdf:
        _write_inertial(link, *NEXT_TO_NONE, is_sdf)
    return link


def _read_inertial(where: str, link: ET.Element, is_sdf: bool) -> tuple[float, Array]:
    inertial, inertia = link.find("inertial"), np.zeros((3, 3))
    entries = None if inertial is None else inertial.find("inertia")
    for key, (i, j) in INERTIA_ENTRIES.items():
        inertia[i, j] = inertia[j, i] = number(where, entries, key, "1" if is_sdf and i == j else "0")
    mass = number(where, inertial, "mass", "1" if is_sdf else "0")
    check_mass(where, mass)
    return mass, inertia


def check_mass(where: str, mass: float) -> None:
    """Raises an InputError for a mass below 0, kg."""
    if mass < 0:
        raise InputError(where, "mass", mass, "give a mass of at least 0, kg")


def _write_inertial(link: ET.Element, mass: float, inertia: Array, is_sdf: bool) -> None:
    inertial = _child(link, "inertial")
    entries = {key: repr(float(inertia[index])) for key, index in INERTIA_ENTRIES.items()}
    if is_sdf:
        _child(inertial, "mass").text = repr(mass)
        for key, text in entries.items():
            _child(_child(inertial, "inertia"), key).text = text
    else:
        _child(inertial, "mass").set("value", repr(mass))
        _child(inertial, "inertia").attrib.update(entries)


def _child(element: ET.Element, tag: str) -> ET.Element:
    child = element.find(tag)
    return ET.SubElement(element, tag) if child is None else child
