"""What Drake parses, in which folders and with which numbers, and what it complains of."""

import os
from pathlib import Path

import pytest
from pydrake.multibody.parsing import Parser
from pydrake.multibody.plant import MultibodyPlant
from refusals import refused

from soft_gripper.errors import InputError
from soft_gripper.files.xml_text import parse_xml
from soft_gripper.model_import.drake_parsing import (
    add_text,
    check_file,
    check_inside,
    check_numbers,
    drake_reads,
)
from soft_gripper.model_import.named_files import mesh_file


@pytest.mark.parametrize("error", [RuntimeError("a\nb"), ValueError("a"), IndexError("a"), SystemExit("a")])
def test_what_drake_raises(error: BaseException) -> None:
    with (
        refused("file", "a.urdf"),
        drake_reads("models[0]", "file", "a.urdf"),
    ):
        raise error


def test_what_is_not_drakes() -> None:
    for error in (SystemExit(3), InputError("a.urdf", "box.size", "0", "give a size"), KeyboardInterrupt()):
        with pytest.raises(type(error)) as caught, drake_reads("models[0]", "file", "a.urdf"):
            raise error
        assert caught.value is error


URDF_JOINT = '<joint name="{0}{1}" type="{2}"><parent link="{0}"/><child link="{1}"/></joint>'
SDF_JOINT = '<joint name="{0}{1}" type="{2}"><parent>{0}</parent><child>{1}</child></joint>'


def model(joints: list[str], kind: str, suffix: str) -> str:
    """Links a, b, c with joints between them, each given by two letters."""
    links = "".join(f'<link name="{name}"/>' for name in "abc")
    joint = URDF_JOINT if suffix == ".urdf" else SDF_JOINT
    inside = links + "".join(joint.format(*ends, kind) for ends in joints)
    if suffix == ".urdf":
        return f'<robot name="r">{inside}</robot>'
    return f'<sdf version="1.7"><model name="r">{inside}</model></sdf>'


@pytest.mark.parametrize("suffix", [".urdf", ".sdf"])
@pytest.mark.parametrize("kind", ["revolute", "fixed"])
@pytest.mark.parametrize("joints", [["ab", "ba"], ["ab", "bc", "ca"], ["ab", "bc", "ac"], ["ab", "cc"]])
def test_a_ring_of_links_is_refused(joints: list[str], kind: str, suffix: str) -> None:
    with pytest.raises(InputError) as error:
        add_text(Parser(MultibodyPlant(0.01)), model(joints, kind, suffix), Path("a" + suffix), suffix)
    assert error.value.field == "parent, child"
    assert error.value.value == ", ".join(joints[-1])


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
def test_names_in_models(tmp_path: Path, line: str) -> None:
    path = tmp_path / "a.urdf"
    path.write_text(f"<robot><link>{line}</link></robot>")
    with refused("file"):
        check_file(path)
    path.write_text("<robot><mesh filename='package://p/a.obj'/><uri>../a.obj</uri></robot>")
    check_file(path)


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


URDF = {
    '<box size="0 1 1"/>': "box.size = '0 1 1': give sizes from 1e-09 to 1e\\+06 m",
    '<box size="5e-324 1 1"/>': "box.size = .*: give finite numbers: 0, or 1e-30 to",
    '<box size="1e-200 1 1"/>': "box.size",
    '<box size="1e-10 1 1"/>': "box.size = .*: give sizes",
    '<box size="1 1"/>': "box.size = '1 1': give three numbers",
    '<box size="nan 1 1"/>': "box.size = 'nan 1 1': give three numbers",
    '<box size="inf 1 1"/>': "box.size = 'inf 1 1': give finite numbers",
    '<cylinder radius="-1" length="1"/>': "cylinder.radius = '-1': give sizes",
    '<sphere radius="1_0"/>': "sphere.radius = '1_0': give a number",
    '<sphere radius="٣"/>': "sphere.radius = '٣': give a number",
    '<mesh filename="a.obj" scale="0 0 0"/>': "mesh.scale = '0 0 0': .* one at least is not 0",
    '<mesh filename="a.obj" scale="1 1"/>': "mesh.scale = '1 1': give a number or three numbers",
    '<origin xyz="a b"/>': "origin.xyz = 'a b': give three numbers",
    '<origin rpy="0 0 1e300"/>': "origin.rpy = .*: give finite numbers",
    '<axis xyz="0 0 nan"/>': "axis.xyz = '0 0 nan': give three numbers",
    '<axis xyz="0 0 0"/>': "axis.xyz = '0 0 0': .* not 0",
    '<mass value="-1"/>': "mass.value = '-1': give a mass of at least 0, kg",
    '<inertia ixx="nan"/>': "inertia.ixx = 'nan': give a number",
    '<inertia ixx="1e-40"/>': "inertia.ixx = '1e-40': give finite numbers: 0, or 1e-30 to",
    '<color rgba="1 1 1"/>': "color.rgba = '1 1 1': give four numbers",
    '<limit velocity="inf"/>': "limit.velocity = 'inf': give a finite number, or leave it out",
    '<limit effort="much"/>': "limit.effort = 'much': give a number",
    '<d:mu_dynamic xmlns:d="http://drake.mit.edu" value="slippery"/>': "drake:mu_dynamic = 'slippery': give a number",
}
SDF = {
    "<size>0 1 1</size>": "size = '0 1 1': give sizes",
    "<pose>0 0</pose>": "pose = '0 0': give 6 numbers or 7 numbers",
    "<mass>nan</mass>": "mass = 'nan': give a number",
    "<mass>-1</mass>": "mass = '-1': give a mass",
    "<ixx>nan</ixx>": "ixx = 'nan': give a number",
    "<radius>0</radius>": "radius = '0': give sizes",
    "<d:mu_dynamic xmlns:d='drake.mit.edu'>x</d:mu_dynamic>": "drake:mu_dynamic = 'x': give a number",
}


@pytest.mark.parametrize("inside", URDF)
def test_numbers_of_urdf(inside: str) -> None:
    root = parse_xml("a.urdf", f'<robot name="r"><link name="l"><visual>{inside}</visual></link></robot>')
    with pytest.raises(InputError, match=f"a.urdf: link 'l': {URDF[inside]}"):
        check_numbers("a.urdf", root)


@pytest.mark.parametrize("inside", SDF)
def test_numbers_of_sdf(inside: str) -> None:
    root = parse_xml("a.sdf", f'<sdf version="1.7"><model name="m"><link name="l">{inside}</link></model></sdf>')
    with pytest.raises(InputError, match=f"a.sdf: model 'm': link 'l': {SDF[inside]}"):
        check_numbers("a.sdf", root)


@pytest.mark.parametrize("kind", ["fixed", "floating", "ball"])
def test_axis_of_a_joint_without_one_may_be_zero(kind: str) -> None:
    """Exporters of CAD write one for every joint."""
    joint = f'<joint name="j" type="{kind}"><axis xyz="0 0 0"/><limit lower="nan"/></joint>'
    with pytest.raises(InputError, match=r"limit\.lower = 'nan'"):
        check_numbers("a.urdf", parse_xml("a.urdf", f'<robot name="r">{joint}</robot>'))


@pytest.mark.parametrize("limit", ["1e16", "1e30", "1.79769e+308"])
def test_limits_may_be_as_good_as_infinite(limit: str) -> None:
    """Gazebo writes such numbers for joints without limits."""
    urdf = (
        f'<robot name="r"><joint name="j"><limit lower="-{limit}" upper="{limit}" velocity="{limit}"/></joint></robot>'
    )
    check_numbers("a.urdf", parse_xml("a.urdf", urdf))
    limits = f"<limit><lower>-{limit}</lower><upper>inf</upper><velocity>{limit}</velocity></limit>"
    sdf = f'<sdf version="1.7"><model name="m"><joint name="j"><axis>{limits}</axis></joint></model></sdf>'
    check_numbers("a.sdf", parse_xml("a.sdf", sdf))
