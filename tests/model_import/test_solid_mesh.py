"""Meshes as they are found: seams, parts inside out, cavities, overlaps; compared with known volumes and moments."""

from pathlib import Path

import numpy as np
import pytest
import trimesh

from soft_gripper.errors import InputError
from soft_gripper.model_import.model_file import ModelFile
from soft_gripper.model_import.solid_mesh import solid, winding

FILE = Path("thing.obj")
BOX = trimesh.creation.box((1.0, 1.0, 1.0))
SMALL = trimesh.creation.box((0.5, 0.5, 0.5))


def at(mesh, *place, inside_out=False):
    moved = mesh.copy()
    moved.apply_translation(place)
    if inside_out:
        moved.invert()
    return moved


def of(*parts):
    return trimesh.util.concatenate(parts)


def split(mesh):
    """The same faces, each with vertices of its own."""
    apart = mesh.copy()
    apart.unmerge_vertices()
    return apart


def some_turned(mesh, which):
    faces = np.array(mesh.faces)
    faces[which] = faces[which, ::-1]
    return trimesh.Trimesh(mesh.vertices, faces, process=False)


UP, IN = (0.0, 0.0, 1.0), (0.0, 0.0, 0.0)
INVERTED = trimesh.creation.box((1.0, 1.0, 1.0))
INVERTED.invert()


@pytest.mark.parametrize(
    ("mesh", "volume", "said"),
    [
        (BOX, 1.0, []),
        (split(BOX), 1.0, []),
        (of(split(BOX), split(at(BOX, 3, 0, 0))), 2.0, []),
        (INVERTED, 1.0, ["mended the mesh"]),
        (some_turned(BOX, [1, 5, 7]), 1.0, ["mended part 0"]),
        (some_turned(split(BOX), [0]), 1.0, ["mended part 0"]),
        (of(BOX, at(SMALL, 0, 0, 0.75, inside_out=True)), 1.125, ["mended part 1"]),
        (of(INVERTED, at(SMALL, 0, 0, 0.75)), 1.125, ["mended the mesh", "mended part 1"]),
        (of(BOX, at(SMALL, *IN, inside_out=True)), 0.875, ["read part 1"]),
        (of(INVERTED, SMALL), 0.875, ["mended the mesh", "read part 1"]),
        (of(BOX, at(BOX, *UP)), 2.0, []),
        (of(BOX, at(BOX, 1, 1, 0)), 2.0, []),
        (of(BOX, at(SMALL, 0, 0, 0.6)), 1.125, ["read parts 0 and 1"]),
        (of(BOX, SMALL), 1.125, ["read parts 0 and 1"]),
        (of(trimesh.creation.box((3, 0.2, 0.2)), trimesh.creation.box((0.2, 3, 0.2))), 0.24, ["read parts 0 and 1"]),
    ],
)
def test_parts_are_joined_and_face_outward(mesh, volume, said):
    before = mesh.faces.copy()
    file = ModelFile(FILE)
    found = solid(file, mesh)
    assert found.is_watertight
    assert found.volume == pytest.approx(volume)
    assert [f"{note.outcome} {note.element}" for note in file.notes] == said
    np.testing.assert_array_equal(mesh.faces, before)


OPEN = trimesh.Trimesh(BOX.vertices, BOX.faces[:-1], process=False)
SHEET = trimesh.Trimesh(BOX.vertices, [*BOX.faces[:4], *BOX.faces[:4, ::-1]], process=False)


@pytest.mark.parametrize(
    ("mesh", "said"),
    [
        (OPEN, "it is open"),
        (split(OPEN), "it is open"),
        (of(BOX, at(OPEN, 3, 0, 0)), "1 of its 2 parts are open"),
        (SHEET, "has no volume"),
        (split(SHEET), "it is open"),
        (of(*(at(SMALL, place, 0, 0) for place in range(1001))), "parts = 1001: give a mesh of at most 1000 parts"),
    ],
)
def test_what_is_no_solid_is_refused(mesh, said):
    with pytest.raises(InputError, match=said) as caught:
        solid(ModelFile(FILE), mesh)
    assert str(caught.value).startswith("thing.obj: ")


def test_winding_numbers_of_a_torus():
    points = np.random.default_rng(0).uniform(-1.5, 1.5, (500, 3))
    from_ring = np.hypot(np.hypot(points[:, 0], points[:, 1]) - 1.0, points[:, 2])
    mesh = trimesh.creation.torus(1.0, 0.3, major_sections=48, minor_sections=24)
    clear = abs(from_ring - 0.3) > 6e-3
    np.testing.assert_array_equal(winding(points[clear], mesh.triangles), from_ring[clear] < 0.3)
    np.testing.assert_array_equal(winding(points[clear], mesh.triangles[:, ::-1]), -1.0 * (from_ring[clear] < 0.3))
