"""Contact surfaces of the meshes in model files: objects are touched at their surface, not at their convex hull.

Drake touches a mesh at its hull unless its file asks for hydroelastic contact by tags of Drake, which files made for
other programs do not have, and MJCF cannot have.
"""

from collections.abc import Collection
from pathlib import Path

from pydrake.geometry import (
    AddRigidHydroelasticProperties,
    Convex,
    GeometryId,
    Mesh,
    ProximityProperties,
    Role,
    RoleAssign,
)
from pydrake.multibody.parsing import Parser

from soft_gripper.scenario.convex_parts import CONVEX, hull_excess
from soft_gripper.scenario.mass_and_friction import geometries

_TYPE = "hydroelastic", "compliance_type"  # Drake's name of the property


def touch_at_surfaces(parser: Parser, before: Collection[GeometryId]) -> None:
    """Lets fingers touch the meshes of the plant of a parser, but those there `before`, at their true surface.

    A mesh keeps what its file says of hydroelastic contact; one that is convex is its own hull, which costs less.
    """
    plant, scene_graph = parser.plant(), parser.scene_graph()
    for geometry in geometries(parser, Role.kProximity) - set(before):
        inspector = scene_graph.model_inspector()
        shape = inspector.GetShape(geometry)
        properties = ProximityProperties(inspector.GetProximityProperties(geometry))
        is_hull = not isinstance(shape, Mesh) or isinstance(shape, Convex) or _is_convex(shape)
        if not (is_hull or inspector.IsDeformableGeometry(geometry) or properties.HasProperty(*_TYPE)):
            AddRigidHydroelasticProperties(properties)
            scene_graph.AssignRole(plant.get_source_id(), geometry, properties, RoleAssign.kReplace)


def _is_convex(mesh: Mesh) -> bool:
    path = Path(mesh.source().path())
    return hull_excess(path, path.stat().st_mtime_ns) * CONVEX <= 1
