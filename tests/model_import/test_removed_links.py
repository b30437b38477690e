"""Links that are left out of models."""

import xml.etree.ElementTree as ET
from pathlib import Path

import pytest
from arm_plants import GRIPPER
from arm_urdfs import ARM, LIMIT, joint, link
from pydrake.multibody.plant import MultibodyPlant
from pydrake.systems.framework import DiagramBuilder
from refusals import refused
from scenario_plants import add_scene, arm_of

from soft_gripper.diagrams.loaded_model import load_model
from soft_gripper.errors import InputError
from soft_gripper.model_import.forms.mjcf import remove_bodies
from soft_gripper.model_import.links_and_joints import remove_links
from soft_gripper.model_import.model_file import ModelFile
from soft_gripper.scenario.schema import ArmConfig, JointLimitsConfig, ModelConfig, Scenario

PATH = Path("arm.urdf")
MASS = 2.0  # kg, of every link: see INERTIAL


def transmission(name):
    kind = "<type>transmission_interface/SimpleTransmission</type>"
    return f"<transmission name='{name}_t'>{kind}<joint name='{name}'/><actuator name='{name}_m'/></transmission>"


def group(*members):
    """Links that do not touch each other."""
    inside = "".join(f"<drake:member link='{member}'/>" for member in members)
    inside += "<drake:ignored_collision_filter_group name='own'/>"
    return f"<drake:collision_filter_group name='own'>{inside}</drake:collision_filter_group>"


DRIVES = transmission("shoulder") + transmission("elbow")
SAID = (
    "<gazebo reference='fore'><mu1>0.2</mu1></gazebo><gazebo><plugin name='p'/></gazebo><frame name='f' link='fore'/>"
)
JAW_LIMIT = LIMIT.replace("-2", "0").replace("'2'", "'0.04'")
HAND = (
    joint("mount", "fore", "hand", "", "fixed")
    + link("hand")
    + joint("left", "hand", "left_jaw", JAW_LIMIT, "prismatic")
    + link("left_jaw")
    + joint("right", "hand", "right_jaw", JAW_LIMIT + "<mimic joint='left'/>", "prismatic")
    + link("right_jaw")
    + joint("glue", "left_jaw", "pad", "", "fixed")
    + link("pad")
)
SAID_OF_HAND = (
    transmission("left")
    + transmission("right")
    + "<gazebo reference='left_jaw'><mu1>0.9</mu1></gazebo><gazebo reference='mount'/>"
    + "<frame name='grasp' link='hand' xyz='0 0 0.1' rpy='0 0 0'/>"
)
ALONGSIDE = joint("side", "base", "camera", "", "fixed") + link("camera")


def urdf(*parts):
    return "<robot name='acme' xmlns:drake='http://drake.mit.edu'>" + "".join(parts) + "</robot>"


def without(text, *names):
    robot = ET.fromstring(text)
    remove_links(ModelFile(PATH, robot), names)
    return ET.tostring(robot, encoding="unicode")


WITH_HAND = urdf(
    ARM, HAND, ALONGSIDE, DRIVES, SAID, SAID_OF_HAND, group("upper", "fore", "hand", "left_jaw", "right_jaw", "pad")
)


def test_only_a_jaw():
    left = ET.fromstring(without(WITH_HAND, "right_jaw"))
    names = {tag: [e.get("name") for e in left.findall(tag)] for tag in ("link", "joint", "transmission", "frame")}
    assert names["link"] == ["base", "upper", "fore", "hand", "left_jaw", "pad", "camera"]
    assert names["joint"] == ["shoulder", "elbow", "mount", "left", "glue", "side"]
    assert names["transmission"] == ["shoulder_t", "elbow_t", "left_t"]
    assert names["frame"] == ["f", "grasp"]


@pytest.mark.parametrize(
    ("name", "complaint"),
    [
        ("gripper", "no such link; known: base, upper, fore, hand, left_jaw, right_jaw, pad, camera"),
        ("base", "hangs on nothing; only what a joint carries can be left out"),
    ],
)
@pytest.mark.parametrize("is_arm", [True, False])
def test_what_cannot_be_left_out(tmp_path, name, complaint, is_arm):
    path = tmp_path / "arm.urdf"
    path.write_text(WITH_HAND)
    config = ModelConfig("arm", str(path), without=["hand", name])
    with pytest.raises(InputError) as caught:
        load_model(MultibodyPlant(0.0), config, "models[0]", ArmConfig() if is_arm else None)
    assert str(caught.value) == f"{path}: without = '{name}': {complaint}"


def with_our_gripper(folder):
    """A scenario that takes the gripper off an arm and puts ours in its place."""
    (folder / "arm.urdf").write_text(urdf(ARM, HAND, DRIVES, SAID, SAID_OF_HAND, group("fore", "hand")))
    arm = ModelConfig("arm", str(folder / "arm.urdf"), without=["hand"])
    gripper = ModelConfig("gripper", GRIPPER, parent="arm::fore")
    return Scenario(models=[arm, gripper], arm=ArmConfig("arm", [0.3, -0.4]))


def test_another_gripper_in_its_place(tmp_path):
    scenario = with_our_gripper(tmp_path)
    scene = add_scene(DiagramBuilder(), scenario)
    arm, plant = arm_of(scenario, scene), scene.plant
    bodies = [plant.get_body(index).name() for index in plant.GetBodyIndices(arm.model)]
    assert bodies == ["base", "upper", "fore"]
    assert [finger.name for finger in scene.fingers] == ["left_finger", "right_finger"]
    assert arm.plant.num_positions() == 2
    context = plant.CreateDefaultContext()
    X_WFore, X_WPalm = (plant.GetFrameByName(name).CalcPoseInWorld(context) for name in ("fore", "palm"))
    assert X_WPalm.IsNearlyEqualTo(X_WFore, 1e-12)
    ours = plant.CalcTotalMass(context, [plant.GetModelInstanceByName("gripper")])
    assert plant.CalcTotalMass(context) == pytest.approx(3 * MASS + ours)
    assert arm.plant.CalcTotalMass(arm.plant.CreateDefaultContext()) == pytest.approx(3 * MASS + ours)


IN_SDF = """<sdf version='1.7' xmlns:drake='http://drake.mit.edu'><model name='m'><link name='base'/><link name='fore'/>
<joint name='lift' type='prismatic'><parent>base</parent><child>fore</child><axis><xyz>0 0 1</xyz></axis></joint>
<frame name='flange' attached_to='fore'/><!--
<link name='hand'/><joint name='mount' type='fixed'><parent>flange</parent><child>hand</child></joint>
<frame name='palm' attached_to='hand'/><frame name='grasp' attached_to='palm'/>
<link name='jaw'/><joint name='close' type='prismatic'><parent>palm</parent><child>jaw</child></joint>
<drake:ball_constraint><drake:ball_constraint_body_A>jaw</drake:ball_constraint_body_A>
<drake:ball_constraint_body_B>fore</drake:ball_constraint_body_B></drake:ball_constraint>
--><drake:collision_filter_group name='own'><drake:member>base</drake:member><!--<drake:member>jaw</drake:member>-->
</drake:collision_filter_group></model></sdf>"""
HAND_IN_SDF = IN_SDF.replace("<!--", "").replace("-->", "")


def links_left(text, *names):
    root = ET.fromstring(text)
    remove_links(ModelFile(PATH, root[0]), names)
    return "".join(ET.tostring(root, encoding="unicode").split())


@pytest.mark.parametrize("name", ["hand", "palm", "grasp"])
def test_a_link_of_sdformat_goes_with_all_that_hangs_on_it(name):
    assert links_left(HAND_IN_SDF, name) == links_left(IN_SDF)


def test_drake_loads_what_remains_of_nested_sdformat(tmp_path):
    inertial = "<inertial><mass>1</mass></inertial>"
    nested = f"<model name='hand'><link name='palm'>{inertial}</link></model>"
    mount = "<joint name='mount' type='fixed'><parent>fore</parent><child>hand::palm</child></joint></model>"
    path = tmp_path / "arm.sdf"
    path.write_text(IN_SDF.replace("</model>", nested + mount))
    plant = MultibodyPlant(0.01)
    load_model(plant, ModelConfig("arm", str(path), without=["hand::palm"]), "models[0]")
    assert [plant.get_body(i).name() for i in plant.GetBodyIndices(plant.GetModelInstanceByName("arm"))] == [
        "base",
        "fore",
    ]


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
