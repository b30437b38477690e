"""Sizes, masses and limits of a model that are likely in other units than m, kg and rad."""

import math
from typing import Any

import numpy as np
from pydrake.geometry import Convex, GeometryId, Mesh, SceneGraphInspector
from pydrake.multibody.plant import CoulombFriction
from pydrake.multibody.tree import RevoluteJoint

from soft_gripper.errors import InputError, first_line
from soft_gripper.files.notes import READ
from soft_gripper.library_messages import original_message
from soft_gripper.model_import.added_model import AddedModel
from soft_gripper.model_import.forms.mesh import MAX_SIZE

_LARGEST_GYRATION = 3.0  # times the farthest point of a link; a body's radius of gyration never exceeds one time
_LARGEST_LINK = 10.0  # m, of what is carried or moves
_MAX_FREE_MASS = 20.0  # kg, of a free object
_MAX_FRICTION = 3.0  # Coulomb friction
_MAX_ANGLE, _MIN_UNLIMITED = 4 * math.pi, 1000.0  # rad, of limits; larger ones mean that there is none


def check_meshes(model: AddedModel, free: bool, is_fixture: bool) -> None:
    """Checks the sizes of the meshes of a model, seen or touched.

    Args:
        model: in a plant.
        free: the model is an object to grasp, and noted if it is larger than a gripper could hold.
        is_fixture: the model stands in the world, where a mesh may be large: it is noted.

    Raises:
        InputError: if a mesh is too large for a link, or as `_box_of`.
    """
    plant, scene_graph = model.plant, model.parser.scene_graph()
    for geometry in model.geometries():
        inspector = scene_graph.model_inspector()
        shape = inspector.GetShape(geometry)
        is_mesh = isinstance(shape, Mesh | Convex) and not inspector.IsDeformableGeometry(geometry)
        box = _box_of(model, inspector, geometry) if is_mesh else None
        size = 0.0 if box is None else 2 * float(max(box.half_width()))
        if size <= (MAX_SIZE if free else _LARGEST_LINK):
            continue
        body = plant.GetBodyFromFrameId(inspector.GetFrameId(geometry)).name()
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
        coefficients = [_friction(model, geometry) for geometry in plant.GetCollisionGeometriesForBody(body)]
        if max(coefficients, default=0.0) > _MAX_FRICTION:
            why = "hardly any two materials have a coefficient of friction above 3"
            model.file.note(READ, f"link '{body.name()}': friction", f"{max(coefficients):g}", why)
    for joint in map(plant.get_joint, plant.GetJointIndices(model.index)):
        ends = [*joint.position_lower_limits(), *joint.position_upper_limits()]
        if isinstance(joint, RevoluteJoint) and _MAX_ANGLE < max(map(abs, ends)) < _MIN_UNLIMITED:
            why = f"up to {max(map(abs, ends)) / 2 / math.pi:.3g} turns; are they in degrees?"
            model.file.note(READ, f"joint '{joint.name()}': limits", f"{ends[0]:g} to {ends[1]:g} rad", why)


def _friction(model: AddedModel, geometry: GeometryId) -> float:
    """The larger coefficient of friction of a geometry; 0 if it has none."""
    properties = model.parser.scene_graph().model_inspector().GetProximityProperties(geometry)
    if properties is None or not properties.HasProperty("material", "coulomb_friction"):
        return 0.0
    friction: CoulombFriction = properties.GetProperty("material", "coulomb_friction")
    return max(friction.static_friction(), friction.dynamic_friction())


def note_spread(model: AddedModel, stands: bool) -> None:
    """Notes which links have far larger inertias than bodies of their shapes and masses can have.

    The first link of a model that `stands`, fixed to the world, does not count.

    Raises:
        InputError: as `_box_of`, or if a centre of mass is so far away that Drake cannot compute with it.
    """
    plant, scene_graph = model.plant, model.parser.scene_graph()
    if scene_graph is None:
        return
    inspector = scene_graph.model_inspector()
    for i, body in enumerate(map(plant.get_body, plant.GetBodyIndices(model.index))):
        mass, center = body.default_mass(), body.default_com()
        shapes = inspector.GetGeometries(plant.GetBodyFrameIdOrThrow(body.index()))
        boxes = [(inspector.GetPoseInFrame(shape), _box_of(model, inspector, shape)) for shape in shapes]
        if (i == 0 and stands) or not mass > 0 or not boxes or any(box is None for _, box in boxes):
            continue
        inertia = body.default_spatial_inertia().Shift(center).CalcRotationalInertia()
        try:
            radius = float(np.sqrt(max(inertia.CalcPrincipalMomentsOfInertia()) / mass))
        except RuntimeError:
            expected = "is so large that its inertia overflows; give it in metres"
            raise InputError(
                model.file.path, f"link '{body.name()}': centre of mass", center.tolist(), expected
            ) from None
        extent = max(
            np.linalg.norm(X_BG @ box.center() - center) + np.linalg.norm(box.half_width()) for X_BG, box in boxes
        )
        if radius > _LARGEST_GYRATION * extent:
            why = f"its mass lies {1e3 * radius:.3g} mm from its centre, and its shape ends at {1e3 * extent:.3g} mm"
            model.file.note(READ, f"link '{body.name()}': inertia", "", f"{why}; is it in other units?")


def _box_of(model: AddedModel, inspector: SceneGraphInspector, shape: GeometryId) -> Any:
    """The oriented box around a shape of a model file; None if it has no end.

    Raises:
        InputError: if it is a mesh that is a line, a point or empty: Drake finds no box around it.
    """
    try:
        return inspector.GetObbInGeometryFrame(shape)
    except RuntimeError as error:
        mesh = inspector.GetShape(shape).source().description()
        raise InputError(
            model.file.path, "mesh", mesh, f"Drake cannot read it: {original_message(first_line(error))}"
        ) from None
