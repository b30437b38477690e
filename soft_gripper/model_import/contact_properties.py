"""Contact properties of a model: its friction, and the surfaces of its meshes, instead of their convex hulls.

Drake touches a mesh at its hull unless its file asks for hydroelastic contact by tags of Drake, which files made for
other programs do not have, and MJCF cannot have.
"""

from pathlib import Path

from pydrake.geometry import (
    AddRigidHydroelasticProperties,
    Convex,
    Mesh,
    ProximityProperties,
    Role,
    RoleAssign,
)
from pydrake.multibody.plant import CoulombFriction

from soft_gripper.errors import InputError
from soft_gripper.model_import.added_model import AddedModel

# Drake's names of properties.
_FRICTION_PROPERTY = "material", "coulomb_friction"
_COMPLIANCE_PROPERTY = "hydroelastic", "compliance_type"


def set_friction(where: str, friction: float, model: AddedModel) -> None:
    """Gives all collision geometries of a model a Coulomb friction; raises an InputError if there are none."""
    plant = model.plant
    scene_graph = model.parser.scene_graph()
    shapes = model.geometries(Role.kProximity)
    if not shapes or any(map(scene_graph.model_inspector().IsDeformableGeometry, shapes)):
        raise InputError(where, "friction", friction, "leave it out: the model has no rigid shape that could touch")
    for shape in shapes:
        properties = ProximityProperties(scene_graph.model_inspector().GetProximityProperties(shape))
        properties.UpdateProperty(*_FRICTION_PROPERTY, CoulombFriction(friction, friction))
        scene_graph.AssignRole(plant.get_source_id(), shape, properties, RoleAssign.kReplace)


def touch_at_surfaces(model: AddedModel) -> None:
    """Lets fingers touch the meshes of a model at their true surface.

    A mesh keeps what its file says of hydroelastic contact; one that is convex is its own hull, which costs less.
    """
    plant, scene_graph = model.plant, model.parser.scene_graph()
    for geometry in model.geometries(Role.kProximity):
        inspector = scene_graph.model_inspector()
        shape = inspector.GetShape(geometry)
        properties = ProximityProperties(inspector.GetProximityProperties(geometry))
        is_hull = not isinstance(shape, Mesh) or isinstance(shape, Convex) or _is_convex(shape)
        if not (is_hull or inspector.IsDeformableGeometry(geometry) or properties.HasProperty(*_COMPLIANCE_PROPERTY)):
            AddRigidHydroelasticProperties(properties)
            scene_graph.AssignRole(plant.get_source_id(), geometry, properties, RoleAssign.kReplace)


def _is_convex(mesh: Mesh) -> bool:
    from soft_gripper.model_import.convex_parts import CONVEX, hull_excess

    path = Path(mesh.source().path())
    return hull_excess(path, path.stat().st_mtime_ns) * CONVEX <= 1
