"""The solid that a mesh file describes: its parts joined at their seams, and turned outward."""

import numpy as np
import trimesh
from numpy.typing import NDArray
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import breadth_first_order

from soft_gripper.arrays import Array
from soft_gripper.files.notes import MENDED, READ
from soft_gripper.model_import.model_file import ModelFile

_INSIDE_WINDING = 0.5  # winding number above which a point is inside
_MAX_RAY_TESTS = 5_000_000  # triangles that the search for overlaps compares with rays at most
_RAY_TESTS_PER_CHUNK = 500_000  # of these
_MAX_SEARCH_POINTS = 512  # at which two parts are searched for an overlap, at most
_MAX_PAIRS = 500  # of parts that are searched
_MAX_PARTS = 1000  # of a mesh
_FLAT_VOLUME = 1e-9  # volume of a part over that of a cube around it, below which it has none


def solid(file: ModelFile, mesh: trimesh.Trimesh) -> trimesh.Trimesh:
    """A mesh of the parts of `closed_parts`, raises as that; overlaps are noted, since density counts twice there."""
    parts = closed_parts(file, mesh)
    _note_overlap(file, [part for part in parts if part.volume > 0])
    return trimesh.util.concatenate(parts)


def closed_parts(file: ModelFile, mesh: trimesh.Trimesh) -> list[trimesh.Trimesh]:
    """The closed parts of a mesh, which face outward or, if they lie in another part, enclose a cavity.

    Vertices that are split at seams of texture or at sharp edges are joined. Faces and parts that are turned the other
    way are turned back, with a note. Raises an InputError if a part is not closed, or there are more than 1000.
    """
    mesh = trimesh.Trimesh(mesh.vertices, mesh.faces, process=False)
    component = _part_of_faces(mesh)
    edges = mesh.edges_unique_inverse * len(component) + np.repeat(component, 3)  # one number for an edge of a part
    _, edge, counts = np.unique(edges, return_inverse=True, return_counts=True)
    are_closed = np.ones(len(component), bool)  # parts with two faces at every edge
    are_closed[component[np.flatnonzero(counts[edge] != 2) // 3]] = False
    is_closed = are_closed[component]
    parts = _parts(file, _select_faces(mesh, is_closed)) + _parts(file, _join_vertices(_select_faces(mesh, ~is_closed)))
    is_open = sum(not part.is_watertight for part in parts)
    if is_open or not parts:
        leak = f"{is_open} of its {len(parts)} parts are open" if len(parts) > 1 else "it is open"
        expected = f"is not watertight: {leak}; close the holes, since an open surface has no volume and no inertia"
        file.refuse("mesh", file.path.name, expected)
    for number, part in enumerate(parts):
        if part.is_winding_consistent and abs(part.volume) <= _FLAT_VOLUME * part.extents.max() ** 3:
            file.refuse("mesh", file.path.name, f"part {number} has no volume: both of its sides face outward")
    if sum(part.volume for part in parts if part.is_winding_consistent) < 0:
        for part in parts:
            part.invert()
        file.note(MENDED, "the mesh", "", "it was inside out")
    _turn(file, parts)
    return parts


def _part_of_faces(mesh: trimesh.Trimesh) -> NDArray[np.int_]:
    """The number of the part to which each face belongs, (F,): edges of two faces hold a part together."""
    return trimesh.graph.connected_component_labels(mesh.face_adjacency, node_count=len(mesh.faces))


def _select_faces(mesh: trimesh.Trimesh, mask: NDArray[np.bool_]) -> trimesh.Trimesh:
    """The mesh of some faces, (F,) of all."""
    chosen_mesh = mesh.copy()
    chosen_mesh.update_faces(mask)
    chosen_mesh.remove_unreferenced_vertices()
    return chosen_mesh


def _parts(file: ModelFile, mesh: trimesh.Trimesh) -> list[trimesh.Trimesh]:
    """The parts of a mesh; raises an InputError if they are too many."""
    if not len(mesh.faces):
        return []
    if (count := int(_part_of_faces(mesh).max()) + 1) > _MAX_PARTS:
        file.refuse("parts", count, f"give a mesh of at most {_MAX_PARTS} parts that do not hang together")
    return list(mesh.split(only_watertight=False, repair=False))


def _join_vertices(mesh: trimesh.Trimesh) -> trimesh.Trimesh:
    """Joins parts of a mesh where their vertices coincide, without double faces and walls between them."""
    if not len(mesh.faces):
        return mesh
    mesh.merge_vertices(merge_tex=True, merge_norm=True)
    mesh.update_faces(mesh.nondegenerate_faces())
    order = np.argsort(mesh.faces, axis=1)
    sides = np.where((order[:, 1] - order[:, 0]) % 3 == 1, 1, -1)  # of a face, that its order of vertices shows
    _, group = np.unique(np.sort(mesh.faces, axis=1), axis=0, return_inverse=True)
    balance = np.bincount(group.ravel(), weights=sides)  # of faces on the same vertices; 0: a wall between pieces
    kept_faces = np.flatnonzero(sides == np.sign(balance[group.ravel()]))
    _, first = np.unique(group.ravel()[kept_faces], return_index=True)
    mesh.update_faces(np.sort(kept_faces[first]))
    mesh.remove_unreferenced_vertices()
    return mesh


def _turn(file: ModelFile, parts: list[trimesh.Trimesh]) -> None:
    for number, part in enumerate(parts):
        if not part.is_winding_consistent:
            part.faces = _consistent(part)
            if not part.is_winding_consistent:
                file.refuse("mesh", file.path.name, f"part {number} has no outside: its surface has one side")
            part.faces = part.faces if part.volume > 0 else part.faces[:, ::-1]
            file.note(MENDED, f"part {number}", "", "some of its faces were turned the other way")
    outward = [part.triangles if part.volume > 0 else part.triangles[:, ::-1] for part in parts]
    for number, part in enumerate(parts):
        other_parts = [triangles for i, triangles in enumerate(outward) if i != number]
        if part.volume < 0 and other_parts and _is_inside(part, np.concatenate(other_parts)):
            file.note(READ, f"part {number}", "", "it is inside out and in another part: a cavity")
        elif part.volume < 0:
            part.invert()
            file.note(MENDED, f"part {number}", "", "it was inside out")


def _consistent(part: trimesh.Trimesh) -> NDArray[np.int_]:
    """The faces of a connected part, (F, 3), turned as the first one is."""
    pairs, edges, faces = part.face_adjacency, part.face_adjacency_edges, np.array(part.faces)

    def runs_along(face: NDArray[np.int_]) -> NDArray[np.bool_]:
        """Mask of the edges that run along a face rather than against it."""
        starts = faces[face] == edges[:, :1]
        return (np.roll(faces[face], -1, axis=1) == edges[:, 1:])[starts]

    # Neighbours that are turned alike run along their edge in opposite ways.
    differs = runs_along(pairs[:, 0]) == runs_along(pairs[:, 1])
    rows, columns = np.concatenate([pairs, pairs[:, ::-1]]).T
    shape, differences = (len(faces), len(faces)), np.concatenate([differs, differs])
    graph = coo_matrix((1 + differences.astype(int), (rows, columns)), shape=shape).tocsr()
    is_turned = np.zeros(len(faces), bool)
    order, predecessors = breadth_first_order(graph, 0, directed=False)
    for face in order[1:]:
        is_turned[face] = is_turned[predecessors[face]] ^ (graph[predecessors[face], face] == 2)
    faces[is_turned] = faces[is_turned, ::-1]
    return faces


def _is_inside(part: trimesh.Trimesh, triangles: Array) -> bool:
    """Whether most of the surface of a part is inside other triangles, (F, 3, 3)."""
    points = part.triangles_center[:: max(1, len(part.faces) // 50)]
    return bool((winding(points, triangles) > _INSIDE_WINDING).mean() > 0.5)


def _note_overlap(file: ModelFile, parts: list[trimesh.Trimesh]) -> None:
    low, high = np.array([part.bounds for part in parts]).reshape(-1, 2, 3).swapaxes(0, 1)
    first, second = np.triu_indices(len(parts), 1)
    is_near = (np.minimum(high[first], high[second]) > np.maximum(low[first], low[second])).all(axis=1)
    pairs = [*zip(first[is_near].tolist(), second[is_near].tolist(), strict=True)]
    if len(pairs) > _MAX_PAIRS:
        file.note(READ, "overlaps of parts", f"{len(pairs)} pairs", f"only {_MAX_PAIRS} pairs are searched for them")
    for first, second in pairs[:_MAX_PAIRS]:
        pair = parts[first], parts[second]
        point_count = _MAX_RAY_TESTS // (len(pairs) * sum(len(part.faces) for part in pair))
        count = round(int(np.clip(point_count, 27, _MAX_SEARCH_POINTS)) ** (1 / 3))  # of points along each axis
        steps = (np.arange(count) + 0.5) / count
        grid = np.stack(np.meshgrid(steps, steps, steps), axis=-1).reshape(-1, 3)
        begin, end = np.maximum(low[first], low[second]), np.minimum(high[first], high[second])
        points = begin + grid * (end - begin)
        if np.all([winding(points, part.triangles) > _INSIDE_WINDING for part in pair], axis=0).any():
            file.note(READ, f"parts {first} and {second}", "", "they overlap: density counts twice there")


def winding(points: Array, triangles: Array) -> Array:
    """Winding numbers of closed surfaces of triangles (F, 3, 3) around points (M, 3), (M,).

    That is how often a ray from the point leaves them more than it enters; no ray is along an edge of a box.
    """
    turn = np.array([[0.36, 0.48, -0.8], [-0.8, 0.6, 0.0], [0.48, 0.64, 0.6]])
    points, corners = points @ turn.T, np.moveaxis(triangles @ turn.T, 1, 0)
    chunk, numbers = max(1, _RAY_TESTS_PER_CHUNK // len(triangles)), []
    for begin in range(0, len(points), chunk):
        a, b, c = corners[:, None] - points[None, begin : begin + chunk, None]  # (m, F, 3) each
        cross_products = [u[..., 1] * v[..., 2] - u[..., 2] * v[..., 1] for u, v in ((b, c), (c, a), (a, b))]
        signs = np.sign(cross_products)
        orientation = np.where((signs == signs[0]).all(axis=0), signs[0], 0.0)
        is_ahead = (np.array(cross_products) * (a[..., 0], b[..., 0], c[..., 0])).sum(axis=0) * orientation > 0
        numbers.append((orientation * is_ahead).sum(axis=-1))
    return np.concatenate(numbers)
