"""Mass and friction that a scenario gives a model, in the place of those of its file."""

import xml.etree.ElementTree as ET
from collections.abc import Collection
from pathlib import Path

from pydrake.geometry import GeometryId, ProximityProperties, Role, RoleAssign
from pydrake.multibody.parsing import Parser
from pydrake.multibody.plant import AddMultibodyPlantSceneGraph, CoulombFriction
from pydrake.systems.framework import DiagramBuilder

from soft_gripper.errors import InputError
from soft_gripper.files.notes import kept
from soft_gripper.models import package_map
from soft_gripper.scenario.drake_parsing import add_text
from soft_gripper.scenario.link_inertia import scale_inertias
from soft_gripper.scenario.mjcf_xml import scale_masses
from soft_gripper.scenario.model_xml import models_of

_TIME_STEP = 1e-3  # s, of a plant that only weighs
_MATERIAL, _FRICTION = "material", "coulomb_friction"  # Drake's names of the property


def with_mass(where: str, mass: float, text: str, path: Path, suffix: str) -> str:
    """The text of a model, derived from `path`, whose links weigh `mass`, kg, together.

    All masses and moments change by one factor, so that centres of mass and radii of gyration stay.

    Raises:
        InputError: if the model has no mass of rigid links that could change.
    """
    before = _weight(text, path, suffix)
    if not before > 0:
        raise InputError(where, "mass", mass, f"leave it out: {path.name} has no rigid link with a mass to change")
    root, factor = ET.fromstring(text), mass / before
    if root.tag == "mujoco":
        scale_masses(path, root, factor)
    else:
        for model in models_of(root):
            scale_inertias(path, model, factor)
    return ET.tostring(root, encoding="unicode")


def _weight(text: str, path: Path, suffix: str) -> float:
    """The mass of all rigid links of a model as Drake reads it, kg; notes on the file are left to who loads it."""
    builder = DiagramBuilder()
    plant, _ = AddMultibodyPlantSceneGraph(builder, _TIME_STEP)
    parser = Parser(plant)
    parser.package_map().AddMap(package_map())
    with kept():
        models = add_text(parser, text, path, suffix)
    return float(sum(plant.get_body(i).default_mass() for model in models for i in plant.GetBodyIndices(model)))


def geometries(parser: Parser, role: Role | None = None) -> set[GeometryId]:
    """All geometries of the plant of a parser so far, or those with a role."""
    scene_graph = parser.scene_graph()
    return set() if scene_graph is None else set(scene_graph.model_inspector().GetAllGeometryIds(role))


def set_friction(where: str, friction: float, parser: Parser, before: Collection[GeometryId]) -> None:
    """Gives all collision geometries of the plant of a parser, but those there `before`, a Coulomb friction.

    Raises:
        InputError: if there are none.
    """
    plant, scene_graph, added = parser.plant(), parser.scene_graph(), geometries(parser, Role.kProximity) - set(before)
    if not added or any(map(scene_graph.model_inspector().IsDeformableGeometry, added)):
        raise InputError(where, "friction", friction, "leave it out: the model has no rigid shape that could touch")
    for shape in added:
        properties = ProximityProperties(scene_graph.model_inspector().GetProximityProperties(shape))
        properties.UpdateProperty(_MATERIAL, _FRICTION, CoulombFriction(friction, friction))
        scene_graph.AssignRole(plant.get_source_id(), shape, properties, RoleAssign.kReplace)
