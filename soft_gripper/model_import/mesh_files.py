"""Mesh files: checked, read, and kept as OBJ files that Drake reads, in the user's cache folder; their convex parts.

Point contact takes a mesh for its convex hull. Slices across the axis along which the hulls of all slices together
exceed the mesh least follow its shape. Slices that are convex together are one part: a point that has sunk in by the
side of a seam would meet the face between two parts, as if it were a ledge.
"""

import hashlib
import math
import os
import re
from functools import lru_cache
from io import BytesIO
from itertools import pairwise
from pathlib import Path

import numpy as np
import trimesh
from trimesh.resolvers import FilePathResolver
from trimesh.visual import ColorVisuals, TextureVisuals
from trimesh.visual.material import SimpleMaterial

from soft_gripper.arrays import Array
from soft_gripper.errors import InputError, first_line
from soft_gripper.files.notes import MENDED, READ, Note, make_note
from soft_gripper.files.output import atomic_file, writable_folder
from soft_gripper.files.text import read_bytes, read_text
from soft_gripper.model_import.mesh_checks import check_mesh_file, named_file
from soft_gripper.model_import.model_file import ModelFile
from soft_gripper.model_import.solid_mesh import closed_parts
from soft_gripper.registry import registered

_MATERIALS_PATTERN = re.compile(r"<bind_material>.*?</bind_material>", re.DOTALL)
_COORDINATE_DIGITS = 12  # of coordinates in metres
_MAX_CHECKED_FACES = 50_000  # faces of a mesh of which it is checked which way they are turned: seconds
_OBJ_VERSION = f"2, trimesh {trimesh.__version__}"  # to be increased when the same mesh leads to another OBJ file

_HEADER_BYTES = 16  # bytes of an .msh file: the numbers of vertices, normals, points of textures and faces
_SLAB_COUNT = 14
_MIN_FLATNESS_RATIO = 1e-6  # thickness over extent of points, below which they lie in a plane
_JOINED_FILL = 0.999  # slabs that fill this share of their common hull are one part
_NOTABLE_EXCESS = 1.05  # volume of a hull over that of its mesh
CONVEX = 0.99  # a mesh that fills this share of its convex hull counts as convex


class NamedFiles(FilePathResolver):
    def get(self, name: str) -> bytes:
        """The content of a file; raises an InputError for a pipe or a file that is too large."""
        named_file(Path(self.file_path), name)
        return super().get(name)


def read_scene(path: Path) -> trimesh.Scene:
    """The meshes in a file, in its units and axes; raises an InputError if it cannot be read, or has no faces."""
    check_mesh_file(path)
    if reader := {".msh": read_msh, **registered("MESHES")}.get(path.suffix.lower()):
        return trimesh.Scene([reader(path)])
    try:
        scene = trimesh.load_scene(path, resolver=NamedFiles(path))
        if path.suffix.lower() == ".dae" and not _has_faces(scene):  # a material that is missing hides all faces
            bare_text = _MATERIALS_PATTERN.sub("", read_text(path))
            scene = trimesh.load_scene(BytesIO(bare_text.encode()), file_type="dae")
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


def convert_to_obj(path: Path) -> Path:
    """An OBJ file, in metres, with the normals of the mesh and an MTL file beside it if the mesh has colours.

    As in ROS, the unit of a COLLADA file counts and its up axis does not; a glTF file's +y becomes +z, as in Drake.

    Raises:
        InputError: if the mesh is missing or cannot be read, or the cache cannot be written to.
    """
    check_mesh_file(path)
    name = _digest(read_bytes(path) + path.suffix.lower().encode() + _OBJ_VERSION.encode())
    cached_file = cache_folder() / f"{name}.obj"
    if not cached_file.is_file():
        scene = read_scene(path)
        if path.suffix.lower() == ".glb":
            scene.apply_transform(trimesh.transformations.rotation_matrix(np.pi / 2, [1, 0, 0]))
        parts = [_shade(part) for part in scene.dump() if len(getattr(part, "faces", ()))]
        text, materials = trimesh.exchange.obj.export_obj(
            trimesh.Scene(parts), include_normals=True, return_texture=True, mtl_name=f"{name}.mtl", header=None
        )
        for mtl, content in materials.items():
            keep(mtl, content.decode())
        keep(cached_file.name, text)  # written last: it shows that all files are there
    return cached_file


def outward(model: ModelFile, path: Path, origin: Path, from_volume: bool = False) -> Path:
    """An OBJ file or, if parts of it are inside out, a copy with outward faces and a note on its `origin`.

    Parts that are not closed have no outside, and stay as they are. The notes go to the `model` that has the mesh; if
    its mass comes `from_volume`, an open mesh is noted.

    Raises:
        InputError: if the mesh is missing or cannot be read, or the cache cannot be written to.
    """
    check_mesh_file(path)
    turned_file, notes, is_open = _turn_outward(path, origin, path.stat().st_mtime_ns)
    model.notes += notes
    if is_open and from_volume:
        why = "it is open: its volume, and a mass from its density, are uncertain"
        model.notes.append(make_note(READ, origin, "the mesh", "", why))
    return turned_file


@lru_cache(maxsize=256)
def _turn_outward(path: Path, origin: Path, modified: int) -> tuple[Path, list[Note], bool]:
    """The file of `outward`, the notes on it, and whether it is open; `modified`, ns: a changed file is read again."""
    mesh, file = read_scene(path).to_mesh(), ModelFile(origin)
    if len(mesh.faces) > _MAX_CHECKED_FACES:
        why = f"it has more than {_MAX_CHECKED_FACES} faces, and is not searched for parts that are inside out"
        file.note(READ, "the mesh", "", why)
        return path, file.notes, False
    try:
        parts = closed_parts(file, mesh)
    except InputError:
        return path, [], True
    mended = [note for note in file.notes if note.outcome == MENDED]
    if not mended:
        return path, [], False
    smooth_mesh = trimesh.util.concatenate(parts).smooth_shaded
    return keep_by_content(obj_text(smooth_mesh, normals=True)), mended, False


def keep(name: str, text: str) -> Path:
    path = writable_folder(cache_folder()) / name
    if not path.exists():
        with atomic_file(path) as partial:
            partial.write_text(text, encoding="utf-8")
    return path


def keep_by_content(text: str, suffix: str = ".obj") -> Path:
    return keep(f"{_digest(text.encode())}{suffix}", text)


def cache_folder() -> Path:
    """The user's cache folder, according to the XDG specification."""
    configured = Path(os.environ.get("XDG_CACHE_HOME", ""))
    return (configured if configured.is_absolute() else Path.home() / ".cache") / "soft-gripper" / "meshes"


def _digest(content: bytes) -> str:
    return hashlib.sha256(content).hexdigest()[:16]


def _shade(part: trimesh.Trimesh) -> trimesh.Trimesh:
    """A part in metres, smooth except at sharp edges, in one colour or none."""
    if part.units:
        part.apply_scale(trimesh.units.unit_conversion(part.units, "meters"))
    color = None  # red, green, blue and opacity; textures are not kept
    if part.visual.defined:
        color = part.visual.material.main_color if part.visual.kind == "texture" else part.visual.main_color
    part.visual = ColorVisuals()  # smoothing would copy its texture for every smooth piece
    part.merge_vertices(merge_tex=True, merge_norm=True)
    if part.is_watertight and part.volume < 0:
        part.invert()
    smooth_part = part.smooth_shaded
    if color is not None:
        smooth_part.visual = TextureVisuals(material=SimpleMaterial(diffuse=color))
    return smooth_part


def obj_text(mesh: trimesh.Trimesh, normals: bool = False) -> str:
    return trimesh.exchange.obj.export_obj(
        mesh, include_texture=False, include_normals=normals, header=None, digits=_COORDINATE_DIGITS
    )


def read_msh(path: Path) -> trimesh.Trimesh:
    """Reads a mesh in MuJoCo's own binary format, .msh; raises an InputError if its numbers do not fit."""
    content = read_bytes(path)
    counts = np.frombuffer(content[:_HEADER_BYTES].ljust(_HEADER_BYTES, b"\0"), "<i4").astype(int)
    vertices, normals, points, faces = counts
    begin = _HEADER_BYTES + 12 * vertices + 12 * normals + 8 * points
    if counts.min() < 0 or len(content) != begin + 12 * faces:
        expected = "is damaged, or not a mesh of MuJoCo: its size is not as its head says"
        raise InputError(path, "mesh", path.name, expected)
    places = np.frombuffer(content, "<f4", 3 * vertices, _HEADER_BYTES).reshape(-1, 3)
    corners = np.frombuffer(content, "<i4", 3 * faces, begin).reshape(-1, 3)
    if not np.isfinite(places).all() or ((corners < 0) | (corners >= vertices)).any():
        raise InputError(path, "mesh", path.name, "is damaged: a face has no place")
    return trimesh.Trimesh(places.astype(float), corners, process=False)


@lru_cache(maxsize=16)
def convex_parts(path: Path, modified: int) -> tuple[Array, ...]:
    """Corners of the convex parts of a mesh, (M, 3) each in its units; `modified`, ns: a changed file is read again."""
    mesh = _read_mesh(path)
    if hull_excess(path, modified) * CONVEX <= 1:
        return (np.array(mesh.convex_hull.vertices),)
    candidates = []  # hulls of slices of equal height along each axis
    for axis in range(3):
        low, high = mesh.bounds[:, axis]
        heights = pairwise(np.linspace(low, high, _SLAB_COUNT + 1))
        slices = [_slice_points(mesh, axis, *ends) for ends in heights]
        candidates.append([trimesh.convex.convex_hull(points) for points in slices if _is_solid(points)])
    slabs = min(candidates, key=lambda slabs: sum(slab.volume for slab in slabs))
    parts, filled_volume = [slabs[0]], slabs[0].volume
    for slab in slabs[1:]:  # joined as long as they fill their common hull
        hull = trimesh.convex.convex_hull(np.concatenate([parts[-1].vertices, slab.vertices]))
        is_convex = filled_volume + slab.volume >= _JOINED_FILL * hull.volume
        parts = [*parts[:-1], hull] if is_convex else [*parts, slab]
        filled_volume = filled_volume + slab.volume if is_convex else slab.volume
    return tuple(np.array(part.vertices) for part in parts)


@lru_cache(maxsize=256)
def hull_excess(path: Path, modified: int) -> float:
    """The volume of the convex hull of a mesh over its own; infinite if it is open; arguments as in `convex_parts`."""
    try:
        mesh = _read_mesh(path)
    except InputError:  # a format that Drake alone reads
        return math.inf
    has_volume = mesh.is_watertight and mesh.is_winding_consistent and mesh.volume != 0
    return float(mesh.convex_hull.volume / abs(mesh.volume)) if has_volume else math.inf


def note_hull(model: ModelFile, link: str, mesh: Path, origin: Path) -> None:
    """Notes the volume of a touched mesh's convex hull over the mesh, if it is notable; `origin` names the mesh."""
    excess = hull_excess(mesh, mesh.stat().st_mtime_ns)
    if _NOTABLE_EXCESS <= excess < math.inf:
        why = f"a link of an arm is touched at its convex hull, whose volume is {excess:.3g} times that of the mesh"
        model.note(READ, f"link '{link}': mesh", origin.name, why)


def _read_mesh(path: Path) -> trimesh.Trimesh:
    mesh = read_scene(path).to_mesh()
    mesh.merge_vertices(merge_tex=True, merge_norm=True)
    return mesh


def _is_solid(points: Array) -> bool:
    """Whether the hull of points has a volume: a slice may only touch a flat face of the mesh."""
    return len(points) > 3 and np.linalg.matrix_rank(points - points.mean(axis=0), rtol=_MIN_FLATNESS_RATIO) == 3


def _slice_points(mesh: trimesh.Trimesh, axis: int, begin: float, end: float) -> Array:
    """The vertices of a mesh between two planes across an axis, and where its edges cross these, (M, 3)."""
    vertices, edges = np.array(mesh.vertices), np.array(mesh.edges_unique)
    points = [vertices[(vertices[:, axis] >= begin) & (vertices[:, axis] <= end)]]
    for plane in (begin, end):
        begins, ends = (vertices[edges[:, i]] for i in range(2))
        crosses = (begins[:, axis] - plane) * (ends[:, axis] - plane) < 0
        begins, ends = begins[crosses], ends[crosses]
        share = (plane - begins[:, axis]) / (ends[:, axis] - begins[:, axis])
        points.append(begins + share[:, None] * (ends - begins))
    return np.concatenate(points)
