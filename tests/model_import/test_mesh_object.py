"""Mesh files of the user's as objects: inertia against textbook solids, any format and unit, mistakes in one line."""

from pathlib import Path

import numpy as np
import pytest
import trimesh
from pydrake.multibody.parsing import Parser
from pydrake.multibody.plant import AddMultibodyPlantSceneGraph
from pydrake.multibody.tree import UnitInertia
from pydrake.systems.framework import DiagramBuilder

from soft_gripper.errors import InputError
from soft_gripper.model_import.imported_model import ImportOptions
from soft_gripper.model_import.model_file import ModelFile
from soft_gripper.model_import.read_model import read_model

SIZE = np.array([0.04, 0.03, 0.05])  # m
CENTER = [0.01, 0.0, -0.02]  # m
MASS = 0.07  # kg
MILLIMETRES = {"scale": 1e-3}


def mesh_to_sdf(path, config, name="thing", **more):
    return read_model(ModelFile(path), ImportOptions(name=name, **config, **more)).text


@pytest.fixture
def box_file(tmp_path):
    """Writes a box, in millimetres, of the name that is asked for."""

    def write(name: str, change=lambda mesh: None) -> Path:
        box = trimesh.creation.box(1e3 * SIZE)
        box.apply_translation(1e3 * np.array(CENTER))
        change(box)
        box.export(tmp_path / name, file_type=Path(name).suffix[1:].lower())
        return tmp_path / name

    return write


def inertia(path, config):
    """Mass, kg, centre of mass, m, and rotational inertia about it, kg m^2, as Drake reads them."""
    plant, _ = AddMultibodyPlantSceneGraph(DiagramBuilder(), 0.0)
    Parser(plant).AddModelsFromString(mesh_to_sdf(path, config, mass=MASS), "sdf")
    plant.Finalize()
    M_BBo = plant.GetBodyByName("thing").default_spatial_inertia()
    about_center = M_BBo.Shift(M_BBo.get_com()).CalcRotationalInertia()
    return M_BBo.get_mass(), M_BBo.get_com(), about_center.CopyToFullMatrix3()


def assert_is_the_box(path, config=MILLIMETRES):
    mass, center, moments = inertia(path, config)
    assert mass == pytest.approx(MASS, rel=1e-9)
    np.testing.assert_allclose(center, CENTER, atol=1e-9)
    np.testing.assert_allclose(moments, MASS * UnitInertia.SolidBox(*SIZE).CopyToFullMatrix3(), atol=1e-11)


@pytest.mark.parametrize("ending", ["obj", "STL", "ply", "glb"])
def test_box_in_millimetres_has_the_inertia_of_a_box(box_file, ending):
    assert_is_the_box(box_file(f"box.{ending}"))


def test_faces_that_look_inward_are_turned(box_file, cache):
    assert_is_the_box(box_file("box.stl", change=lambda mesh: mesh.invert()))
    (kept,) = cache.iterdir()
    assert trimesh.load(kept).volume == pytest.approx(np.prod(SIZE))


def test_cylinder_askew_has_the_inertia_of_a_cylinder(tmp_path):
    """A prism of 256 sides has all but (2 pi / 256)^2 / 6 of the moments of the cylinder around it."""
    R = trimesh.transformations.rotation_matrix(0.7, [1, 2, -1])
    cylinder = trimesh.creation.cylinder(radius=0.02, height=0.06, sections=256, transform=R)
    cylinder.export(tmp_path / "cylinder.obj")
    _, center, moments = inertia(tmp_path / "cylinder.obj", {})
    straight = MASS * UnitInertia.SolidCylinder(0.02, 0.06, [0, 0, 1]).CopyToFullMatrix3()
    np.testing.assert_allclose(center, 0, atol=1e-9)
    np.testing.assert_allclose(moments, R[:3, :3] @ straight @ R[:3, :3].T, atol=2e-4 * straight.max())


def test_friction_and_colour_are_taken_over(box_file):
    config = {"scale": 1e-3, "color": [0.1, 0.2, 0.3, 1]}
    text = mesh_to_sdf(box_file("box.obj"), config, friction=0.35)
    assert text.count(">0.35<") == 2  # static and dynamic
    assert "<diffuse>0.1 0.2 0.3 1.0</diffuse>" in text


def test_scaled_mesh_is_kept_once_in_the_cache(box_file, cache):
    path = box_file("box.stl")
    mesh_to_sdf(path, MILLIMETRES, "one")
    (kept,) = cache.iterdir()
    written = kept.stat().st_mtime_ns
    np.testing.assert_allclose(trimesh.load(kept).extents, SIZE, rtol=1e-6)
    mesh_to_sdf(path, MILLIMETRES, "two")
    assert kept.stat().st_mtime_ns == written
    mesh_to_sdf(path, {"scale": 2e-3}, "three")
    assert len(list(cache.iterdir())) == 2


@pytest.mark.parametrize("unset", ["", "relative"])
def test_cache_is_in_the_home_folder_unless_an_absolute_path_is_given(box_file, tmp_path, monkeypatch, unset):
    """As the XDG specification says."""
    monkeypatch.setenv("XDG_CACHE_HOME", unset)
    monkeypatch.setenv("HOME", str(tmp_path / "home"))
    monkeypatch.chdir(tmp_path)
    assert_is_the_box(box_file("box.stl"))
    assert len(list((tmp_path / "home" / ".cache" / "soft-gripper" / "meshes").iterdir())) == 1
    assert not (tmp_path / "soft-gripper").exists()


def without_a_face(mesh):
    mesh.update_faces(np.arange(len(mesh.faces)) > 0)


@pytest.mark.parametrize(
    ("change", "config", "complaint"),
    [
        (without_a_face, MILLIMETRES, "mesh = 'box.stl': is not watertight"),
        (lambda mesh: None, {}, "mesh.scale = 1.0: makes the object 50 m large; is the file in millimetres?"),
        (lambda mesh: None, {"scale": 1e-6}, "mesh.scale = 1e-06: makes the object 5e-05 m large; too small"),
    ],
    ids=["open", "large", "small"],
)
def test_mesh_that_is_no_object(box_file, cache, change, config, complaint):
    path = box_file("box.stl", change)
    with pytest.raises(InputError) as caught:
        mesh_to_sdf(path, config)
    assert str(caught.value).startswith(f"{path}: {complaint}")
    assert not cache.exists()
