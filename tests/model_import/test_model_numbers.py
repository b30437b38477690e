"""Numbers of model files that Drake would not survive, or take for something else, are refused by name."""

import pytest

from soft_gripper.errors import InputError
from soft_gripper.files.xml_text import parse_xml
from soft_gripper.model_import.model_numbers import check_numbers

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
