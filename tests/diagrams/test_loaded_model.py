"""Model files: read by Drake or by us, named as the scenario says, or refused in one line."""

import shutil

import pytest
import trimesh
from pydrake.multibody.plant import MultibodyPlant

from soft_gripper.diagrams.loaded_model import load_model
from soft_gripper.errors import InputError
from soft_gripper.models import DIRECTORY
from soft_gripper.scenario.schema import MeshConfig, ModelConfig

FINGER = "package://soft_gripper/grippers/finger.urdf"
WORLD = "<sdf version='1.7'><world name='room'>{}</world></sdf>"
MODEL = "<model name='{0}'><link name='{0}'/></model>"


@pytest.fixture(autouse=True)
def _work_in(tmp_path, monkeypatch):
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    monkeypatch.chdir(tmp_path)


@pytest.fixture
def plant():
    return MultibodyPlant(0.0)


def refusal(plant, name, file):
    """What is wrong with a model, in one line."""
    with pytest.raises(InputError) as caught:
        load_model(plant, ModelConfig(name, file), "models[3]")
    return str(caught.value)


def test_springs_of_the_fingers_are_pairs_of_linear_ones_unless_the_scenario_chooses_torsion():
    counts = {}
    for springs in ("linear", "torsion"):
        plant = MultibodyPlant(0.0)
        _, (finger,), _ = load_model(plant, ModelConfig("finger", FINGER, springs=springs), "models[0]")
        counts[springs] = plant.num_force_elements() - 1, len(finger.torsion_springs)  # gravity is one too
    assert counts == {"linear": (24, 0), "torsion": (12, 12)}


@pytest.mark.parametrize("name", ["part.stl", "PART.STL", "part.obj"])
def test_a_bare_mesh_is_an_object(plant, name):
    trimesh.creation.box([40, 30, 50]).export(name, file_type=name[-3:].lower())
    config = ModelConfig("part", name, mass=0.07, mesh=MeshConfig(scale=1e-3))
    model, fingers, _ = load_model(plant, config, "models[0]")
    plant.Finalize()
    assert fingers == []
    assert plant.CalcTotalMass(plant.CreateDefaultContext(), [model]) == pytest.approx(0.07)


def test_meshes_of_a_users_own_model_are_found(plant, tmp_path):
    for name in ("irregular.sdf", "irregular.obj"):
        shutil.copy(DIRECTORY / "objects" / name, tmp_path / name)
    load_model(plant, ModelConfig("mine", str(tmp_path / "irregular.sdf")), "models[0]")
    assert plant.HasBodyNamed("irregular")


def test_a_missing_file_is_reported_with_its_path(plant):
    missing = "package://soft_gripper/objects/nosuch.sdf"
    path = DIRECTORY / "objects" / "nosuch.sdf"
    assert refusal(plant, "thing", missing) == f"models[3]: file = '{missing}': there is no file {path}"


@pytest.mark.parametrize(
    ("name", "text", "complaint"),
    [
        ("two.sdf", WORLD.format(MODEL.format("a") + MODEL.format("b")), "holds 2 models; give a file with one"),
        ("none.sdf", WORLD.format(""), "holds 0 models; give a file with one"),
        ("joint.sdf", WORLD.format("<joint/>"), "Drake cannot read it: "),
        ("bare.urdf", "<robot name='r'/>", "holds a model without links"),
        ("text.txt", "words", "Drake cannot read it: "),
        ("joint.urdf", "<robot name='r'><joint name='j' type='fixed'/></robot>", "Drake cannot read it: "),
    ],
)
def test_a_file_that_is_no_model(plant, tmp_path, name, text, complaint):
    (tmp_path / name).write_text(text)
    assert refusal(plant, "thing", name).startswith(f"models[3]: file = '{name}': {complaint}")
