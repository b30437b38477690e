"""Meshes of tetrahedra: their volumes and surfaces against solids, and files that are refused."""

from pathlib import Path

import numpy as np
import pytest
from refusals import refused

from soft_gripper.extras import soft
from soft_gripper.extras.soft.tetrahedra import Tetrahedra, orient_cells, read_tetrahedra

CORNER = Tetrahedra(np.array([[0, 0, 0], [2, 0, 0], [0, 3, 0], [0, 0, 4]], dtype=float), np.array([[0, 1, 2, 3]]))
GOOD = CORNER.as_vtk()


def written(folder: Path, text: str) -> Path:
    path = folder / "body.vtk"
    path.write_text(text)
    return path


def outward(mesh: Tetrahedra) -> np.ndarray:
    """Area vectors of the faces of the surface, (F, 3)."""
    a, b, c = np.swapaxes(mesh.vertices[mesh.boundary], 0, 1)
    return np.cross(b - a, c - a) / 2


def test_tetrahedra_that_are_inside_out_are_turned():
    turned = orient_cells(Tetrahedra(CORNER.vertices, CORNER.cells[:, [1, 0, 2, 3]]))
    assert turned.volumes == pytest.approx([4])


@pytest.mark.parametrize(("name", "extent"), [("soft_block", (44, 40, 60)), ("tomato", (46, 46, 39.48))])
def test_shipped_meshes_are_solid(name, extent):
    """A closed surface has no net area, and encloses the volume of what it is the surface of (divergence theorem)."""
    mesh = read_tetrahedra(Path(soft.__path__[0]) / "objects" / f"{name}.vtk")
    np.testing.assert_allclose(1e3 * np.ptp(mesh.vertices, axis=0), extent, rtol=0.01)
    areas, centers = outward(mesh), mesh.vertices[mesh.boundary].mean(axis=1)
    np.testing.assert_allclose(areas.sum(axis=0), 0, atol=1e-12)
    assert mesh.volumes.min() > 0
    assert (areas * centers).sum() / 3 == pytest.approx(mesh.volumes.sum(), rel=1e-9)


def test_what_is_written_is_read(tmp_path):
    mesh = read_tetrahedra(written(tmp_path, GOOD))
    np.testing.assert_array_equal(mesh.cells, CORNER.cells)
    np.testing.assert_allclose(mesh.vertices, CORNER.vertices, atol=1e-12)


@pytest.mark.parametrize(
    "text",
    [
        "",
        "not a mesh",
        GOOD.replace("ASCII", "BINARY"),
        GOOD.replace("UNSTRUCTURED_GRID", "POLYDATA"),
        GOOD.replace("4 0 1 2 3", "3 0 1 2 3"),
        GOOD.replace("\n10\n", "\n12\n"),
        GOOD.replace("4 0 1 2 3", "4 0 1 2"),
        GOOD.replace("2.000000000000", "two"),
        GOOD.replace("POINTS 4", "POINTS many"),
        GOOD.replace("POINTS 4", "POINTS 40"),
        GOOD[: len(GOOD) // 2],
    ],
    ids=["empty", "text", "binary", "surface", "triangle", "hexahedron", "short", "word", "many", "missing", "cut off"],
)
def test_a_file_that_is_not_such_a_mesh_is_refused(tmp_path, text):
    with refused("mesh", "body.vtk"):
        read_tetrahedra(written(tmp_path, text))


@pytest.mark.parametrize(
    ("old", "new", "field", "value"),
    [
        ("4 0 1 2 3", "4 0 1 2 4", "cells", 4),
        ("4 0 1 2 3", "4 0 1 2 -1", "cells", -1),
        ("2.000000000000", "nan", "points", "nan"),
        ("2.000000000000", "inf", "points", "nan"),
        ("4 0 1 2 3", "4 0 1 2 2", "cells", 0),
        ("CELLS 1 5\n4 0 1 2 3\nCELL_TYPES 1\n10", "CELLS 0 0\nCELL_TYPES 0", "cells", 0),
    ],
    ids=["beyond", "negative", "nan", "inf", "flat", "none"],
)
def test_a_mesh_that_is_not_a_solid_is_refused(tmp_path, old, new, field, value):
    assert old in GOOD
    with refused(field, value):
        read_tetrahedra(written(tmp_path, GOOD.replace(old, new)))
