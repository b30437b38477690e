"""An object changed in a context: its mass, its shapes, what it is like to touch. The plant is not built again."""

from pydrake.geometry import (
    Box,
    Capsule,
    Cylinder,
    Ellipsoid,
    ProximityProperties,
    Role,
    RoleAssign,
    SceneGraph,
    Shape,
    Sphere,
)
from pydrake.math import RigidTransform
from pydrake.multibody.plant import CoulombFriction, MultibodyPlant
from pydrake.multibody.tree import RigidBody, SpatialInertia, UnitInertia
from pydrake.systems.framework import Context

from soft_gripper.errors import InputError


def scaled_shape(shape: Shape, factor: float) -> Shape:
    """A shape with all its lengths multiplied.

    Raises:
        InputError: if it is none of the primitives that have lengths.
    """
    match shape:
        case Sphere():
            return Sphere(factor * shape.radius())
        case Box():
            return Box(factor * shape.size())
        case Capsule():
            return Capsule(factor * shape.radius(), factor * shape.length())
        case Cylinder():
            return Cylinder(factor * shape.radius(), factor * shape.length())
        case Ellipsoid():
            return Ellipsoid(factor * shape.a(), factor * shape.b(), factor * shape.c())
    expected = "give an object of spheres, boxes, capsules, cylinders or ellipsoids; or leave out variation.size"
    raise InputError("variation", "size", type(shape).__name__, expected)


def scale_shapes(
    scene_graph: SceneGraph,
    context: Context,
    plant: MultibodyPlant,
    body: RigidBody,
    factor: float,
    seen: bool,
) -> None:
    """Multiplies all lengths of a body about its frame, and if it is `seen` of what is seen of it.

    `context` is the SceneGraph's.
    """
    inspector, source = scene_graph.model_inspector(), plant.get_source_id()
    frame = plant.GetBodyFrameIdOrThrow(body.index())
    for shape in inspector.GetGeometries(frame) if seen else inspector.GetGeometries(frame, Role.kProximity):
        X_BG = inspector.GetPoseInFrame(shape)
        moved = RigidTransform(X_BG.rotation(), factor * X_BG.translation())
        scene_graph.ChangeShape(context, source, shape, scaled_shape(inspector.GetShape(shape), factor), moved)


def change_contact(
    scene_graph: SceneGraph,
    context: Context,
    plant: MultibodyPlant,
    body: RigidBody,
    friction: float | None,
    stiffness: float | None,
) -> None:
    """Gives a body another friction and another stiffness of points of contact, N/m; None: as before.

    `context` is the SceneGraph's.
    """
    for shape in plant.GetCollisionGeometriesForBody(body):
        properties = ProximityProperties(scene_graph.model_inspector().GetProximityProperties(shape))
        if friction is not None:
            properties.UpdateProperty("material", "coulomb_friction", CoulombFriction(friction, friction))
        if stiffness is not None:
            properties.UpdateProperty("material", "point_contact_stiffness", stiffness)
        scene_graph.AssignRole(context, plant.get_source_id(), shape, properties, RoleAssign.kReplace)


def set_mass(context: Context, body: RigidBody, mass: float | None, size: float) -> None:
    """Gives a body another mass, kg, and the inertia that goes with it and a factor of its lengths.

    `context` is the plant's; None: the mass as before.
    """
    before = body.CalcSpatialInertiaInBodyFrame(context)
    unit = before.get_unit_inertia()
    unit = UnitInertia(*(size**2 * unit.get_moments()), *(size**2 * unit.get_products()))
    inertia = SpatialInertia(before.get_mass() if mass is None else mass, size * before.get_com(), unit)
    body.SetSpatialInertiaInBodyFrame(context, inertia)
