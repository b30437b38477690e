"""Meshes of any format as OBJ files: size, place, normals and colours of the source, made once, by whoever is first."""

import multiprocessing
from pathlib import Path

import numpy as np
import pytest
import trimesh
from pydrake.geometry import Mesh
from pydrake.math import RigidTransform
from trimesh.visual import TextureVisuals
from trimesh.visual.material import PBRMaterial

from soft_gripper.errors import InputError
from soft_gripper.files.notes import MENDED
from soft_gripper.model_import.mesh_files import cache_folder, convert_to_obj, outward, read_scene
from soft_gripper.model_import.model_file import ModelFile

SIZE = np.array([0.1, 0.2, 0.3])
CENTER = np.array([0.5, -0.3, 1.0])
BOX = np.array([CENTER - SIZE / 2, CENTER + SIZE / 2])


def a_box(color=None):
    box = trimesh.creation.box(SIZE)
    box.apply_translation(CENTER)
    if color:
        box.visual = TextureVisuals(material=PBRMaterial(baseColorFactor=color))
    return box


def write(mesh, path):
    mesh.export(path, file_type=path.suffix[1:].lower())
    return path


def write_dae(path, *meshes, change=("", "")):
    """A COLLADA file, with something in its text changed."""
    text = trimesh.exchange.dae.export_collada(list(meshes)).decode()
    assert change[0] in text
    path.write_text(text.replace(*change, 1))
    return path


def bounds(path):
    """Lowest and highest corner, (2, 3) m, as Drake reads the file."""
    hull = Mesh(str(path)).GetConvexHull()
    corners = np.array([hull.vertex(i) for i in range(hull.num_vertices())])
    return np.array([corners.min(axis=0), corners.max(axis=0)])


def colors(obj):
    """Diffuse colours in the MTL file beside an OBJ file."""
    lines = obj.with_suffix(".mtl").read_text().splitlines()
    return sorted(tuple(float(value) for value in line.split()[1:]) for line in lines if line.startswith("Kd"))


@pytest.mark.parametrize("axis", ["X_UP", "Y_UP", "Z_UP"])
def test_axes_of_a_collada_file_stay_whichever_is_called_up(tmp_path, axis):
    path = write_dae(tmp_path / "box.dae", a_box(), change=("Y_UP", axis))
    np.testing.assert_allclose(bounds(convert_to_obj(path)), BOX, atol=1e-7)


def test_a_glb_file_stands_as_drake_lets_a_gltf_file_stand(tmp_path):
    exported = trimesh.exchange.gltf.export_gltf(trimesh.Scene(a_box()), embed_buffers=True)
    (tmp_path / "box.gltf").write_bytes(exported["model.gltf"])
    glb = convert_to_obj(write(trimesh.Scene(a_box()), tmp_path / "box.glb"))
    np.testing.assert_allclose(bounds(glb), bounds(tmp_path / "box.gltf"), atol=1e-6)


@pytest.mark.parametrize("ending", ["stl", "dae"])
def test_round_things_are_shaded_smoothly_and_edges_stay_sharp(tmp_path, ending):
    """The normals of a fine sphere point out from its middle, those of a box along the axes."""
    for name, mesh in (("ball", trimesh.creation.icosphere(4, 0.1)), ("box", trimesh.creation.box(SIZE))):
        mesh.unmerge_vertices()  # flat faces, as many programs write them
        kept = convert_to_obj(write(mesh, tmp_path / f"{name}.{ending}"))
        lines = [line.split() for line in kept.read_text().splitlines()]
        vertices, normals = (np.array([line[1:4] for line in lines if line[0:1] == [k]], float) for k in ("v", "vn"))
        assert len(normals) == len(vertices)
        if name == "ball":
            assert (np.sum(normals * vertices, axis=1) > 0.1 * 0.999).all()
        else:
            np.testing.assert_allclose(np.abs(normals).max(axis=1), 1, atol=1e-6)


def test_a_mesh_that_changed_is_converted_again(tmp_path):
    path = write(a_box(), tmp_path / "box.stl")
    convert_to_obj(path)
    write(trimesh.creation.box(2 * SIZE), path)
    np.testing.assert_allclose(bounds(convert_to_obj(path)), [-SIZE, SIZE], atol=1e-7)


def test_what_a_killed_conversion_left_does_no_harm(tmp_path, cache):
    path = write_dae(tmp_path / "box.dae", a_box((255, 0, 0, 255)))
    kept = convert_to_obj(path)
    kept.unlink()
    assert convert_to_obj(path) == kept
    assert colors(kept) == [(1, 0, 0)]


@pytest.mark.slow
def test_processes_may_convert_at_once(tmp_path, cache):
    path = write(trimesh.creation.icosphere(4, 0.1), tmp_path / "ball.stl")
    with multiprocessing.get_context("spawn").Pool(2) as pool:
        kept = set(pool.map(convert_to_obj, [path] * 4, chunksize=1))
    assert list(cache.iterdir()) == list(kept)
    np.testing.assert_allclose(bounds(kept.pop()), [[-0.1] * 3, [0.1] * 3], atol=1e-3)


@pytest.mark.parametrize("name", ["missing.stl", "empty.stl", "empty.dae", "junk.dae", "junk.stl", "words.xyzzy"])
def test_what_is_no_mesh(tmp_path, name):
    contents = {"empty": b"", "junk": b"\x00\xff nothing", "words": b"words"}
    if (content := contents.get(Path(name).stem)) is not None:
        (tmp_path / name).write_bytes(content)
    with pytest.raises(InputError) as caught:
        convert_to_obj(tmp_path / name)
    assert str(caught.value).startswith(f"{tmp_path / name}: mesh = '{name}': ")
    assert "\n" not in str(caught.value)
    assert not cache_folder().exists()


@pytest.mark.parametrize("suffix", [".obj", ".stl", ".dae"])
def test_a_file_that_would_fill_the_memory_is_not_read(tmp_path, suffix):
    path = tmp_path / f"large{suffix}"
    with path.open("wb") as file:
        file.truncate(2**30)
    for read in (read_scene, convert_to_obj):
        with pytest.raises(InputError) as error:
            read(path)
        assert (error.value.field, error.value.value) == ("size", 2**30)


def test_collada_whose_material_is_missing(tmp_path):
    found = convert_to_obj(write_dae(tmp_path / "a.dae", a_box((1.0, 0, 0, 1.0)), change=('target="#', 'target="#no')))
    np.testing.assert_allclose(read_scene(found).bounds, BOX, atol=1e-6)


@pytest.mark.parametrize("is_inside_out", [False, True])
def test_a_part_that_is_inside_out_is_turned_with_a_note_and_nothing_else(tmp_path, is_inside_out):
    small = trimesh.creation.box([0.03, 0.02, 0.02], RigidTransform([0.5, 0, 0]).GetAsMatrix4())
    if is_inside_out:
        small.invert()
    path = write(trimesh.util.concatenate([trimesh.creation.box(SIZE), small]), tmp_path / "parts.obj")
    model = ModelFile(path)
    turned = outward(model, path, path)
    assert trimesh.load(turned).volume == pytest.approx(SIZE.prod() + 1.2e-5, rel=1e-6)
    assert [note.outcome for note in model.notes] == is_inside_out * [MENDED]
    assert (turned != path) == is_inside_out
