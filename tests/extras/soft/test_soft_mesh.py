"""A mesh of tetrahedra as a soft object, as Drake reads it, and files that are refused."""

from pathlib import Path

import numpy as np
import pytest
import trimesh
from pydrake.multibody.parsing import Parser
from pydrake.multibody.plant import AddMultibodyPlantSceneGraph
from pydrake.systems.framework import DiagramBuilder
from refusals import refused

from soft_gripper.diagrams.loaded_model import import_options, load_model
from soft_gripper.extras import soft
from soft_gripper.extras.soft.soft_kind import SoftKind
from soft_gripper.model_import.model_file import ModelFile
from soft_gripper.model_import.read_model import read_model
from soft_gripper.scenario.schema import MeshConfig, ModelConfig

OBJECTS = Path(soft.__path__[0]) / "objects"
BLOCK = OBJECTS / "soft_block.vtk"
SOFT = MeshConfig(scale=0.5, youngs_modulus=3e4, poissons_ratio=0.4, relaxation_time=0.01)


@pytest.fixture(autouse=True)
def cache(tmp_path, monkeypatch) -> None:
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))


def mesh_to_sdf(path: Path, config: MeshConfig, mass: float | None = None, friction: float | None = None) -> str:
    model = ModelConfig("thing", str(path), mesh=config, mass=mass, friction=friction)
    return read_model(ModelFile(path), import_options(model)).text


def parsed(config: MeshConfig):
    plant, scene_graph = AddMultibodyPlantSceneGraph(DiagramBuilder(), 0.01)
    Parser(plant).AddModelsFromString(mesh_to_sdf(BLOCK, config, 0.02, 0.6), "sdf")
    plant.Finalize()
    return plant, scene_graph.model_inspector()


def test_drake_reads_the_material_the_mass_and_the_scale():
    plant, inspector = parsed(SOFT)
    soft = SoftKind().objects(plant, inspector, ["thing"])["thing"]
    material = soft.body.config()
    found = material.youngs_modulus(), material.poissons_ratio(), material.stiffness_damping_coefficient()
    assert found == (3e4, 0.4, 0.01)
    assert soft.mass == pytest.approx(0.02, rel=1e-6)
    np.testing.assert_allclose(1e3 * np.ptp(soft.rest.vertices, axis=0), [22, 20, 30], rtol=1e-6)
    friction = inspector.GetProximityProperties(soft.geometry).GetProperty("material", "coulomb_friction")
    assert friction.dynamic_friction() == 0.6


@pytest.mark.parametrize("key", ["mass", "friction"])
def test_what_an_sdformat_file_says_of_a_soft_object_stays(tmp_path, key):
    text = mesh_to_sdf(BLOCK, SOFT)
    (tmp_path / "soft.sdf").write_text(text, encoding="utf-8")
    plant, _ = AddMultibodyPlantSceneGraph(DiagramBuilder(), 0.01)
    with refused(key, 0.5):
        load_model(plant, ModelConfig("thing", str(tmp_path / "soft.sdf"), free=True, **{key: 0.5}), "models[0]")


def test_a_surface_with_a_modulus_is_refused(tmp_path):
    path = Path(tmp_path) / "box.obj"
    trimesh.creation.box([0.04, 0.04, 0.04]).export(path)
    with refused("mesh.youngs_modulus", 3e4) as caught:
        mesh_to_sdf(path, SOFT)
    assert "tetrahedra" in str(caught.value)


def test_a_mesh_in_millimetres_is_refused():
    with refused("mesh.scale", 100):
        mesh_to_sdf(BLOCK, MeshConfig(scale=100, youngs_modulus=3e4))
