"""Joints of third-party URDF files: one actuator each, with the limits of the file, or a message that names them."""

import xml.etree.ElementTree as ET
from pathlib import Path

import pytest
from pydrake.multibody.parsing import Parser
from pydrake.multibody.plant import MultibodyPlant

from soft_gripper.diagrams.loaded_model import load_model
from soft_gripper.errors import InputError
from soft_gripper.files.notes import collect_notes
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
