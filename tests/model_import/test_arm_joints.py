"""Joints of arms: actuators, limits, followers."""

import xml.etree.ElementTree as ET
from pathlib import Path

import numpy as np
import pytest
from pydrake.multibody.parsing import Parser
from pydrake.multibody.plant import MultibodyPlant

from soft_gripper.diagrams.loaded_model import load_model
from soft_gripper.diagrams.scene import set_home_posture
from soft_gripper.errors import InputError
from soft_gripper.files.notes import LEFT_OUT, collect_notes
from soft_gripper.model_import.forms.urdf import actuate
from soft_gripper.model_import.model_file import ModelFile
from soft_gripper.scenario.schema import ArmConfig, JointLimitsConfig, ModelConfig

FILE = Path("arm.urdf")
LIMIT = "<limit lower='-1' upper='2' velocity='3' effort='{}'/>"
SEVEN = LIMIT.format(7)
LINK = "<link name='{}'><inertial><mass value='1'/><inertia ixx='1' iyy='1' izz='1'/></inertial></link>"


def joint(name, kind="revolute", limit=SEVEN):
    """A joint from the link `base` to a link of the joint's name with an l before."""
    ends = f"<parent link='base'/><child link='l{name}'/>"
    return f"{LINK.format(f'l{name}')}<joint name='{name}' type='{kind}'>{ends}<axis xyz='0 0 1'/>{limit}</joint>"


def transmission(joints, motors, kind="transmission_interface/SimpleTransmission", inside=""):
    parts = "".join(f"<joint name='{name}'><hardwareInterface>Position</hardwareInterface></joint>" for name in joints)
    parts += "".join(f"<actuator name='{name}'>{inside}</actuator>" for name in motors)
    return f"<transmission name='t'><type>{kind}</type>{parts}</transmission>"


def robot(text):
    return ET.fromstring(f"<robot name='r' xmlns:drake='http://drake.mit.edu'>{LINK.format('base')}{text}</robot>")


def actuators(text):
    """The actuators that Drake gives a robot with these joints: name -> (joint, effort limit, gear ratio)."""
    element = robot(text)
    actuate(ModelFile(FILE, element))
    plant = MultibodyPlant(0.0)
    Parser(plant).AddModelsFromString(ET.tostring(element, encoding="unicode"), "urdf")
    plant.Finalize()
    found = [plant.get_joint_actuator(index) for index in plant.GetJointActuatorIndices()]
    return {a.name(): (a.joint().name(), a.effort_limit(), a.default_gear_ratio()) for a in found}


def test_every_movable_joint_has_an_actuator_with_its_effort_limit():
    kinds = {"a": "revolute", "b": "prismatic", "c": "continuous"}
    joints = "".join(joint(name, kind, LIMIT.format(effort)) for effort, (name, kind) in enumerate(kinds.items(), 5))
    made = actuators(joints + joint("d", "fixed", "") + joint("e", "floating", ""))
    assert sorted(made.values()) == [("a", 5, 1), ("b", 6, 1), ("c", 7, 1)]


def test_a_transmission_that_drake_understands_is_kept():
    geared = transmission(["a"], ["motor"], inside="<drake:gear_ratio value='50'/>")
    assert actuators(joint("a") + joint("b") + geared) == {"motor": ("a", 7, 50), "b_actuator": ("b", 7, 1)}


@pytest.mark.parametrize(
    "unfit",
    [
        transmission(["a"], ["motor"], "transmission_interface/DifferentialTransmission"),
        transmission(["a", "b"], ["motor"]),
        transmission(["a"], ["motor", "other"]),
        transmission(["a"], []),
        transmission(["nosuch"], ["motor"]),
        transmission(["f"], ["motor"]),
        "<transmission/>",
    ],
    ids=["other kind", "two joints", "two motors", "no motor", "no such joint", "fixed joint", "empty"],
)
def test_a_transmission_that_drake_leaves_aside_or_refuses_is_replaced(unfit, capfd):
    made = actuators(joint("a") + joint("b") + joint("f", "fixed", "") + unfit)
    assert sorted(name for name, _, _ in made.values()) == ["a", "b"]
    assert capfd.readouterr() == ("", "")


SDF_LIMIT = "<limit><lower>-1</lower><upper>2</upper><velocity>3</velocity><effort>{}</effort></limit>"
SDF = """<sdf version='1.7'><model name='r'><link name='base'/><link name='la'/><joint name='elbow' type='revolute'>
<parent>base</parent><child>la</child><axis><xyz>0 0 1</xyz>{}</axis></joint></model></sdf>"""


def limits(folder, text, **changes):
    """Lower, upper, velocity and effort limit of the joint `elbow` of an arm in a file, with a scenario's changes."""
    is_sdf = text.startswith("<sdf")
    path = folder / f"arm.{'sdf' if is_sdf else 'urdf'}"
    path.write_text(text if is_sdf else ET.tostring(robot(text), encoding="unicode"))
    plant, given = MultibodyPlant(0.0), {"elbow": JointLimitsConfig(**changes)} if changes else {}
    with collect_notes() as notes:
        load_model(plant, ModelConfig("arm", str(path)), "models[0]", ArmConfig(limits=given))
    found = plant.GetJointByName("elbow")
    efforts = [plant.get_joint_actuator(i).effort_limit() for i in plant.GetJointActuatorIndices()]
    sides = found.position_lower_limits(), found.position_upper_limits(), found.velocity_upper_limits()
    return [*(float(limit[0]) for limit in sides), *efforts], [note.element for note in notes]


def urdf(limit, kind="revolute"):
    return joint("elbow", kind, limit)


def test_limits_of_the_file(tmp_path):
    for text in (urdf(SEVEN), SDF.format(SDF_LIMIT.format(7))):
        assert limits(tmp_path, text) == ([-1, 2, 3, 7], [])
    assert limits(tmp_path, urdf("<limit upper='0.04' velocity='1' effort='1'/>", "prismatic"))[0] == [0, 0.04, 1, 1]


def test_what_a_file_leaves_open_is_unlimited_and_said(tmp_path):
    said = ["joint 'elbow': limit.effort", "joint 'elbow': limit.velocity"]
    inf = float("inf")
    for text in (urdf("", "continuous"), SDF.format("")):
        assert limits(tmp_path, text) == ([-inf, inf, inf, inf], said)


def test_limits_of_the_scenario_replace_those_of_the_file(tmp_path):
    for text in (
        urdf("<limit velocity='0' effort='0'/>"),
        urdf("", "continuous"),
        SDF.format(SDF_LIMIT.format(0)),
        SDF.format(""),
        urdf(SEVEN),
    ):
        assert limits(tmp_path, text, lower=-2, upper=1, velocity=4, effort=5) == ([-2, 1, 4, 5], [])
    assert limits(tmp_path, urdf(SEVEN), effort=5) == ([-1, 2, 3, 5], [])


@pytest.mark.parametrize(
    ("text", "complaint"),
    [
        (urdf(LIMIT.format(0)), "limit.effort = 0.0: give what the joint can do at most, in the file or in the "),
        (SDF.format(SDF_LIMIT.format(0)), "limit.effort = 0.0: give what"),
        (urdf("<limit lower='0' upper='1' velocity='0' effort='1'/>", "prismatic"), "limit.velocity = 0.0: give what"),
        (urdf("<limit lower='0' upper='0' velocity='1' effort='1'/>"), "limit.upper = 0.0: is not above limit.lower"),
        (SDF.format(SDF_LIMIT.replace("-1", "5")), "limit.upper = 2.0: must be at least limit.lower, 5"),
    ],
)
def test_limits_that_do_not(tmp_path, text, complaint):
    with pytest.raises(InputError) as caught:
        limits(tmp_path, text)
    assert f"joint 'elbow': {complaint}" in str(caught.value)
    assert "\n" not in str(caught.value)


def test_limits_of_a_scenario_that_do_not(tmp_path):
    with pytest.raises(InputError, match=r"arm\.limits\.elbow: upper = -2"):
        limits(tmp_path, urdf(SEVEN), upper=-2)
    (tmp_path / "arm.urdf").write_text(ET.tostring(robot(urdf(SEVEN)), encoding="unicode"))
    with pytest.raises(InputError, match="limits = 'knee': no such joint; known: elbow"):
        load_model(
            MultibodyPlant(0.0),
            ModelConfig("arm", str(tmp_path / "arm.urdf")),
            "models[0]",
            ArmConfig(limits={"knee": JointLimitsConfig()}),
        )


FREE = (-np.inf, np.inf)
INERTIAL = """<inertial><mass {}<inertia ixx="0.1" iyy="0.1" izz="0.1" ixy="0" ixz="0" iyz="0"/></inertial>"""
URDF_LINKS = "".join(f"<link name='{n}'>{INERTIAL.format('value=@1@/>').replace('@', chr(39))}</link>" for n in "abc")
URDF = f"""<robot name="m">{URDF_LINKS}
<joint name="lead" type="revolute"><parent link="a"/><child link="b"/><axis xyz="0 1 0"/>
<limit lower="-1" upper="1" velocity="1" effort="9"/></joint>
<joint name="level" type="revolute"><parent link="b"/><child link="c"/><axis xyz="0 1 0"/>
<limit lower="{{0}}" upper="{{1}}" velocity="{{2}}" effort="{{2}}"/>
<mimic joint="lead" multiplier="-1"/></joint></robot>"""
AXIS = """<axis><xyz>0 1 0</xyz><limit><lower>{}</lower><upper>{}</upper><velocity>{}</velocity>
<effort>{}</effort></limit>{}</axis>"""
MIMIC = "<mimic joint='lead'><multiplier>-1</multiplier><offset>0</offset><reference>0</reference></mimic>"
FOLLOWER_SDF = f"""<sdf version="1.11"><model name="m"><link name="a"/><link name="b"/><link name="c"/>
<joint name="lead" type="revolute"><parent>a</parent><child>b</child>{AXIS.format(-1, 1, 1, 9, "")}</joint>
<joint name="level" type="revolute"><parent>b</parent><child>c</child>
{AXIS.format("{0}", "{1}", "{2}", "{2}", MIMIC)}</joint></model></sdf>"""
BODY = "<body name='{}'><inertial pos='0 0 0' mass='1' diaginertia='1 1 1'/><joint name='{}' axis='0 1 0' range='{}'/>"
MJCF = f"""<mujoco model="m"><compiler angle="radian"/><worldbody>{BODY.format("b", "lead", "-1 1")}
{BODY.format("c", "level", "{0} {1}")}</body></body></worldbody>
<equality><joint joint1="level" joint2="lead" polycoef="0 -1 0 0 0"/></equality>
<actuator><motor joint="lead" gear="1" ctrlrange="-9 9"/></actuator></mujoco>"""
FORMS = {"urdf": URDF, "sdf": FOLLOWER_SDF, "xml": MJCF}


def loaded(suffix, limits=(0, 1, 1), config=None):
    """Limits of the joint that follows, the notes on limits that were left out, and the plant."""
    Path(f"m.{suffix}").write_text(FORMS[suffix].format(*limits), encoding="utf-8")
    given = {"lead": JointLimitsConfig(velocity=1, effort=9)} | ({} if config is None else {"level": config})
    plant = MultibodyPlant(0.01)
    plant.set_discrete_contact_approximation(plant.get_discrete_contact_approximation().kSap)
    arm = ArmConfig(model="arm", home=[0.1], limits=given)
    with collect_notes() as notes:
        model = load_model(plant, ModelConfig("arm", f"m.{suffix}"), "models[0]", arm)
    if suffix != "xml":
        plant.WeldFrames(plant.world_frame(), plant.GetFrameByName("a"))
    plant.Finalize()
    joint = plant.GetJointByName("level")
    ends = float(joint.position_lower_limits()[0]), float(joint.position_upper_limits()[0])
    said = [f"{note.element} {note.value} {note.why}" for note in notes if note.outcome == LEFT_OUT]
    return ends, said, plant, arm, model.mimics


@pytest.mark.parametrize("suffix", FORMS)
def test_limits_that_contradict_a_leader_are_left_out(suffix):
    ends, (note,), plant, arm, mimics = loaded(suffix)
    assert ends == FREE
    assert note.startswith("joint 'level': limits 0 to 1 it follows 'lead', which takes it from -1 to 1")
    set_home_posture(plant, arm, mimics)
    assert plant.GetJointByName("level").default_positions() == pytest.approx([-0.1])


@pytest.mark.parametrize("suffix", FORMS)
def test_a_scenario_gives_limits_of_what_follows(suffix):
    ends, said, plant, arm, mimics = loaded(suffix, config=JointLimitsConfig(lower=0.0, upper=0.5))
    assert (ends, said) == ((0.0, 0.5), [])
    with pytest.raises(InputError, match=r"level = -0.1: give .* within its limits, 0 to 0.5; it follows 'lead'"):
        set_home_posture(plant, arm, mimics)
    with pytest.raises(InputError, match=r"arm\.limits\.level: effort = 3.0: leave it out: .* follows 'lead'"):
        loaded(suffix, config=JointLimitsConfig(effort=3.0))


@pytest.mark.parametrize("suffix", FORMS)
def test_rounded_limits_hold_no_leader_at_the_end_of_its_range(suffix):
    ends, said, plant, arm, mimics = loaded(suffix, (-0.9996, 1.5, 1))
    assert (ends, said) == ((-1.0, 1.5), [])
    arm.home = [1.0]
    set_home_posture(plant, arm, mimics)
