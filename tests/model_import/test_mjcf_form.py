"""The form MJCF, and a form of a user's."""

import re
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
import trimesh
from pydrake.geometry import Role
from pydrake.multibody.plant import AddMultibodyPlantSceneGraph
from pydrake.systems.framework import DiagramBuilder
from refusals import refused

from soft_gripper.diagrams.scene import add_model
from soft_gripper.files.notes import collect_notes
from soft_gripper.files.xml_text import parse_xml
from soft_gripper.model_import.mesh_files import read_msh
from soft_gripper.model_import.model_file import ModelFile
from soft_gripper.model_import.read_model import read_model
from soft_gripper.scenario.schema import ModelConfig


def read(folder, text):
    (folder / "m.xml").write_text(text)
    plant, scene_graph = AddMultibodyPlantSceneGraph(DiagramBuilder(), 0.01)
    with collect_notes() as notes:
        add_model(plant, ModelConfig("thing", str(folder / "m.xml")), "models[0]", None)
    plant.Finalize()
    return plant, scene_graph, notes


@pytest.mark.parametrize(("other", "touches"), [("1", True), ("2", False), ("3", True)])
def test_bodies_touch_if_their_masks_match(tmp_path, other, touches):
    balls = "".join(
        f'<body name="{name}" pos="{x} 0 0"><joint/><geom size="0.1" contype="{kind}" conaffinity="{kind}"/></body>'
        for name, x, kind in (("a", 0, "1"), ("b", 1, other))
    )
    plant, scene_graph, _ = read(tmp_path, f"<mujoco><worldbody>{balls}</worldbody></mujoco>")
    inspector = scene_graph.model_inspector()
    one, two = (
        inspector.GetGeometries(plant.GetBodyFrameIdOrThrow(plant.GetBodyByName(name).index()), Role.kProximity)[0]
        for name in "ab"
    )
    assert inspector.CollisionFiltered(one, two) is not touches


def test_masks_of_many_bodies_are_few_groups(tmp_path):
    """Every third of 300 balls touches the others of its kind."""
    balls = "".join(
        f'<body name="b{i}" pos="{i} 0 0"><joint/><geom size="0.1" contype="{1 << i % 3}" conaffinity="{1 << i % 3}"/>'
        "</body>"
        for i in range(300)
    )
    root = parse_xml("m.xml", f"<mujoco><worldbody>{balls}</worldbody></mujoco>")
    imported = read_model(ModelFile(tmp_path / "m.xml", root))
    assert len(imported.apart) == 3
    assert len(imported.text) < 1.5 * len(balls)
    plant, scene_graph, _ = read(tmp_path, f"<mujoco><worldbody>{balls}</worldbody></mujoco>")
    inspector = scene_graph.model_inspector()
    shapes = [
        inspector.GetGeometries(plant.GetBodyFrameIdOrThrow(plant.GetBodyByName(f"b{i}").index()), Role.kProximity)[0]
        for i in range(6)
    ]
    filtered = [[inspector.CollisionFiltered(one, other) for other in shapes] for one in shapes]
    assert filtered == [[(i - j) % 3 != 0 or i == j for j in range(6)] for i in range(6)]


@pytest.mark.parametrize("default", ["", '<default><geom type="mesh" mesh="none"/></default>'])
def test_a_mesh_that_is_missing_is_named(tmp_path, default):
    geom = "<geom/>" if default else '<geom type="mesh" mesh="none"/>'
    with refused("mesh", "none"):
        read(tmp_path, f"<mujoco>{default}<worldbody><body><joint/>{geom}</body></worldbody></mujoco>")


def test_bodies_of_meshes_that_drake_leaves_out_have_a_mass(tmp_path):
    asset = '<asset><mesh name="m" vertex="0 0 0 1 0 0 0 1 0 0 0 1"/></asset>'
    body = '<body><joint/><geom type="mesh" mesh="m"/></body>'
    plant, _, _ = read(tmp_path, f"<mujoco>{asset}<worldbody>{body}</worldbody></mujoco>")
    assert plant.CalcTotalMass(plant.CreateDefaultContext()) == pytest.approx(1e-3)


def test_open_meshes_that_give_a_mass_are_noted(tmp_path):
    box = trimesh.creation.box((0.1, 0.1, 0.1))
    box.update_faces(np.arange(len(box.faces)) > 1)
    box.export(tmp_path / "open.stl")
    asset = '<asset><mesh name="o" file="open.stl"/></asset>'
    body = '<body><geom type="mesh" mesh="o"/></body>'
    _, _, notes = read(tmp_path, f"<mujoco>{asset}<worldbody>{body}</worldbody></mujoco>")
    assert [note.why for note in notes if note.element == "the mesh"] == [
        "it is open: its volume, and a mass from its density, are uncertain"
    ]


@pytest.mark.parametrize(
    "content",
    [
        b"",
        b"solid",
        np.array([-1, 0, 0, 0], "<i4").tobytes(),
        np.array([1, 0, 0, 0], "<i4").tobytes(),
        np.array([2**30, 0, 0, 2**30], "<i4").tobytes(),
        np.array([0, 0, 0, 1, 0, 0, 0], "<i4").tobytes(),
        np.array([1, 0, 0, 0], "<i4").tobytes() + np.full(3, np.nan, "<f4").tobytes(),
    ],
)
def test_damaged_meshes_of_mujoco(tmp_path, content):
    (tmp_path / "a.msh").write_bytes(content)
    with refused("mesh", "a.msh"):
        read_msh(tmp_path / "a.msh")


PAGE = (Path(__file__).parents[2] / "docs" / "howto" / "own_model_format.md").read_text(encoding="utf-8")
LOAD = """
import sys
from pathlib import Path
from soft_gripper.model_import import forms
forms.__path__.append(sys.argv[1])
from pydrake.multibody.plant import MultibodyPlant
from soft_gripper.diagrams.loaded_model import load_model
from soft_gripper.diagrams.simulation import fingerprint
from soft_gripper.errors import InputError
from soft_gripper.files.notes import collect_notes
from soft_gripper.scenario.schema import ModelConfig
for changes in ({}, {"mass": 0.3}, {"without": ["pear"]}):
    plant = MultibodyPlant(0.01)
    try:
        with collect_notes() as notes:
            load_model(plant, ModelConfig("pear", "pear.toml", free=True, **changes), "models[0]")
        print(round(plant.GetBodyByName("pear").default_mass(), 9), *notes)
    except InputError as error:
        print(error)
print(fingerprint(Path("pear.toml")))
"""


def test_a_file_of_the_form(tmp_path):
    """Is an object as it says, of another mass, with all its links, and in no kept station: its mesh may change."""
    (name, code), *_ = re.findall(r"^```python\n# \S+/(\w+\.py)\n(.*?)^```$", PAGE, re.MULTILINE | re.DOTALL)
    (text,) = re.findall(r"^```toml\n(.*?)^```$", PAGE, re.MULTILINE | re.DOTALL)
    (tmp_path / "forms").mkdir()
    (tmp_path / "forms" / name).write_text(code, encoding="utf-8")
    (tmp_path / "pear.toml").write_text(text, encoding="utf-8")
    trimesh.creation.icosphere(radius=0.022).export(tmp_path / "pear.obj")
    root = str(Path(__file__).parents[2])
    found = subprocess.run(
        [sys.executable, "-c", f"import sys; sys.path.insert(0, {root!r}){LOAD}", str(tmp_path / "forms")],
        cwd=tmp_path,
        env={"XDG_CACHE_HOME": str(tmp_path / "cache"), "PATH": ""},
        capture_output=True,
        text=True,
        check=False,
    )
    assert found.returncode == 0, found.stderr
    assert found.stdout.splitlines() == [
        "0.04",
        "0.3 pear.toml: left out mass = 0.04: the scenario gives another",
        "models[0]: without = ['pear']: links can be left out of URDF, SDFormat, MJCF only",
        "None",
    ]
