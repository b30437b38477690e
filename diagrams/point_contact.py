"""Point contact: fingers touch other bodies at points of their skin, not over patches of it.

Every link carries spheres under its skin, see `finger_links`; they meet the shapes of other bodies in Drake's point
contact, which costs less than a surface with as many polygons as it has. What it changes, and what it saves, is
measured in docs/solver.md. Bodies that are not convex are given convex parts, and other bodies touch each other as
before.
"""

from collections.abc import Iterable
from pathlib import Path

from pydrake.geometry import (
    CollisionFilterDeclaration,
    Convex,
    GeometryId,
    GeometrySet,
    Mesh,
    ProximityProperties,
    Role,
    RoleAssign,
    SceneGraph,
)
from pydrake.multibody.plant import MultibodyPlant

_RIGID_STIFFNESS = 1e12  # N/m, of what touches a finger: the skin alone gives way
_MATERIAL_GROUP = "material"
_STIFFNESS_PROPERTY = "point_contact_stiffness"
_HYDROELASTIC_GROUP = "hydroelastic"


def prepare_point_contact(plant: MultibodyPlant, scene_graph: SceneGraph, skins: Iterable[GeometryId]) -> None:
    """Makes all bodies of a plant fit to be touched by the points of fingers, whose geometries are `skins`."""
    inspector = scene_graph.model_inspector()
    compliant = set(skins)
    rigid = [geometry for geometry in inspector.GetAllGeometryIds(Role.kProximity) if geometry not in compliant]
    for geometry in rigid:
        shape = inspector.GetShape(geometry)
        if isinstance(shape, Mesh) and not isinstance(shape, Convex):
            _add_parts(plant, scene_graph, geometry, shape, compliant)
        else:
            properties = _properties(scene_graph, geometry)
            if properties.HasGroup(
                _HYDROELASTIC_GROUP
            ):  # others touch at points already, with a stiffness of their own
                scene_graph.AssignRole(plant.get_source_id(), geometry, properties, RoleAssign.kReplace)


def _properties(scene_graph: SceneGraph, geometry: GeometryId) -> ProximityProperties:
    """Properties of a geometry, but rigid in point contact."""
    properties = ProximityProperties(scene_graph.model_inspector().GetProximityProperties(geometry))
    properties.UpdateProperty(_MATERIAL_GROUP, _STIFFNESS_PROPERTY, _RIGID_STIFFNESS)
    return properties


def _add_parts(
    plant: MultibodyPlant, scene_graph: SceneGraph, geometry: GeometryId, mesh: Mesh, skins: set[GeometryId]
) -> None:
    """Adds convex parts to the body of a mesh, which fingers touch in place of the mesh."""
    from soft_gripper.model_import.mesh_files import convex_parts

    inspector = scene_graph.model_inspector()
    body = plant.GetBodyFromFrameId(inspector.GetFrameId(geometry))
    pose = inspector.GetPoseInFrame(geometry)
    properties = _properties(scene_graph, geometry)
    if properties.HasGroup(_HYDROELASTIC_GROUP):
        for name in list(properties.GetPropertiesInGroup(_HYDROELASTIC_GROUP)):
            properties.RemoveProperty(_HYDROELASTIC_GROUP, name)
    path = Path(mesh.source().path())
    parts = [
        plant.RegisterCollisionGeometry(
            body,
            pose,
            Convex((corners * mesh.scale3()).T, f"part {i}"),
            f"{inspector.GetName(geometry)}_part_{i}",
            properties,
        )
        for i, corners in enumerate(convex_parts(path, path.stat().st_mtime_ns))
    ]
    rigid = [geometry for geometry in inspector.GetAllGeometryIds(Role.kProximity) if geometry not in skins]
    for group, other_group in (([geometry], skins), (parts, rigid)):
        excluded = CollisionFilterDeclaration().ExcludeBetween(GeometrySet(list(group)), GeometrySet(list(other_group)))
        scene_graph.collision_filter_manager().Apply(excluded)
