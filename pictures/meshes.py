"""Meshes without normals, which Drake's renderer refuses, given some."""

import trimesh
from pydrake.common import MemoryFile
from pydrake.geometry import InMemoryMesh, Mesh, Role, SceneGraph, SourceId


def give_normals(scene_graph: SceneGraph, source: SourceId) -> None:
    """Puts meshes with normals in the place of OBJ files without, wherever a renderer would see one."""
    inspector = scene_graph.model_inspector()
    for geometry in inspector.GetAllGeometryIds(Role.kPerception):
        shape = inspector.GetShape(geometry)
        if isinstance(shape, Mesh) and shape.extension() == ".obj" and shape.source().is_path():
            text = shape.source().path().read_text(encoding="utf-8")
            if "\nvn " not in text:
                scene_graph.ChangeShape(source, geometry, _with_normals(shape))


def _with_normals(mesh: Mesh) -> Mesh:
    """The same mesh, shaded smoothly but for its sharp edges."""
    smooth = trimesh.load(mesh.source().path(), force="mesh").smooth_shaded
    text = trimesh.exchange.obj.export_obj(smooth, include_normals=True, include_texture=False, header=None)
    return Mesh(InMemoryMesh(mesh_file=MemoryFile(text, ".obj", "mesh with normals")), mesh.scale3())
