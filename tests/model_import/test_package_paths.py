"""A package:// path stays in its package."""

import os
import xml.etree.ElementTree as ET
from pathlib import Path

import pytest
from pydrake.multibody.parsing import Parser
from pydrake.multibody.plant import MultibodyPlant
from refusals import refused

from soft_gripper.errors import InputError
from soft_gripper.model_import.drake_parsing import add_text, check_inside, check_uris, named_uris
from soft_gripper.model_import.mesh_names import mesh_file

CLIMBING = ["../a.obj", "b/../../a.obj", "..", "b/../../package_of_another/a.obj", "", "b/.."]


@pytest.mark.parametrize("inside", CLIMBING)
def test_paths_that_climb_out(inside: str) -> None:
    with pytest.raises(InputError, match="leads out of the package"):
        check_inside("a.urdf", f"package://p/{inside}")


def test_meshes_of_other_packages(tmp_path: Path) -> None:
    (tmp_path / "p").mkdir()
    (tmp_path / "secret.obj").touch()
    with refused("file", "package://p/../secret.obj"):
        mesh_file("package://p/../secret.obj", tmp_path / "p" / "arm.urdf")


@pytest.mark.parametrize(
    "line", ["<mesh filename='package://p/../a.obj'/>", "<uri>model://../a</uri>", "<uri> package://p/.. </uri>"]
)
def test_names_in_models(line: str) -> None:
    with refused("file"):
        check_uris(Path("a.urdf"), named_uris(ET.fromstring(f"<robot><link>{line}</link></robot>")))
    check_uris(
        Path("a.urdf"),
        named_uris(ET.fromstring("<robot><mesh filename='package://p/a.obj'/><uri>../a.obj</uri></robot>")),
    )


def test_a_pipe_that_took_the_place_of_a_mesh(tmp_path: Path) -> None:
    mesh, before, after = tmp_path / "a.obj", MultibodyPlant(0.01), MultibodyPlant(0.01)
    shape = f'<visual><geometry><mesh filename="file://{mesh}"/></geometry></visual>'
    text = f'<robot name="r"><link name="a">{shape}</link></robot>'
    mesh.write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n")
    add_text(Parser(before), text, tmp_path / "a.urdf", ".urdf")
    mesh.unlink()
    os.mkfifo(mesh)
    with refused("file", f"file://{mesh}"):
        add_text(Parser(after), text, tmp_path / "a.urdf", ".urdf")
