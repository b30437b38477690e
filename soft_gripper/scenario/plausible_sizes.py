"""Sizes, masses and limits of a model that are likely in other units than m, kg and rad."""

import math
from collections.abc import Collection, Sequence
from pathlib import Path

from pydrake.geometry import Convex, GeometryId, Mesh
from pydrake.multibody.parsing import Parser
from pydrake.multibody.plant import CoulombFriction
from pydrake.multibody.tree import ModelInstanceIndex, RevoluteJoint

from soft_gripper.errors import InputError
from soft_gripper.files.notes import READ, note
from soft_gripper.fingers.finger import Finger
from soft_gripper.scenario.link_inertia import box_of
from soft_gripper.scenario.mass_and_friction import geometries
from soft_gripper.scenario.mesh_object import MAX_SIZE

_LARGEST_LINK = 10.0  # m, of what is carried or moves
_LONGEST_FINGER = 1.0  # m
_HEAVIEST = 20.0  # kg, of a free object
_ROUGHEST = 3.0  # Coulomb friction
_MOST_TURNS, _UNLIMITED = 4 * math.pi, 1000.0  # rad, of limits; larger ones mean that there is none


def check_meshes(path: Path, parser: Parser, before: Collection[GeometryId], free: bool, is_fixture: bool) -> None:
    """Checks the sizes of the meshes that a model has added, seen or touched, to geometries there `before`.

    Args:
        path: file of the model.
        parser: its plant.
        before: geometries that are not those of the model.
        free: the model is an object to grasp, and noted if it is larger than a gripper could hold.
        is_fixture: the model stands in the world, where a mesh may be large: it is noted.

    Raises:
        InputError: if a mesh is too large for a link, or as `box_of`.
    """
    plant, scene_graph = parser.plant(), parser.scene_graph()
    for geometry in geometries(parser) - set(before):
        inspector = scene_graph.model_inspector()
        shape = inspector.GetShape(geometry)
        is_mesh = isinstance(shape, Mesh | Convex) and not inspector.IsDeformableGeometry(geometry)
        box = box_of(path, inspector, geometry) if is_mesh else None
        size = 0.0 if box is None else 2 * float(max(box.half_width()))
        if size <= (MAX_SIZE if free else _LARGEST_LINK):
            continue
        body = plant.GetBodyFromFrameId(inspector.GetFrameId(geometry)).name()
        expected = f"makes the link {size:.4g} m large; is the file in millimetres? then give a scale of 0.001"
        scale = " ".join(f"{factor:g}" for factor in shape.scale3())
        if size > _LARGEST_LINK and not is_fixture:
            raise InputError(f"{path}: link '{body}'", "mesh.scale", scale, expected)
        note(READ, path, f"link '{body}': mesh.scale", scale, expected)


def note_quantities(
    path: Path, parser: Parser, model: ModelInstanceIndex, fingers: Sequence[Finger], free: bool
) -> None:
    """Notes lengths of fingers, masses of free objects, frictions, and limits of joints that are hardly meant.

    Args:
        path: file of the model.
        parser: its plant.
        model: the model in it.
        fingers: its fingers.
        free: the model is an object to grasp.
    """
    plant = parser.plant()
    bodies = [plant.get_body(index) for index in plant.GetBodyIndices(model)]
    for finger in fingers:
        if finger.length > _LONGEST_FINGER:
            note(READ, path, f"finger '{finger.name}': length", f"{finger.length:g} m", "is it in millimetres?")
    mass = sum(body.default_mass() for body in bodies)
    if free and mass > _HEAVIEST:
        note(READ, path, "mass", f"{mass:g} kg", "is it in grams?")
    for body in bodies:
        rough = [_friction(parser, geometry) for geometry in plant.GetCollisionGeometriesForBody(body)]
        if max(rough, default=0.0) > _ROUGHEST:
            why = "hardly any two materials have a coefficient of friction above 3"
            note(READ, path, f"link '{body.name()}': friction", f"{max(rough):g}", why)
    for joint in map(plant.get_joint, plant.GetJointIndices(model)):
        ends = [*joint.position_lower_limits(), *joint.position_upper_limits()]
        if isinstance(joint, RevoluteJoint) and _MOST_TURNS < max(map(abs, ends)) < _UNLIMITED:
            why = f"up to {max(map(abs, ends)) / 2 / math.pi:.3g} turns; are they in degrees?"
            note(READ, path, f"joint '{joint.name()}': limits", f"{ends[0]:g} to {ends[1]:g} rad", why)


def _friction(parser: Parser, geometry: GeometryId) -> float:
    """The larger coefficient of friction of a geometry; 0 if it has none."""
    properties = parser.scene_graph().model_inspector().GetProximityProperties(geometry)
    if properties is None or not properties.HasProperty("material", "coulomb_friction"):
        return 0.0
    friction: CoulombFriction = properties.GetProperty("material", "coulomb_friction")
    return max(friction.static_friction(), friction.dynamic_friction())
