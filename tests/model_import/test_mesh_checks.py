"""Mesh files are checked before anything reads them: kinds, sizes, and all that they refer to."""

import json
import os
from copy import deepcopy
from pathlib import Path

import pytest
import trimesh
from pydrake.multibody.plant import AddMultibodyPlantSceneGraph
from pydrake.systems.framework import DiagramBuilder
from refusals import refused

from soft_gripper.diagrams.scene import add_model
from soft_gripper.errors import InputError
from soft_gripper.model_import.mesh_checks import check_mesh_file
from soft_gripper.model_import.mesh_files import read_scene
from soft_gripper.scenario.schema import ModelConfig

BOX = trimesh.creation.box((0.1, 0.1, 0.1))
FILES = BOX.export(file_type="gltf")
GLTF = json.loads(FILES["model.gltf"])


def write(folder: Path, gltf: object) -> Path:
    for name, content in FILES.items():
        (folder / name).write_bytes(content)
    (folder / "m.gltf").write_text(json.dumps(gltf))
    return folder / "m.gltf"


def load(path: Path, mesh: str) -> None:
    """Reads a URDF whose link is seen as a mesh."""
    inertial = '<mass value="1"/><inertia ixx="1e-3" iyy="1e-3" izz="1e-3" ixy="0" ixz="0" iyz="0"/>'
    visual = f'<visual><geometry><mesh filename="{mesh}"/></geometry></visual>'
    path.write_text(f'<robot name="r"><link name="l"><inertial>{inertial}</inertial>{visual}</link></robot>')
    plant, _ = AddMultibodyPlantSceneGraph(DiagramBuilder(), 0.01)
    add_model(plant, ModelConfig("m", str(path), free=True), "models[0]", None)


def test_a_whole_gltf_is_read(tmp_path: Path) -> None:
    load(tmp_path / "a.urdf", write(tmp_path, GLTF).name)
    (tmp_path / "a b.glb").write_bytes(BOX.export(file_type="glb"))
    check_mesh_file(tmp_path / "a b.glb")
    named = deepcopy(GLTF)
    os.rename(tmp_path / GLTF["buffers"][0]["uri"], tmp_path / "a b.bin")
    named["buffers"][0]["uri"] = "a%20b.bin"
    (tmp_path / "n.gltf").write_text(json.dumps(named))
    check_mesh_file(tmp_path / "n.gltf")


CHANGES: list[tuple[str, str]] = [
    ("buffers.0.byteLength", "1000000000000"),
    ("buffers.0.uri", '"data:;base64,AAAA"'),
    ("buffers.0.uri", "null"),
    ("buffers.0.uri", '"pipe"'),
    ("buffers.0.uri", '"/dev/zero"'),
    ("buffers", "[]"),
    ("bufferViews.0.byteOffset", "1000000000000"),
    ("bufferViews.0.byteStride", "1000000000"),
    ("bufferViews.0.buffer", "7"),
    ("accessors.0.count", "1000000000"),
    ("accessors.0.bufferView", "null"),
    ("accessors.0.componentType", "1"),
    ("accessors.0.type", '"MAT9"'),
    ("accessors.0.sparse", "{}"),
    ("meshes.0.primitives", "{}"),
    ("meshes.0.primitives.0.attributes", "{}"),
    ("meshes.0.primitives.0.indices", "99"),
    ("meshes", "[]"),
    ("nodes.0.children", "[0]"),
    ("nodes.0.children", "[[]]"),
    ("scenes.0.nodes", "[9]"),
    ("nodes", "{}"),
    ("asset", "null"),
    ("asset.version", '"1.0"'),
]


@pytest.mark.parametrize(("place", "value"), CHANGES)
def test_a_gltf_that_is_not_whole(tmp_path: Path, place: str, value: str) -> None:
    os.mkfifo(tmp_path / "pipe")
    gltf = deepcopy(GLTF)
    around, *keys = gltf, *place.split(".")
    for key in keys[:-1]:
        around = around[int(key) if key.isdigit() else key]
    around[keys[-1]] = json.loads(value)
    with pytest.raises(InputError, match=r"m\.gltf"):
        check_mesh_file(write(tmp_path, gltf))


@pytest.mark.parametrize("text", ["{", 5000 * "[", "[]", "1"])
def test_a_gltf_without_json(tmp_path: Path, text: str) -> None:
    (tmp_path / "m.gltf").write_text(text)
    with pytest.raises(InputError, match=r"m\.gltf"):
        read_scene(tmp_path / "m.gltf")


@pytest.mark.parametrize("content", [b"glTF", b"glTF" + bytes(16), BOX.export(file_type="glb")[:-9]])
def test_a_binary_gltf_that_is_cut(tmp_path: Path, content: bytes) -> None:
    (tmp_path / "m.glb").write_bytes(content)
    with refused("mesh", "m.glb"):
        check_mesh_file(tmp_path / "m.glb")


@pytest.mark.parametrize(
    ("more", "field"),
    [
        ("mtllib pipe", "file"),
        ("mtllib a.mtl", "file"),
        ("f" + 5000 * " 1 2 3", "longest line"),
        (6000 * "o a\n", "groups"),
    ],
)
def test_an_obj_without_an_end(tmp_path: Path, more: str, field: str) -> None:
    os.mkfifo(tmp_path / "pipe")
    (tmp_path / "a.mtl").write_text("newmtl a\nmap_Kd pipe\n")
    (tmp_path / "a.obj").write_text(f"{BOX.export(file_type='obj')}\n{more}\n")
    with pytest.raises(InputError) as error:
        check_mesh_file(tmp_path / "a.obj")
    assert error.value.field == field


LINE = "v 0 0 0\nv 1 0 0\nv 2 0 0\nf 1 2 3\n"


@pytest.mark.parametrize("content", [LINE, "v 0 0 0\n", "", "v 0 0 0\nv 1 0 0\nl 1 2\n"])
def test_what_is_seen_has_an_extent(tmp_path: Path, content: str) -> None:
    (tmp_path / "seen.obj").write_text(content)
    with pytest.raises(InputError, match=r"a\.urdf: mesh = '.*seen\.obj"):
        load(tmp_path / "a.urdf", "seen.obj")
