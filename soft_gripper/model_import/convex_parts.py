"""Convex parts of a mesh: slabs of it, each with its convex hull.

Point contact takes a mesh for its convex hull. Slices across the axis along which the hulls of all slices together
exceed the mesh least follow its shape. Slices that are convex together are one part: a point that has sunk in by the
side of a seam would meet the face between two parts, as if it were a ledge.
"""

import math
from collections.abc import Sequence
from functools import lru_cache
from itertools import pairwise
from pathlib import Path

import numpy as np
import trimesh

from soft_gripper.arrays import Array
from soft_gripper.errors import InputError
from soft_gripper.files.notes import READ
from soft_gripper.model_import.mesh_files import read_scene
from soft_gripper.model_import.model_file import ModelFile

_SLAB_COUNT = 14
_MIN_FLATNESS_RATIO = 1e-6  # thickness over extent of points, below which they lie in a plane
_JOINED_FILL = 0.999  # slabs that fill this share of their common hull are one part
_NOTABLE_EXCESS = 1.05  # volume of a hull over that of its mesh
CONVEX = 0.99  # a mesh that fills this share of its convex hull counts as convex


@lru_cache(maxsize=16)
def convex_parts(path: Path, modified: int) -> tuple[Array, ...]:
    """Corners of the convex parts of a mesh, (M, 3) each, in its own units; a single part if it is convex.

    Args:
        path: of the file.
        modified: time of its last change, ns, so that a changed file is read again.
    """
    mesh = _read_mesh(path)
    if hull_excess(path, modified) * CONVEX <= 1:
        return (np.array(mesh.convex_hull.vertices),)
    candidates = [_slabs(mesh, axis) for axis in range(3)]
    slabs = min(candidates, key=lambda slabs: sum(slab.volume for slab in slabs))
    return tuple(np.array(part.vertices) for part in _join_slabs(slabs))


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
    """Notes the excess of a touched mesh's convex hull over the mesh, if it is notable.

    Args:
        model: to which the link belongs.
        link: its name.
        mesh: file of the mesh as it is read.
        origin: that file as the model names it.
    """
    excess = hull_excess(mesh, mesh.stat().st_mtime_ns)
    if _NOTABLE_EXCESS <= excess < math.inf:
        why = f"a link of an arm is touched at its convex hull, whose volume is {excess:.3g} times that of the mesh"
        model.note(READ, f"link '{link}': mesh", origin.name, why)


def _read_mesh(path: Path) -> trimesh.Trimesh:
    mesh = read_scene(path).to_mesh()
    mesh.merge_vertices(merge_tex=True, merge_norm=True)
    return mesh


def _join_slabs(slabs: Sequence[trimesh.Trimesh]) -> list[trimesh.Trimesh]:
    """Joins slabs that follow each other as long as they fill their common hull."""
    parts, filled_volume = [slabs[0]], slabs[0].volume
    for slab in slabs[1:]:
        hull = trimesh.convex.convex_hull(np.concatenate([parts[-1].vertices, slab.vertices]))
        is_convex = filled_volume + slab.volume >= _JOINED_FILL * hull.volume
        parts = [*parts[:-1], hull] if is_convex else [*parts, slab]
        filled_volume = filled_volume + slab.volume if is_convex else slab.volume
    return parts


def _slabs(mesh: trimesh.Trimesh, axis: int) -> list[trimesh.Trimesh]:
    """Hulls of slices of equal height along an axis."""
    low, high = mesh.bounds[:, axis]
    slices = (_slice_points(mesh, axis, *ends) for ends in pairwise(np.linspace(low, high, _SLAB_COUNT + 1)))
    return [trimesh.convex.convex_hull(points) for points in slices if _is_solid(points)]


def _is_solid(points: Array) -> bool:
    """Whether the hull of points has a volume: a slice may only touch a flat face of the mesh."""
    if len(points) < 4:
        return False
    singular_values = np.linalg.svd(points - points.mean(axis=0), compute_uv=False)
    return bool(singular_values[-1] > _MIN_FLATNESS_RATIO * singular_values[0])


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
