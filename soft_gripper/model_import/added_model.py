"""A model once Drake has read it, whatever the form of its file: its mass, its friction and how it touches.

Drake touches a mesh at its hull unless its file asks for hydroelastic contact by tags of Drake, which files made for
other programs do not have, and MJCF cannot have. Sizes, masses and limits that are likely in other units than m, kg and
rad are noted or refused.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from pydrake.geometry import (
    AddRigidHydroelasticProperties,
    Convex,
    GeometryId,
    Mesh,
    ProximityProperties,
    Role,
    RoleAssign,
    SceneGraphInspector,
)
from pydrake.multibody.parsing import Parser
from pydrake.multibody.plant import AddMultibodyPlantSceneGraph, CoulombFriction, MultibodyPlant
from pydrake.multibody.tree import Joint, ModelInstanceIndex, RevoluteJoint
from pydrake.systems.framework import DiagramBuilder

from soft_gripper.errors import InputError, first_line
from soft_gripper.files.notes import READ
from soft_gripper.library_messages import original_message
from soft_gripper.model_import.drake_parsing import add_text, check_file
from soft_gripper.model_import.forms.mesh import MAX_SIZE
from soft_gripper.model_import.imported_model import ImportedModel, Mimic
from soft_gripper.model_import.model_file import ModelFile
from soft_gripper.models import package_map

_TIME_STEP = 1e-3  # s, of a plant that only weighs
_FRICTION_PROPERTY = "material", "coulomb_friction"  # Drake's names
_COMPLIANCE_PROPERTY = "hydroelastic", "compliance_type"
_LARGEST_GYRATION = 3.0  # times the farthest point of a link; a body's radius of gyration never exceeds one time
_LARGEST_LINK = 10.0  # m, of what is carried or moves
_MAX_FREE_MASS = 20.0  # kg, of a free object
_MAX_FRICTION = 3.0  # Coulomb friction
_MAX_ANGLE, _MIN_UNLIMITED = 4 * math.pi, 1000.0  # rad, of limits; larger ones mean that there is none


@dataclass(frozen=True)
class AddedModel:
    """A model in a plant that is not finalized."""

    file: ModelFile
    parser: Parser
    indices: Sequence[ModelInstanceIndex]  # of all models in the file
    mimics: Sequence[Mimic]
    earlier: frozenset[GeometryId]  # geometries of other models

    @property
    def plant(self) -> MultibodyPlant:
        return self.parser.plant()

    @property
    def index(self) -> ModelInstanceIndex:
        """The only model, or the first."""
        return self.indices[0]

    def joint(self, name: str) -> Joint:
        return self.plant.GetJointByName(name, self.index)

    @property
    def inspector(self) -> SceneGraphInspector:
        return self.parser.scene_graph().model_inspector()

    def replace_properties(self, geometry: GeometryId, properties: ProximityProperties) -> None:
        source = self.plant.get_source_id()
        self.parser.scene_graph().AssignRole(source, geometry, properties, RoleAssign.kReplace)

    def geometries(self, role: Role | None = None) -> set[GeometryId]:
        """Geometries that the file has added, of one role if given."""
        return _geometries(self.parser, role) - self.earlier


def add_model(parser: Parser, file: ModelFile, imported: ImportedModel) -> AddedModel:
    """Adds a model to the plant of a parser; raises an InputError if its text would end the process."""
    earlier = frozenset(_geometries(parser))
    if imported.text is None:
        check_file(file.path)
        indices = list(parser.AddModels(str(file.path)))
    else:
        indices = add_text(parser, imported.text, file.path, imported.suffix)
    return AddedModel(file, parser, indices, imported.mimics, earlier)


def model_mass(file: ModelFile, text: str, suffix: str) -> float:
    """The mass of all rigid links of a model, kg; notes on its text are left to who adds it to a plant."""
    builder = DiagramBuilder()
    plant, _ = AddMultibodyPlantSceneGraph(builder, _TIME_STEP)
    parser = Parser(plant)
    parser.package_map().AddMap(package_map())
    count = len(file.notes)
    models = add_text(parser, text, file.path, suffix)
    del file.notes[count:]
    return float(sum(plant.get_body(i).default_mass() for model in models for i in plant.GetBodyIndices(model)))


def _geometries(parser: Parser, role: Role | None = None) -> set[GeometryId]:
    scene_graph = parser.scene_graph()
    return set() if scene_graph is None else set(scene_graph.model_inspector().GetAllGeometryIds(role))


def set_friction(where: str, friction: float, model: AddedModel) -> None:
    """Gives all collision geometries of a model a Coulomb friction; raises an InputError if there are none."""
    shapes = model.geometries(Role.kProximity)
    if not shapes or any(map(model.inspector.IsDeformableGeometry, shapes)):
        raise InputError(where, "friction", friction, "leave it out: the model has no rigid shape that could touch")
    for shape in shapes:
        properties = ProximityProperties(model.inspector.GetProximityProperties(shape))
        properties.UpdateProperty(*_FRICTION_PROPERTY, CoulombFriction(friction, friction))
        model.replace_properties(shape, properties)


def touch_at_surfaces(model: AddedModel) -> None:
    """Lets fingers touch the meshes of a model at their true surface.

    A mesh keeps what its file says of hydroelastic contact; one that is convex is its own hull, which costs less.
    """
    from soft_gripper.model_import.mesh_files import CONVEX, hull_excess

    def is_convex(mesh: Mesh) -> bool:
        path = Path(mesh.source().path())
        return hull_excess(path, path.stat().st_mtime_ns) * CONVEX <= 1

    for geometry in model.geometries(Role.kProximity):
        inspector = model.inspector
        shape = inspector.GetShape(geometry)
        properties = ProximityProperties(inspector.GetProximityProperties(geometry))
        is_hull = not isinstance(shape, Mesh) or isinstance(shape, Convex) or is_convex(shape)
        if not (is_hull or inspector.IsDeformableGeometry(geometry) or properties.HasProperty(*_COMPLIANCE_PROPERTY)):
            AddRigidHydroelasticProperties(properties)
            model.replace_properties(geometry, properties)


def check_meshes(model: AddedModel, free: bool, is_fixture: bool) -> None:
    """Checks the sizes of meshes, seen or touched; raises an InputError if one is too large, or as `_box_of`.

    A free object is noted if it is larger than a gripper could hold, and a fixture in the world if it is large.
    """
    for geometry in model.geometries():
        shape = model.inspector.GetShape(geometry)
        is_mesh = isinstance(shape, Mesh | Convex) and not model.inspector.IsDeformableGeometry(geometry)
        box = _box_of(model, geometry) if is_mesh else None
        size = 0.0 if box is None else 2 * float(max(box.half_width()))
        if size <= (MAX_SIZE if free else _LARGEST_LINK):
            continue
        body = model.plant.GetBodyFromFrameId(model.inspector.GetFrameId(geometry)).name()
        expected = f"makes the link {size:.4g} m large; is the file in millimetres? then give a scale of 0.001"
        scale = " ".join(f"{factor:g}" for factor in shape.scale3())
        if size > _LARGEST_LINK and not is_fixture:
            raise InputError(f"{model.file.path}: link '{body}'", "mesh.scale", scale, expected)
        model.file.note(READ, f"link '{body}': mesh.scale", scale, expected)


def note_quantities(model: AddedModel, free: bool) -> None:
    """Notes masses of free objects, frictions, and limits of joints that are hardly meant."""
    plant = model.plant
    bodies = [plant.get_body(index) for index in plant.GetBodyIndices(model.index)]
    mass = sum(body.default_mass() for body in bodies)
    if free and mass > _MAX_FREE_MASS:
        model.file.note(READ, "mass", f"{mass:g} kg", "is it in grams?")
    for body in bodies:
        shapes = plant.GetCollisionGeometriesForBody(body)
        properties = [model.inspector.GetProximityProperties(shape) for shape in shapes]
        frictions = [p.GetProperty(*_FRICTION_PROPERTY) for p in properties if p and p.HasProperty(*_FRICTION_PROPERTY)]
        coefficients = [max(friction.static_friction(), friction.dynamic_friction()) for friction in frictions]
        if max(coefficients, default=0.0) > _MAX_FRICTION:
            why = "hardly any two materials have a coefficient of friction above 3"
            model.file.note(READ, f"link '{body.name()}': friction", f"{max(coefficients):g}", why)
    for joint in map(plant.get_joint, plant.GetJointIndices(model.index)):
        ends = [*joint.position_lower_limits(), *joint.position_upper_limits()]
        if isinstance(joint, RevoluteJoint) and _MAX_ANGLE < max(map(abs, ends)) < _MIN_UNLIMITED:
            why = f"up to {max(map(abs, ends)) / 2 / math.pi:.3g} turns; are they in degrees?"
            model.file.note(READ, f"joint '{joint.name()}': limits", f"{ends[0]:g} to {ends[1]:g} rad", why)


def note_spread(model: AddedModel, stands: bool) -> None:
    """Notes which links have far larger inertias than bodies of their shapes and masses can have.

    The first link of a model that `stands`, fixed to the world, does not count.

    Raises:
        InputError: as `_box_of`, or if a centre of mass is so far away that Drake cannot compute with it.
    """
    if model.parser.scene_graph() is None:
        return
    plant, inspector = model.plant, model.inspector
    for i, body in enumerate(map(plant.get_body, plant.GetBodyIndices(model.index))):
        mass, center = body.default_mass(), body.default_com()
        shapes = inspector.GetGeometries(plant.GetBodyFrameIdOrThrow(body.index()))
        boxes = [(inspector.GetPoseInFrame(shape), _box_of(model, shape)) for shape in shapes]
        if (i == 0 and stands) or not mass > 0 or not boxes or any(box is None for _, box in boxes):
            continue
        inertia = body.default_spatial_inertia().Shift(center).CalcRotationalInertia()
        try:
            radius = float(np.sqrt(max(inertia.CalcPrincipalMomentsOfInertia()) / mass))
        except RuntimeError:
            expected = "is so large that its inertia overflows; give it in metres"
            model.file.refuse(f"link '{body.name()}': centre of mass", center.tolist(), expected)
        extent = max(
            np.linalg.norm(X_BG @ box.center() - center) + np.linalg.norm(box.half_width()) for X_BG, box in boxes
        )
        if radius > _LARGEST_GYRATION * extent:
            why = f"its mass lies {1e3 * radius:.3g} mm from its centre, and its shape ends at {1e3 * extent:.3g} mm"
            model.file.note(READ, f"link '{body.name()}': inertia", "", f"{why}; is it in other units?")


def _box_of(model: AddedModel, shape: GeometryId) -> Any:
    """The oriented box around a shape, None if it has no end; raises an InputError for a mesh that is a line."""
    try:
        return model.inspector.GetObbInGeometryFrame(shape)
    except RuntimeError as error:
        mesh = model.inspector.GetShape(shape).source().description()
        model.file.refuse("mesh", mesh, f"Drake cannot read it: {original_message(first_line(error))}")
