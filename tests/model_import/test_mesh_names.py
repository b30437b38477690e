"""Mesh names of URDF files: where packages are looked for, and what is said if a mesh is not there."""

import pytest
from refusals import refused

from soft_gripper.errors import InputError
from soft_gripper.model_import.named_files import mesh_file

NAME = "package://acme_arm/meshes/link.stl"


@pytest.fixture(autouse=True)
def _no_ros(monkeypatch):
    for variable in ("ROS_PACKAGE_PATH", "AMENT_PREFIX_PATH"):
        monkeypatch.delenv(variable, raising=False)


@pytest.fixture
def urdf(tmp_path):
    """Where a URDF file would be, deep in a folder of packages."""
    path = tmp_path / "src" / "acme_arm" / "urdf" / "arm.urdf"
    path.parent.mkdir(parents=True)
    return path


def make_mesh(package, name=None):
    """A mesh in a package's folder, whose package.xml gives it a name if one is given."""
    mesh = package / "meshes" / "link.stl"
    mesh.parent.mkdir(parents=True)
    mesh.touch()
    if name:
        (package / "package.xml").write_text(f"<package><name> {name} </name></package>")
    return mesh


def test_package_xml_gives_another_name_to_a_folder(tmp_path):
    clone = tmp_path / "acme_arm-2.0-main"
    mesh = make_mesh(clone, "acme_arm")
    assert mesh_file(NAME, clone / "urdf" / "arm.urdf") == mesh
    with refused("mesh", "package://other/meshes/link.stl"):
        mesh_file("package://other/meshes/link.stl", clone / "urdf" / "arm.urdf")


def test_broken_package_xml_is_passed_over(urdf, tmp_path):
    mesh = make_mesh(tmp_path / "acme_arm")
    (urdf.parent / "package.xml").write_text("<package")
    assert mesh_file(NAME, urdf) == mesh


@pytest.mark.parametrize(
    ("variable", "folder", "entry"),
    [
        ("ROS_PACKAGE_PATH", "ws/acme_arm", "ws"),
        ("ROS_PACKAGE_PATH", "ws/acme_arm", "ws/acme_arm"),
        ("AMENT_PREFIX_PATH", "ws/share/acme_arm", "ws"),
    ],
)
def test_package_is_installed(urdf, tmp_path, monkeypatch, variable, folder, entry):
    mesh = make_mesh(tmp_path / "ros" / folder, "acme_arm")
    monkeypatch.setenv(variable, f"/nosuch::{tmp_path / 'ros' / entry}")
    assert mesh_file(NAME, urdf) == mesh


def test_unknown_package_names_the_mesh_and_where_it_was_looked_for(urdf, tmp_path):
    name = "package://nosuch/meshes/link.stl"
    with pytest.raises(InputError) as caught:
        mesh_file(name, urdf)
    message = str(caught.value)
    assert message.startswith(f"{urdf}: mesh = '{name}': no folder 'nosuch', and no package.xml of that name")
    assert "ROS_PACKAGE_PATH" in message
    assert "\n" not in message


@pytest.mark.parametrize("name", [NAME, "link.stl", "file:///nosuch/link.stl", "", "package://acme_arm"])
def test_missing_mesh_is_reported_with_its_path(urdf, name):
    with pytest.raises(InputError) as caught:
        mesh_file(name, urdf)
    assert str(caught.value).startswith(f"{urdf}: mesh = '{name}': there is no file /")
