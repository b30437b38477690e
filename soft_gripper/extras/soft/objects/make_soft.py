"""Makes soft_block.vtk and tomato.vtk: meshes of tetrahedra for soft objects."""

from itertools import permutations
from pathlib import Path

import numpy as np
from scipy.spatial import Delaunay
from trimesh.creation import icosphere

from soft_gripper.arrays import Array
from soft_gripper.extras.soft.tetrahedra import Tetrahedra, orient_cells

BLOCK = (0.044, 0.04, 0.06)  # m, as box.sdf
CELLS = (3, 3, 4)
TOMATO = (0.046, 0.046, 0.042)  # m: diameters
FOOT = -0.88  # fraction of its half height below which a tomato is flat
CORE = 0.6  # size of an inner shell of vertices


def block(size: tuple[float, float, float], cells: tuple[int, int, int]) -> Tetrahedra:
    """A block about the origin, each of its cells divided into six tetrahedra along a diagonal."""
    point_counts = np.add(cells, 1)
    numbers = np.arange(np.prod(point_counts)).reshape(point_counts)
    axes = [np.linspace(-length / 2, length / 2, points) for length, points in zip(size, point_counts, strict=True)]
    vertices = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, 3)
    walks = [
        np.cumsum([corner, *steps], axis=0)
        for corner in np.ndindex(*cells)
        for steps in permutations(np.eye(3, dtype=int))
    ]
    return orient_cells(Tetrahedra(vertices, np.array([numbers[tuple(walk.T)] for walk in walks])))


def ball(size: Array) -> Tetrahedra:
    """A spheroid with a flat foot about the origin: two shells and the centre, by Delaunay."""
    vertices = np.concatenate([icosphere(2).vertices, CORE * icosphere(1).vertices, np.zeros((1, 3))])
    cells = Delaunay(vertices).simplices
    vertices[:, 2] = np.maximum(vertices[:, 2], FOOT)
    return orient_cells(Tetrahedra(vertices * size / 2, cells))


if __name__ == "__main__":
    for name, body in {"soft_block": block(BLOCK, CELLS), "tomato": ball(np.array(TOMATO))}.items():
        Path(__file__).with_name(f"{name}.vtk").write_text(body.as_vtk(), encoding="utf-8")
        print(
            name,
            len(body.cells),
            body.vertices.min(axis=0),
            body.volumes.sum(),
            body.volumes.min() / body.volumes.max(),
        )
