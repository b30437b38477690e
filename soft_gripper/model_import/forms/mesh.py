"""A bare mesh as an object: checked, with an inertia, and described as SDFormat."""

import xml.etree.ElementTree as ET
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

from soft_gripper.files.xml_text import DRAKE
from soft_gripper.model_import.imported_model import Form, ImportedModel, ImportOptions
from soft_gripper.model_import.links_and_joints import write_inertial
from soft_gripper.model_import.model_file import ModelFile
from soft_gripper.registry import registered

if TYPE_CHECKING:  # imported when a mesh is read
    pass

SUFFIXES = (".obj", ".stl", ".ply", ".off", ".glb", ".gltf", *registered("MESHES"))
MASS, FRICTION = 0.05, 0.8  # kg, Coulomb: of a mesh for which none is given
MAX_SIZE = 1.0  # m; a gripper of this size grasps nothing larger


def read(file: ModelFile, options: ImportOptions) -> ImportedModel:
    """SDFormat text of an object of uniform density: rigid, unless the options add another link.

    A rigid object touches compliant fingers with its true surface, not with its hull. Meshes are kept as scaled files
    in the user's cache folder, whatever their format was.

    Raises:
        InputError: if the mesh is missing, empty, not watertight, or of an implausible size.
    """
    from soft_gripper.model_import.mesh_files import keep_by_content, obj_text, read_scene
    from soft_gripper.model_import.solid_mesh import solid

    mesh = solid(file, read_scene(file.path).to_mesh())
    mesh.apply_scale(options.scale)
    if not 1e-3 <= (size := float(max(mesh.extents))) <= MAX_SIZE:
        hint = "is the file in millimetres? then give mesh.scale: 0.001" if size > MAX_SIZE else "too small to grasp"
        file.refuse("mesh.scale", options.scale, f"makes the object {size:.4g} m large; {hint}")
    root = ET.Element("sdf", version="1.7")
    link = ET.SubElement(ET.SubElement(root, "model", name=options.name), "link", name=options.name)
    mesh.density = (MASS if options.mass is None else options.mass) / mesh.volume
    friction = FRICTION if options.friction is None else options.friction
    if options.add_to_link is not None:
        options.add_to_link(link, file.path, mesh.density, friction)
    else:
        inertial = write_inertial(link, float(mesh.mass), mesh.moment_inertia, is_sdf=True)
        ET.SubElement(inertial, "pose").text = _text([*mesh.center_mass, 0, 0, 0])
        uri = f"file://{keep_by_content(obj_text(mesh))}"
        add_visual(link, uri, options.color)
        contact = ET.SubElement(add_geometry(link, "collision", uri), DRAKE + "proximity_properties")
        ET.SubElement(contact, DRAKE + "rigid_hydroelastic")
        add_values(contact, {"mu_static": friction, "mu_dynamic": friction, "hunt_crossley_dissipation": 2.0})
    return ImportedModel(ET.tostring(root, encoding="unicode"), ".sdf")


FORM = Form("mesh", SUFFIXES, read)


def add_visual(link: ET.Element, uri: str, color: Sequence[float]) -> None:
    visual = add_geometry(link, "visual", uri)
    ET.SubElement(ET.SubElement(visual, "material"), "diffuse").text = _text(color)


def add_values(element: ET.Element, values: Mapping[str, object]) -> None:
    for key, value in values.items():
        ET.SubElement(element, DRAKE + key).text = str(value)


def add_geometry(link: ET.Element, kind: str, uri: str) -> ET.Element:
    element = ET.SubElement(link, kind, name=kind)
    ET.SubElement(ET.SubElement(ET.SubElement(element, "geometry"), "mesh"), "uri").text = uri
    return element


def _text(values: Sequence[float]) -> str:
    return " ".join(str(float(value)) for value in values)
