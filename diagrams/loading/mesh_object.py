"""A mesh file of the user's, made an object: checked, given an inertia, and described as SDFormat."""

import xml.etree.ElementTree as ET
from pathlib import Path

import numpy as np
import trimesh

from soft_gripper.diagrams.loading.mesh_cache import keep_by_content, read_scene
from soft_gripper.diagrams.schema.scenario import MeshConfig
from soft_gripper.errors import InputError
from soft_gripper.fingers.finger_links import DRAKE

MESH_SUFFIXES = (".obj", ".stl", ".ply", ".off", ".glb", ".gltf")
MAX_SIZE = 1.0  # m; a gripper of this size grasps nothing larger


def mesh_to_sdf(path: Path, config: MeshConfig, name: str) -> str:
    """SDFormat text of a rigid object whose true surface, not its hull, meets compliant fingers.

    The mesh is kept as a scaled OBJ file in the user's cache folder, whatever its format was.

    Raises:
        InputError: if the mesh is missing, empty, not watertight, or of a size that cannot be meant.
    """
    mesh = read_scene(path).to_mesh()
    mesh.apply_scale(config.scale)
    _check(path, mesh, config)
    mesh.density = config.mass / mesh.volume
    root = ET.Element("sdf", version="1.7")
    link = ET.SubElement(ET.SubElement(root, "model", name=name), "link", name=name)
    _add_inertia(link, mesh)
    uri = f"file://{keep_by_content(_obj(mesh))}"
    visual = _add_shape(link, "visual", uri)
    ET.SubElement(ET.SubElement(visual, "material"), "diffuse").text = _text(config.color)
    contact = ET.SubElement(_add_shape(link, "collision", uri), DRAKE + "proximity_properties")
    ET.SubElement(contact, DRAKE + "rigid_hydroelastic")
    properties = {
        "mu_static": config.friction,
        "mu_dynamic": config.friction,
        "hunt_crossley_dissipation": 2.0,
    }
    for key, value in properties.items():
        ET.SubElement(contact, DRAKE + key).text = str(value)
    return ET.tostring(root, encoding="unicode")


def _check(path: Path, mesh: trimesh.Trimesh, config: MeshConfig) -> None:
    if not mesh.is_watertight:
        expected = "is not watertight; close its holes, since an open surface has no volume and no inertia"
        raise InputError(path, "mesh", path.name, expected)
    size = float(max(mesh.extents))
    if not 1e-3 <= size <= MAX_SIZE:
        hint = "is the file in millimetres? then give mesh.scale: 0.001" if size > MAX_SIZE else "too small to grasp"
        raise InputError(path, "mesh.scale", config.scale, f"makes the object {size:.4g} m large; {hint}")
    if mesh.volume < 0:
        mesh.invert()


def _add_inertia(link: ET.Element, mesh: trimesh.Trimesh) -> None:
    inertial = ET.SubElement(link, "inertial")
    ET.SubElement(inertial, "pose").text = _text([*mesh.center_mass, 0, 0, 0])
    ET.SubElement(inertial, "mass").text = repr(float(mesh.mass))
    inertia = ET.SubElement(inertial, "inertia")
    moments = mesh.moment_inertia
    for i, j in zip(*np.triu_indices(3), strict=True):
        ET.SubElement(inertia, "i" + "xyz"[i] + "xyz"[j]).text = repr(float(moments[i, j]))


def _add_shape(link: ET.Element, kind: str, uri: str) -> ET.Element:
    shape = ET.SubElement(link, kind, name=kind)
    ET.SubElement(ET.SubElement(ET.SubElement(shape, "geometry"), "mesh"), "uri").text = uri
    return shape


def _obj(mesh: trimesh.Trimesh) -> str:
    text: str = trimesh.exchange.obj.export_obj(mesh, include_texture=False, include_normals=False, header=None)
    return text


def _text(values: list[float]) -> str:
    return " ".join(str(float(value)) for value in values)
