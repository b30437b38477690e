"""Meshes of tetrahedra, for soft objects: read from VTK files, checked and written."""

from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from soft_gripper.arrays import Array
from soft_gripper.errors import InputError
from soft_gripper.files.document import require
from soft_gripper.files.text import read_text

SUFFIX = ".vtk"
MAX_CELLS = 20_000  # tetrahedra; with more, a run would be hundreds of times slower than real time
_TETRAHEDRON_TYPE = "10"  # the type of a cell in VTK
_CELL_FACES = [(1, 2, 3), (0, 3, 2), (0, 1, 3), (0, 2, 1)]  # of a tetrahedron, counterclockwise seen from outside
_FILE_FORMAT = "a legacy VTK file in ASCII with an unstructured grid of tetrahedra"


class Tetrahedra(NamedTuple):
    """A mesh of V vertices and M tetrahedra of positive volume."""

    vertices: Array  # (V, 3)
    cells: NDArray[np.int_]  # (M, 4) numbers of vertices

    @property
    def volumes(self) -> Array:
        """Volumes of the tetrahedra, (M)."""
        corners = self.vertices[self.cells]
        return np.linalg.det(corners[:, 1:] - corners[:, :1]) / 6

    @property
    def boundary(self) -> NDArray[np.int_]:
        """The triangles of the surface, (F, 3) numbers of vertices, counterclockwise seen from outside."""
        faces = np.concatenate([self.cells[:, face] for face in _CELL_FACES])
        _, first_rows, face_counts = np.unique(np.sort(faces, axis=1), axis=0, return_index=True, return_counts=True)
        return faces[np.sort(first_rows[face_counts == 1])]

    def scaled(self, factor: float) -> "Tetrahedra":
        """Copies the mesh with all lengths multiplied by a factor."""
        return Tetrahedra(self.vertices * factor, self.cells)

    def as_vtk(self) -> str:
        """The text of a VTK file."""
        points = [" ".join(f"{x:.12f}" for x in vertex) for vertex in self.vertices]
        cells = [f"4 {' '.join(map(str, cell))}" for cell in self.cells]
        head = ("# vtk DataFile Version 3.0", "soft body", "ASCII", "DATASET UNSTRUCTURED_GRID")
        sizes = len(points), len(cells), 5 * len(cells)
        lines = [*head, f"POINTS {sizes[0]} double", *points, f"CELLS {sizes[1]} {sizes[2]}", *cells]
        return "\n".join([*lines, f"CELL_TYPES {sizes[1]}", *[_TETRAHEDRON_TYPE] * sizes[1], ""])


def read_tetrahedra(path: Path) -> Tetrahedra:
    """Reads a legacy VTK file in ASCII, as most meshers write it.

    Raises:
        InputError: if it is not such a file, has other cells than tetrahedra, or one of them has no volume.
    """
    words = read_text(path).split()
    try:
        mesh = _parse(words)
    except (ValueError, IndexError):
        raise InputError(path, "mesh", path.name, f"cannot be read: give {_FILE_FORMAT}") from None
    require(0 < len(mesh.cells) <= MAX_CELLS, path, "cells", len(mesh.cells), f"give 1 to {MAX_CELLS} tetrahedra")
    wrong_numbers = mesh.cells[(mesh.cells < 0) | (mesh.cells >= len(mesh.vertices))]
    expected = f"there are {len(mesh.vertices)} points, numbered from 0"
    require(not len(wrong_numbers), path, "cells", int(wrong_numbers[0]) if len(wrong_numbers) else None, expected)
    require(bool(np.isfinite(mesh.vertices).all()), path, "points", "nan", "must be finite numbers")
    volumes = np.abs(mesh.volumes)
    require(
        volumes.min() > 1e-9 * volumes.max(), path, "cells", int(volumes.argmin()), "is a tetrahedron without volume"
    )
    return orient_cells(mesh)


def orient_cells(mesh: Tetrahedra) -> Tetrahedra:
    """The mesh with all volumes positive."""
    cells = np.where((mesh.volumes < 0)[:, None], mesh.cells[:, [0, 2, 1, 3]], mesh.cells)
    return Tetrahedra(mesh.vertices, cells)


def _parse(words: list[str]) -> Tetrahedra:
    begins = {word: i for i, word in enumerate(words) if word in ("POINTS", "CELLS", "CELL_TYPES", "UNSTRUCTURED_GRID")}
    if len(begins) != 4 or "ASCII" not in words:
        raise ValueError
    points, cells, types = begins["POINTS"], begins["CELLS"], begins["CELL_TYPES"]
    vertices, cell_count = int(words[points + 1]), int(words[cells + 1])
    rows = np.array(words[cells + 3 : cells + 3 + 5 * cell_count], dtype=int).reshape(cell_count, 5)
    if (rows[:, 0] != 4).any() or words[types + 2 : types + 2 + cell_count] != cell_count * [_TETRAHEDRON_TYPE]:
        raise ValueError
    numbers = np.array(words[points + 3 : points + 3 + 3 * vertices], dtype=float)
    return Tetrahedra(numbers.reshape(vertices, 3), rows[:, 1:])
