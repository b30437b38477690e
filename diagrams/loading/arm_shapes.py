"""Shapes of third-party URDF files: meshes that Drake reads, and colours."""

import xml.etree.ElementTree as ET
from pathlib import Path

from soft_gripper.diagrams.loading.mesh_cache import check_mesh_file, converted
from soft_gripper.diagrams.loading.mesh_names import is_known_package, mesh_file
from soft_gripper.errors import InputError
from soft_gripper.fingers.finger_links import DRAKE

_DRAKE_READS = (".obj", ".gltf", ".vtk")


def convert_meshes(path: Path, robot: ET.Element) -> None:
    """Gives all shapes of a URDF mesh files that Drake reads, of which it takes the convex hulls for collisions.

    Args:
        path: of the URDF file, to which relative names refer.

    Raises:
        InputError: if a mesh is missing or cannot be read.
    """
    for shape in [*robot.findall("link/visual"), *robot.findall("link/collision")]:
        for mesh in shape.findall("geometry/mesh"):
            if shape.tag == "collision" and not _is_made_for_drake(shape, mesh):
                ET.SubElement(mesh, DRAKE + "declare_convex")
            if not is_known_package(mesh.get("filename", "")):
                _find(path, shape, mesh)


def _is_made_for_drake(shape: ET.Element, mesh: ET.Element) -> bool:
    return len(mesh) > 0 or shape.find(DRAKE + "proximity_properties") is not None


def _find(path: Path, shape: ET.Element, mesh: ET.Element) -> None:
    file = mesh_file(mesh.get("filename", ""), path)
    is_foreign = file.suffix.lower() not in _DRAKE_READS
    try:
        check_mesh_file(file)
        file = converted(file) if is_foreign else file
    except InputError as error:
        raise error.inside(path) from None
    if is_foreign and file.with_suffix(".mtl").exists():
        for material in shape.findall("material"):  # Drake sets it aside before the colours of the file
            shape.remove(material)
    mesh.set("filename", f"file://{file}")


def set_colors(robot: ET.Element) -> None:
    """Gives shapes their colours without names, which Drake wants defined exactly once and files do not."""
    colors: dict[str | None, ET.Element] = {}
    for material in robot.iter("material"):
        if (color := material.find("color")) is not None:
            colors.setdefault(material.get("name"), color)
    for material in robot.findall("material"):
        robot.remove(material)
    for visual in robot.findall("link/visual"):
        for material in visual.findall("material"):
            visual.remove(material)
            own = material.find("color")
            if (color := colors.get(material.get("name")) if own is None else own) is not None:
                ET.SubElement(visual, "material").append(color)
