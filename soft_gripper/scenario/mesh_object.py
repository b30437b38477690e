"""A user's mesh file as an object: checked, with an inertia, and described as SDFormat."""

import hashlib
import os
import re
import xml.etree.ElementTree as ET
from collections.abc import Mapping
from functools import lru_cache
from io import BytesIO
from pathlib import Path

import numpy as np
import trimesh
from numpy.typing import NDArray
from trimesh.visual import ColorVisuals, TextureVisuals
from trimesh.visual.material import SimpleMaterial

from soft_gripper.errors import InputError, first_line
from soft_gripper.files.notes import MENDED, READ, Note, kept, note
from soft_gripper.files.output import atomic_file, writable_folder
from soft_gripper.files.text import read_bytes, read_text
from soft_gripper.files.xml_text import DRAKE
from soft_gripper.scenario.deformables import deformable_kind
from soft_gripper.scenario.mesh_checks import NamedFiles, check_mesh_file
from soft_gripper.scenario.msh_file import read_msh
from soft_gripper.scenario.schema import MeshConfig
from soft_gripper.scenario.solid_mesh import closed_parts, solid, together

_MATERIALS = re.compile(r"<bind_material>.*?</bind_material>", re.DOTALL)
_MOST_CHECKED = 50_000  # faces of a mesh of which it is checked which way they are turned: seconds
_CONVERSION = f"2, trimesh {trimesh.__version__}"  # to be increased when the same mesh leads to another OBJ file


def read_scene(path: Path) -> trimesh.Scene:
    """The meshes in a file, in its units and axes.

    Raises:
        InputError: if the file is missing, too large, cannot be read, or has no faces.
    """
    check_mesh_file(path)
    kind = deformable_kind()
    if kind is not None and path.suffix.lower() == kind.suffix:
        return trimesh.Scene([kind.surface(path)])
    if path.suffix.lower() == ".msh":
        return trimesh.Scene([read_msh(path)])
    try:
        scene = trimesh.load_scene(path, resolver=NamedFiles(path))
        if path.suffix.lower() == ".dae" and not _has_faces(scene):  # a material that is missing hides all faces
            bare = _MATERIALS.sub("", read_text(path))
            scene = trimesh.load_scene(BytesIO(bare.encode()), file_type="dae")
    except InputError:
        raise
    except Exception as error:  # trimesh's readers raise errors of many types
        missing = isinstance(error, ImportError)  # which guesses how the text of what is not a mesh is encoded
        reason = "it is damaged" if missing else first_line(error)
        raise InputError(path, "mesh", path.name, f"cannot be read as a mesh: {reason}") from None
    if not _has_faces(scene):
        raise InputError(path, "mesh", path.name, "is empty; give a mesh with faces")
    return scene


def _has_faces(scene: trimesh.Scene) -> bool:
    return any(len(getattr(part, "faces", ())) for part in scene.geometry.values())


def converted(path: Path) -> Path:
    """An OBJ file, in metres, with the normals of the mesh and an MTL file beside it if the mesh has colours.

    As in ROS, the unit of a COLLADA file counts and its up axis does not; a glTF file's +y becomes +z, as in Drake.

    Raises:
        InputError: if the mesh is missing or cannot be read, or the cache cannot be written to.
    """
    check_mesh_file(path)
    name = _digest(read_bytes(path) + path.suffix.lower().encode() + _CONVERSION.encode())
    kept = cache_folder() / f"{name}.obj"
    if not kept.is_file():
        text, materials = _to_obj(path, f"{name}.mtl")
        for mtl, content in materials.items():
            keep(mtl, content.decode())
        keep(kept.name, text)  # written last: it shows that all files are there
    return kept


def outward(path: Path, origin: Path) -> Path:
    """An OBJ file or, if parts of it are inside out, one in which they face outward, with a note on its `origin`.

    Parts that are not closed have no outside, and stay as they are.

    Raises:
        InputError: if the mesh is missing or cannot be read, or the cache cannot be written to.
    """
    return _outward(path, origin)[0]


def weighable(path: Path, origin: Path) -> Path:
    """A file as of `outward`, whose volume counts: an open mesh is noted."""
    turned, is_open = _outward(path, origin)
    if is_open:
        note(READ, origin, "the mesh", "", "it is open: its volume, and a mass from its density, are uncertain")
    return turned


def _outward(path: Path, origin: Path) -> tuple[Path, bool]:
    check_mesh_file(path)
    turned, notes, is_open = _turned(path, origin, path.stat().st_mtime_ns)
    for each in notes:
        note(*each)
    return turned, is_open


@lru_cache(maxsize=256)
def _turned(path: Path, origin: Path, modified: int) -> tuple[Path, list[Note], bool]:
    """The file of `outward`, the notes on it, and whether it is open; `modified`, ns: a changed file is read again."""
    mesh = read_scene(path).to_mesh()
    if len(mesh.faces) > _MOST_CHECKED:
        why = f"it has more than {_MOST_CHECKED} faces, and is not searched for parts that are inside out"
        return path, [Note(READ, str(origin), "the mesh", "", why)], False
    try:
        with kept() as notes:
            parts = closed_parts(origin, mesh)
    except InputError:
        return path, [], True
    turned = [each for each in notes if each.outcome == MENDED]
    return (keep_by_content(obj_text(together(parts).smooth_shaded, normals=True)) if turned else path), turned, False


def keep(name: str, text: str) -> Path:
    """Writes a file of the cache, unless it exists."""
    path = writable_folder(cache_folder()) / name
    if not path.exists():
        with atomic_file(path) as partial:
            partial.write_text(text, encoding="utf-8")
    return path


def keep_by_content(text: str, suffix: str = ".obj") -> Path:
    """Keeps a mesh file under a name made from its contents."""
    return keep(f"{_digest(text.encode())}{suffix}", text)


def cache_folder() -> Path:
    """The user's cache folder, according to the XDG specification."""
    given = Path(os.environ.get("XDG_CACHE_HOME", ""))
    return (given if given.is_absolute() else Path.home() / ".cache") / "soft-gripper" / "meshes"


def _digest(content: bytes) -> str:
    return hashlib.sha256(content).hexdigest()[:16]


def _to_obj(path: Path, mtl_name: str) -> tuple[str, dict[str, bytes]]:
    scene = read_scene(path)
    if path.suffix.lower() == ".glb":
        scene.apply_transform(trimesh.transformations.rotation_matrix(np.pi / 2, [1, 0, 0]))
    parts = [_shaded(part) for part in scene.dump() if len(getattr(part, "faces", ()))]
    text, materials = trimesh.exchange.obj.export_obj(
        trimesh.Scene(parts), include_normals=True, return_texture=True, mtl_name=mtl_name, header=None
    )
    return text, materials


def _shaded(part: trimesh.Trimesh) -> trimesh.Trimesh:
    """A part in metres, smooth but for its sharp edges, in one colour or none."""
    if part.units:
        part.apply_scale(trimesh.units.unit_conversion(part.units, "meters"))
    color = _color(part)
    part.visual = ColorVisuals()  # smoothing would copy its texture for every smooth piece
    part.merge_vertices(merge_tex=True, merge_norm=True)
    if part.is_watertight and part.volume < 0:
        part.invert()
    smooth = part.smooth_shaded
    if color is not None:
        smooth.visual = TextureVisuals(material=SimpleMaterial(diffuse=color))
    return smooth


def _color(part: trimesh.Trimesh) -> NDArray[np.uint8] | None:
    """Red, green, blue and opacity; textures are not kept."""
    if not part.visual.defined:
        return None
    return part.visual.material.main_color if part.visual.kind == "texture" else part.visual.main_color


_SUFFIXES = (".obj", ".stl", ".ply", ".off", ".glb", ".gltf")
_DIGITS = 12  # of coordinates in metres
MASS, FRICTION = 0.05, 0.8  # kg, Coulomb: of a mesh for which none is given
MAX_SIZE = 1.0  # m; a gripper of this size grasps nothing larger


def mesh_suffixes() -> tuple[str, ...]:
    """Suffixes of the files of objects that are bare meshes."""
    kind = deformable_kind()
    return _SUFFIXES if kind is None else (*_SUFFIXES, kind.suffix)


def mesh_to_sdf(
    path: Path, config: MeshConfig, name: str, mass: float | None = None, friction: float | None = None
) -> str:
    """SDFormat text of an object of uniform density: rigid, or of finite elements if the config means that.

    A rigid object touches compliant fingers with its true surface, not with its hull. Meshes are kept as scaled files
    in the user's cache folder, whatever their format was.

    Raises:
        InputError: if the mesh is missing, empty, not watertight, or of an implausible size, or has no finite
            elements where they are meant.
    """
    mesh = solid(path, read_scene(path).to_mesh())
    mesh.apply_scale(config.scale)
    _check(path, mesh, config)
    root = ET.Element("sdf", version="1.7")
    link = ET.SubElement(ET.SubElement(root, "model", name=name), "link", name=name)
    kind, mesh.density = deformable_kind(), (MASS if mass is None else mass) / mesh.volume
    rubbing = FRICTION if friction is None else friction
    if kind is not None and kind.is_meant(config):
        kind.add_to_link(link, path, config, mesh.density, rubbing)
    else:
        _add_rigid(link, mesh, config, rubbing)
    return ET.tostring(root, encoding="unicode")


def _add_rigid(link: ET.Element, mesh: trimesh.Trimesh, config: MeshConfig, friction: float) -> None:
    _add_inertia(link, mesh)
    uri = f"file://{keep_by_content(obj_text(mesh))}"
    add_visual(link, uri, config)
    contact = ET.SubElement(add_geometry(link, "collision", uri), DRAKE + "proximity_properties")
    ET.SubElement(contact, DRAKE + "rigid_hydroelastic")
    add_values(contact, {"mu_static": friction, "mu_dynamic": friction, "hunt_crossley_dissipation": 2.0})


def add_visual(link: ET.Element, uri: str, config: MeshConfig) -> None:
    visual = add_geometry(link, "visual", uri)
    ET.SubElement(ET.SubElement(visual, "material"), "diffuse").text = _text(config.color)


def add_values(element: ET.Element, values: Mapping[str, object]) -> None:
    for key, value in values.items():
        ET.SubElement(element, DRAKE + key).text = str(value)


def _check(path: Path, mesh: trimesh.Trimesh, config: MeshConfig) -> None:
    size = float(max(mesh.extents))
    if not 1e-3 <= size <= MAX_SIZE:
        hint = "is the file in millimetres? then give mesh.scale: 0.001" if size > MAX_SIZE else "too small to grasp"
        raise InputError(path, "mesh.scale", config.scale, f"makes the object {size:.4g} m large; {hint}")


def _add_inertia(link: ET.Element, mesh: trimesh.Trimesh) -> None:
    inertial = ET.SubElement(link, "inertial")
    ET.SubElement(inertial, "pose").text = _text([*mesh.center_mass, 0, 0, 0])
    ET.SubElement(inertial, "mass").text = repr(float(mesh.mass))
    inertia = ET.SubElement(inertial, "inertia")
    moments = mesh.moment_inertia
    for i, j in zip(*np.triu_indices(3), strict=True):
        ET.SubElement(inertia, "i" + "xyz"[i] + "xyz"[j]).text = repr(float(moments[i, j]))


def add_geometry(link: ET.Element, kind: str, uri: str) -> ET.Element:
    element = ET.SubElement(link, kind, name=kind)
    ET.SubElement(ET.SubElement(ET.SubElement(element, "geometry"), "mesh"), "uri").text = uri
    return element


def obj_text(mesh: trimesh.Trimesh, normals: bool = False) -> str:
    text: str = trimesh.exchange.obj.export_obj(
        mesh, include_texture=False, include_normals=normals, header=None, digits=_DIGITS
    )
    return text


def _text(values: list[float]) -> str:
    return " ".join(str(float(value)) for value in values)
