"""Models in other units than m, kg and rad: meshes are refused by their size, other quantities noted."""

from pathlib import Path

import pytest
import trimesh
from pydrake.multibody.plant import AddMultibodyPlantSceneGraph
from pydrake.systems.framework import DiagramBuilder
from refusals import refused

from soft_gripper.diagrams.loaded_model import load_model
from soft_gripper.files.notes import collect_notes
from soft_gripper.models import DIRECTORY
from soft_gripper.scenario.schema import ArmConfig, ModelConfig


@pytest.fixture(autouse=True)
def _files(cache):
    for suffix in ("stl", "obj"):
        trimesh.creation.box([300.0, 50.0, 40.0]).export(f"link_mm.{suffix}")


def noted(text, suffix, is_arm=False, **config):
    """The notes on a model: elements, values and reasons."""
    path = Path(f"m.{suffix}")
    path.write_text(text, encoding="utf-8")
    plant, _ = AddMultibodyPlantSceneGraph(DiagramBuilder(), 0.01)
    with collect_notes() as notes:
        load_model(plant, ModelConfig("m", str(path), **config), "models[0]", ArmConfig() if is_arm else None)
    return [(note.element, note.value, note.why) for note in notes]


def urdf(kind="collision", scale="1 1 1", mass=1.0, friction=0.5, suffix="stl"):
    inertia = f"<inertia ixx='{0.01 * mass}' iyy='{0.01 * mass}' izz='{0.01 * mass}' ixy='0' ixz='0' iyz='0'/>"
    material = f"<drake:proximity_properties><drake:mu_static value='{friction}'/></drake:proximity_properties>"
    return f"""<robot name='m' xmlns:drake='http://drake.mit.edu'><link name='base'><inertial><mass value='{mass}'/>
    {inertia}</inertial><{kind}><geometry><mesh filename='link_mm.{suffix}' scale='{scale}'/></geometry>
    {material if kind == "collision" else ""}</{kind}></link></robot>"""


def sdf(kind="collision", scale="1 1 1"):
    return f"""<sdf version='1.7'><model name='m'><link name='base'><{kind} name='c'><geometry><mesh>
    <uri>link_mm.obj</uri><scale>{scale}</scale></mesh></geometry></{kind}></link></model></sdf>"""


def mjcf(kind="collision", scale="1 1 1"):
    bits = 1 if kind == "collision" else 0
    return f"""<mujoco model='m'><asset><mesh name='a' file='link_mm.stl' scale='{scale}'/></asset><worldbody>
    <body name='base'><inertial pos='0 0 0' mass='1' diaginertia='1 1 1'/>
    <geom type='mesh' mesh='a' contype='{bits}' conaffinity='{bits}'/></body></worldbody></mujoco>"""


FORMS = {"urdf": urdf, "sdf": sdf, "xml": mjcf}


@pytest.mark.parametrize("suffix", FORMS)
@pytest.mark.parametrize("kind", ["visual", "collision"])
def test_meshes_in_millimetres_are_refused(suffix, kind):
    for choices in ({"is_arm": True}, {"free": True}, {"parent": "other::link"}):
        with refused("mesh.scale", "1 1 1") as caught:
            noted(FORMS[suffix](kind), suffix, **choices)
        assert "link 'base'" in str(caught.value)
        assert "makes the link 300 m large; is the file in millimetres?" in str(caught.value)
    assert noted(FORMS[suffix](kind, "0.001 0.001 0.001"), suffix, is_arm=True) == []


@pytest.mark.parametrize("suffix", FORMS)
def test_what_stands_in_the_world_may_be_large(suffix):
    ((element, scale, why),) = noted(FORMS[suffix](), suffix)
    assert (element, scale) == ("link 'base': mesh.scale", "1 1 1")
    assert "is the file in millimetres?" in why


def test_an_object_larger_than_a_gripper_is_noted():
    ((element, _, why),) = noted(urdf(scale="0.005 0.005 0.005"), "urdf", free=True)
    assert element == "link 'base': mesh.scale"
    assert "makes the link 1.5 m large" in why
    assert noted(urdf(scale="0.005 0.005 0.005"), "urdf") == []


@pytest.mark.parametrize(
    ("config", "text", "expected"),
    [
        ({"mass": 50.0}, {}, ("mass", "50 kg", "is it in grams?")),
        ({}, {"mass": 50.0}, ("mass", "50 kg", "is it in grams?")),
        ({"friction": 60.0}, {}, ("link 'base': friction", "60")),
        ({}, {"friction": 60.0}, ("link 'base': friction", "60")),
    ],
)
def test_masses_and_frictions_that_are_hardly_meant_are_noted(config, text, expected):
    ((*said,),) = noted(urdf(scale="0.001 0.001 0.001", **text), "urdf", free=True, **config)
    assert tuple(said[: len(expected)]) == expected


def test_a_finger_in_millimetres_is_noted():
    text = (DIRECTORY / "grippers" / "finger.urdf").read_text(encoding="utf-8")
    assert 'length="0.12"' in text
    elements = [element for element, *_ in noted(text.replace('length="0.12"', 'length="110"'), "urdf")]
    assert elements == ["finger 'm': length"]


LINK = "<link name='{}'><inertial><mass value='1'/><inertia ixx='1' iyy='1' izz='1'/></inertial></link>"
JOINT = "<joint name='j' type='{}'><parent link='a'/><child link='b'/><axis xyz='0 0 1'/>{}</joint>"
HINGE = """<mujoco model='m'><compiler angle='radian'/><worldbody><body name='a'><joint name='j' range='-{0} {0}'/>
<inertial pos='0 0 0' mass='1' diaginertia='1 1 1'/></body></worldbody></mujoco>"""
HINGE_IN_SDF = """<sdf version='1.7'><model name='m'><link name='a'/><link name='b'/><joint name='j' type='revolute'>
<parent>a</parent><child>b</child><axis><xyz>0 0 1</xyz><limit><lower>-{0}</lower><upper>{0}</upper></limit></axis>
</joint></model></sdf>"""
LIMIT = "<limit lower='-{0}' upper='{0}' velocity='1' effort='1'/>"
HINGES = {
    "urdf": f"<robot name='m'>{LINK.format('a')}{LINK.format('b')}{JOINT.format('revolute', LIMIT)}</robot>",
    "sdf": HINGE_IN_SDF,
    "xml": HINGE,
}


@pytest.mark.parametrize("suffix", HINGES)
@pytest.mark.parametrize(("angle", "is_noted"), [(180, True), (6.28, False), (1e16, False)])
def test_limits_of_several_turns_are_noted(suffix, angle, is_noted):
    said = [each for each in noted(HINGES[suffix].format(angle), suffix) if each[0] == "joint 'j': limits"]
    expected = ("joint 'j': limits", "-180 to 180 rad", "up to 28.6 turns; are they in degrees?")
    assert said == ([expected] if is_noted else [])
