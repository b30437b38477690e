"""Links are left out of files of all formats alike, with everything that refers to them."""

import xml.etree.ElementTree as ET
from pathlib import Path

import pytest
from pydrake.multibody.plant import MultibodyPlant
from refusals import refused

from soft_gripper.diagrams.loaded_model import load_model
from soft_gripper.model_import.forms.mjcf import remove_bodies
from soft_gripper.model_import.model_file import ModelFile
from soft_gripper.scenario.schema import ArmConfig, JointLimitsConfig, ModelConfig

INERTIAL = "<inertial pos='0 0 0' mass='1' diaginertia='1 1 1'/>"
MJCF = f"""<mujoco model="m"><worldbody><body name="base">{INERTIAL}<geom name="foot" size="0.1"/>
<body name="hand">{INERTIAL}<joint name="wrist" type="hinge"/><site name="tool"/>
<frame><body name="jaw">{INERTIAL}<joint name="grip"/><geom name="pad" size="0.01"/><site name="tip"/>
<body name="nail">{INERTIAL}<joint name="bend"/></body></body></frame>
<body name="other">{INERTIAL}<joint name="slide" type="slide"/></body>
</body></body></worldbody>
<tendon><fixed name="both"><joint joint="grip" coef="1"/><joint joint="wrist" coef="1"/></fixed>
<fixed name="own"><joint joint="wrist" coef="1"/></fixed></tendon>
<actuator><motor name="m1" joint="wrist" ctrlrange="-9 9"/><motor name="m2" joint="grip"/>
<motor name="m3" tendon="both"/><position name="m4" site="tool" refsite="tip"/></actuator>
<equality><joint joint1="grip" joint2="wrist"/><joint joint1="slide" joint2="wrist"/><weld body1="nail"/></equality>
<contact><exclude body1="base" body2="nail"/><exclude body1="base" body2="hand"/>
<pair geom1="pad" geom2="foot"/></contact>
<sensor><jointpos joint="bend"/><jointpos joint="wrist"/><actuatorfrc actuator="m3"/><tendonpos tendon="both"/>
<framepos objtype="site" objname="tip"/><framepos objtype="xbody" objname="hand" reftype="body" refname="jaw"/>
<framepos objtype="xbody" objname="hand"/></sensor>
<keyframe><key qpos="0 0 0 0"/></keyframe></mujoco>"""

SDF_JOINT = """<joint name="{0}" type="revolute"><parent>{1}</parent><child>{2}</child><axis><xyz>0 1 0</xyz>
<limit><lower>-1</lower><upper>1</upper><velocity>1</velocity><effort>9</effort></limit>{3}</axis></joint>"""
SDF_MIMIC = "<mimic joint='grip'><multiplier>1</multiplier><offset>0</offset><reference>0</reference></mimic>"
SDF_LINKS = "".join(f"<link name='{name}'/>" for name in ("base", "hand", "jaw", "nail", "other"))
SDF = f"""<sdf version="1.11"><model name="m">{SDF_LINKS}{SDF_JOINT.format("wrist", "base", "hand", "")}
{SDF_JOINT.format("grip", "hand", "jaw", "")}{SDF_JOINT.format("bend", "jaw", "nail", "")}
{SDF_JOINT.format("slide", "hand", "other", SDF_MIMIC)}<frame name="tip" attached_to="jaw"/></model></sdf>"""
URDF_LINKS = "".join(
    f"<link name='{name}'><inertial><mass value='1'/><inertia ixx='1' iyy='1' izz='1'/></inertial></link>"
    for name in ("base", "hand", "jaw", "nail", "other")
)
URDF_JOINT = """<joint name="{0}" type="revolute"><parent link="{1}"/><child link="{2}"/><axis xyz="0 1 0"/>
<limit lower="-1" upper="1" velocity="1" effort="9"/>{3}</joint>"""
URDF = f"""<robot name="m">{URDF_LINKS}{URDF_JOINT.format("wrist", "base", "hand", "")}
{URDF_JOINT.format("grip", "hand", "jaw", "")}{URDF_JOINT.format("bend", "jaw", "nail", "")}
{URDF_JOINT.format("slide", "hand", "other", '<mimic joint="grip"/>')}</robot>"""
FORMS = {"urdf": URDF, "sdf": SDF, "xml": MJCF}


def loaded(suffix, *without):
    Path(f"m.{suffix}").write_text(FORMS[suffix], encoding="utf-8")
    plant = MultibodyPlant(0.01)
    plant.set_discrete_contact_approximation(plant.get_discrete_contact_approximation().kSap)
    limit = JointLimitsConfig(lower=-1, upper=1, velocity=1, effort=9)
    arm = ArmConfig(limits={"wrist": limit} | ({} if suffix == "xml" else {"slide": limit}))
    model = load_model(plant, ModelConfig("arm", f"m.{suffix}", without=list(without)), "models[0]", arm).model
    bodies = {plant.get_body(index).name() for index in plant.GetBodyIndices(model)}
    return bodies, {plant.get_joint(index).name() for index in plant.GetJointIndices(model)}


@pytest.mark.parametrize("suffix", FORMS)
def test_links_and_what_hangs_on_them_are_left_out(suffix):
    bodies, joints = loaded(suffix, "jaw")
    assert bodies == {"base", "hand", "other"}
    assert {"wrist", "slide"} <= joints
    assert not joints & {"grip", "bend"}


def test_what_refers_to_bodies_of_mjcf_is_left_out():
    root = ET.fromstring(MJCF)
    remove_bodies(ModelFile(Path("m.xml"), root), ["jaw", "nail"])
    sections = {tag: [dict(element.attrib) for element in root.find(tag)] for tag in ("tendon", "actuator", "equality")}
    assert [tendon["name"] for tendon in sections["tendon"]] == ["own"]
    assert [actuator["name"] for actuator in sections["actuator"]] == ["m1"]
    assert sections["equality"] == [{"joint1": "slide", "joint2": "wrist"}]
    assert [element.attrib for element in root.find("contact")] == [{"body1": "base", "body2": "hand"}]
    sensors = [element.attrib for element in root.find("sensor")]
    assert sensors == [{"joint": "wrist"}, {"objtype": "xbody", "objname": "hand"}]
    assert root.find("keyframe") is None


def test_meshes_that_only_a_left_out_body_has_need_not_be_there(monkeypatch):
    """Those of other bodies must."""
    asset = '<asset><mesh name="claw" file="nosuch.stl"/><mesh file="nosuch_too.stl"/></asset>'
    geom = '<geom type="mesh" mesh="claw"/><geom type="mesh" mesh="nosuch_too"/><geom name="pad"'
    text = MJCF.replace("<worldbody>", f"{asset}<worldbody>").replace('<geom name="pad"', geom)
    monkeypatch.setitem(FORMS, "xml", text)
    assert loaded("xml", "jaw")[0] == {"base", "hand", "other"}
    with refused("mesh", "nosuch.stl"):
        loaded("xml", "nail")
