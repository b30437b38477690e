"""Inertias of links: those that no body can have become possible ones."""

import xml.etree.ElementTree as ET
from collections.abc import Collection
from pathlib import Path
from typing import Any

import numpy as np
from pydrake.geometry import GeometryId, SceneGraphInspector
from pydrake.multibody.parsing import Parser
from pydrake.multibody.tree import ModelInstanceIndex

from soft_gripper.arrays import Array
from soft_gripper.errors import InputError, first_line
from soft_gripper.files.notes import MENDED, READ, note
from soft_gripper.files.xml_text import joint_end, number
from soft_gripper.library_messages import of_drake

SPECK = (1e-3, 4e-8 * np.eye(3))  # kg, kg m^2: a ball of 1 g and 1 cm radius
NEXT_TO_NONE = (1e-9, 1e-15 * np.eye(3))  # kg, kg m^2
SPECK_WHY = "it moves on a joint of its own, and weighs 1 g now"
NOT_POSSIBLE = "no body has it; the nearest that a body can have takes its place"
_THINNEST = 1e-3  # m, spread of the mass along any axis
_ROUNDED = 1e-3  # change relative to the trace, below which an inertia was only rounded in its file
_DENSITY = "1000"  # kg/m^3, of SDFormat
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


def repair_inertia(path: Path, model: ET.Element, jointed: Collection[str]) -> None:
    """Makes the inertias of all links of a URDF or SDFormat model possible.

    Files leave out inertias that hardly matter, or give zeros. Links named in `jointed`, which have a degree of
    freedom of their own, then get a tiny mass, since the mass matrix would be singular, unless something that has a
    mass is fixed to them; the others are fixed to something that has a mass.

    Raises:
        InputError: if a mass or a moment is not a number.
    """
    is_sdf = model.tag == "model"
    heavy = _heavy(path, model, is_sdf)
    for link in model.findall("link"):
        name = link.get("name")
        if is_sdf and (link.find("inertial") is None or link.find("inertial[@auto]") is not None):
            continue  # 1 kg and 1 kg m^2, or computed by Drake
        mass, inertia = _read(f"{path}: link '{name}'", link, is_sdf)
        if mass > 0:
            possible = possible_inertia(mass, inertia)
            if possible is not inertia:
                _write(link, mass, possible, is_sdf)
                is_rounded = np.abs(possible - inertia).max() <= _ROUNDED * np.trace(possible)
                if not (is_rounded and np.linalg.eigvalsh(inertia)[0] > 0):
                    moments = ", ".join(f"{moment:.3g}" for moment in np.diag(inertia))
                    note(MENDED, path, f"link '{name}': inertia ixx, iyy, izz", moments, NOT_POSSIBLE)
        elif name in jointed and name not in heavy:
            _write(link, *SPECK, is_sdf)
            note(MENDED, path, f"link '{name}': mass", f"{mass:g}", SPECK_WHY)
        else:
            massless(link, is_sdf)


def scale_inertias(path: Path, model: ET.Element, factor: float) -> None:
    """Multiplies the masses and moments of all links of a URDF or SDFormat model by a factor.

    Raises:
        InputError: if a mass or a moment is not a number.
    """
    is_sdf = model.tag == "model"
    for link in model.findall("link"):
        auto = link.find("inertial[@auto='true']")
        if auto is not None:  # computed by Drake, from the densities of the shapes or that of the link
            density = _child(auto, "density")
            density.text = density.text or _DENSITY
            for each in (density, *link.findall("collision/density")):
                each.text = repr(factor * float(each.text or _DENSITY))
        elif is_sdf or link.find("inertial") is not None:
            mass, inertia = _read(f"{path}: link '{link.get('name')}'", link, is_sdf)
            _write(link, factor * mass, factor * inertia, is_sdf)


def _heavy(path: Path, model: ET.Element, is_sdf: bool) -> set[str]:
    """The links to which something with a mass is fixed, directly or by way of others."""
    masses = {
        link.get("name", ""): _read(f"{path}: link '{link.get('name')}'", link, is_sdf)[0]
        for link in model.findall("link")
    }
    fixed = [joint for joint in model.findall("joint") if joint.get("type") == "fixed"]
    parents = {joint_end(joint, "child"): joint_end(joint, "parent") for joint in fixed}
    heavy = set[str]()
    for name in [name for name, mass in masses.items() if mass > 0]:
        while (name := parents.get(name, "")) and name not in heavy:
            heavy.add(name)
    return heavy


def massless(link: ET.Element, is_sdf: bool) -> ET.Element:
    """This link without mass, or with next to none in SDFormat, where a link that has none weighs 1 kg."""
    for inertial in link.findall("inertial"):
        link.remove(inertial)
    if is_sdf:
        _write(link, *NEXT_TO_NONE, is_sdf)
    return link


def _read(where: str, link: ET.Element, is_sdf: bool) -> tuple[float, Array]:
    inertial, inertia = link.find("inertial"), np.zeros((3, 3))
    entries = None if inertial is None else inertial.find("inertia")
    for key, (i, j) in _ENTRIES.items():
        inertia[i, j] = inertia[j, i] = number(where, entries, key, "1" if is_sdf and i == j else "0")
    return number(where, inertial, "mass", "1" if is_sdf else "0"), inertia


def _write(link: ET.Element, mass: float, inertia: Array, is_sdf: bool) -> None:
    inertial = _child(link, "inertial")
    entries = {key: repr(float(inertia[index])) for key, index in _ENTRIES.items()}
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


_LARGEST_GYRATION = 3.0  # times the farthest point of a link; a body's radius of gyration never exceeds one time


def note_spread(path: Path, parser: Parser, model: ModelInstanceIndex, stands: bool) -> None:
    """Notes which links have far larger inertias than bodies of their shapes and masses can have.

    The first link of a model that `stands`, fixed to the world, does not count.

    Raises:
        InputError: as `box_of`, or if a centre of mass is so far away that Drake cannot compute with it.
    """
    plant, scene_graph = parser.plant(), parser.scene_graph()
    if scene_graph is None:
        return
    inspector = scene_graph.model_inspector()
    for i, body in enumerate(map(plant.get_body, plant.GetBodyIndices(model))):
        mass, center = body.default_mass(), body.default_com()
        shapes = inspector.GetGeometries(plant.GetBodyFrameIdOrThrow(body.index()))
        boxes = [(inspector.GetPoseInFrame(shape), box_of(path, inspector, shape)) for shape in shapes]
        if (i == 0 and stands) or not mass > 0 or not boxes or any(box is None for _, box in boxes):
            continue
        inertia = body.default_spatial_inertia().Shift(center).CalcRotationalInertia()
        try:
            radius = float(np.sqrt(max(inertia.CalcPrincipalMomentsOfInertia()) / mass))
        except RuntimeError:
            expected = "is so large that its inertia overflows; give it in metres"
            raise InputError(path, f"link '{body.name()}': centre of mass", center.tolist(), expected) from None
        far = max(
            np.linalg.norm(X_BG @ box.center() - center) + np.linalg.norm(box.half_width()) for X_BG, box in boxes
        )
        if radius > _LARGEST_GYRATION * far:
            why = f"its mass lies {1e3 * radius:.3g} mm from its centre, and its shape ends at {1e3 * far:.3g} mm"
            note(READ, path, f"link '{body.name()}': inertia", "", f"{why}; is it in other units?")


def box_of(path: Path, inspector: SceneGraphInspector, shape: GeometryId) -> Any:
    """The oriented box around a shape of a model file; None if it has no end.

    Raises:
        InputError: if it is a mesh that is a line, a point or empty: Drake finds no box around it.
    """
    try:
        return inspector.GetObbInGeometryFrame(shape)
    except RuntimeError as error:
        mesh = inspector.GetShape(shape).source().description()
        raise InputError(path, "mesh", mesh, f"Drake cannot read it: {of_drake(first_line(error))}") from None
