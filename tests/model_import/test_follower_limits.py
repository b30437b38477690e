"""Limits of joints that follow others: left out where they contradict, given by a scenario, or refused by name."""

from pathlib import Path

import numpy as np
import pytest
from pydrake.multibody.plant import MultibodyPlant

from soft_gripper.diagrams.loaded_model import load_model
from soft_gripper.diagrams.scene import set_home_posture
from soft_gripper.errors import InputError
from soft_gripper.files.notes import LEFT_OUT, collect_notes
from soft_gripper.scenario.schema import ArmConfig, JointLimitsConfig, ModelConfig

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
SDF = f"""<sdf version="1.11"><model name="m"><link name="a"/><link name="b"/><link name="c"/>
<joint name="lead" type="revolute"><parent>a</parent><child>b</child>{AXIS.format(-1, 1, 1, 9, "")}</joint>
<joint name="level" type="revolute"><parent>b</parent><child>c</child>
{AXIS.format("{0}", "{1}", "{2}", "{2}", MIMIC)}</joint></model></sdf>"""
BODY = "<body name='{}'><inertial pos='0 0 0' mass='1' diaginertia='1 1 1'/><joint name='{}' axis='0 1 0' range='{}'/>"
MJCF = f"""<mujoco model="m"><compiler angle="radian"/><worldbody>{BODY.format("b", "lead", "-1 1")}
{BODY.format("c", "level", "{0} {1}")}</body></body></worldbody>
<equality><joint joint1="level" joint2="lead" polycoef="0 -1 0 0 0"/></equality>
<actuator><motor joint="lead" gear="1" ctrlrange="-9 9"/></actuator></mujoco>"""
FORMS = {"urdf": URDF, "sdf": SDF, "xml": MJCF}


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
