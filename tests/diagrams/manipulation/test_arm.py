"""The arm of a scenario: its home posture, and its own plant compared with that of the station."""

import numpy as np
import pytest
from arm_plants import GRIPPER, HOME, POSTURES, joint, small_arm, ur5e
from pydrake.common.schema import Transform
from pydrake.math import RigidTransform, RollPitchYaw
from pydrake.systems.framework import DiagramBuilder
from scenario_plants import add_scene, arm_of

from soft_gripper.diagrams.arm import carried_models
from soft_gripper.diagrams.scene import arm_joints
from soft_gripper.errors import InputError
from soft_gripper.fingers.finger_links import link_name
from soft_gripper.scenario.schema import ModelConfig

BALL_ARM = """<sdf version="1.7"><model name="arm"><link name="base"/><link name="flange"/>
<joint name="shoulder" type="ball"><parent>base</parent><child>flange</child></joint></model></sdf>"""
FINGER = "package://soft_gripper/grippers/finger.urdf"
GRASPED_BY = link_name("left_finger", 0)


def loaded():
    """The gripper askew on the flange, welded by the base of a finger, with a peg on its palm."""
    scenario = ur5e()
    gripper = scenario.models[1]
    gripper.child = GRASPED_BY
    gripper.X_PC = Transform(RigidTransform(RollPitchYaw(0.3, -0.5, 0.7), [0.02, -0.01, 0.05]))
    peg = ModelConfig("peg", "package://soft_gripper/objects/peg.sdf", parent="gripper::palm")
    peg.X_PC = Transform(RigidTransform([0, 0.1, 0.05]))
    scenario.models.append(peg)
    scenario.gravity = [1.0, 2.0, -9.0]
    return scenario


def built(scenario):
    scene = add_scene(DiagramBuilder(), scenario)
    return scene.plant, arm_of(scenario, scene)


@pytest.fixture(scope="module")
def both():
    """The plant of the station, and the arm of the same scenario."""
    return built(loaded())


def contexts(both, posture):
    """Of both plants, the arm in the same posture, the fingers straight."""
    plant, arm = both
    whole, alone = plant.CreateDefaultContext(), arm.plant.CreateDefaultContext()
    plant.SetPositions(whole, arm.model, posture)
    arm.plant.SetPositions(alone, posture)
    return whole, alone


def test_payload_weighs_what_is_carried(both):
    plant, arm = both
    whole, alone = contexts(both, HOME)
    indices = [i for name in ("gripper", "peg") for i in plant.GetBodyIndices(plant.GetModelInstanceByName(name))]
    bodies = [plant.get_body(index) for index in indices]
    masses = np.array([body.get_mass(whole) for body in bodies])
    centers = np.array([body.EvalPoseInWorld(whole) @ body.CalcCenterOfMassInBodyFrame(whole) for body in bodies])
    payload = arm.plant.GetBodyByName("payload")
    center = payload.EvalPoseInWorld(alone) @ payload.CalcCenterOfMassInBodyFrame(alone)
    assert payload.get_mass(alone) == pytest.approx(masses.sum(), rel=1e-12)
    np.testing.assert_allclose(center, masses @ centers / masses.sum(), atol=1e-12)


@pytest.mark.parametrize("posture", POSTURES)
def test_weight_and_inertia_are_those_of_the_whole_plant(both, posture):
    """With straight fingers; the weight of the arm and of all that hangs on it, at every joint."""
    plant, arm = both
    whole, alone = contexts(both, posture)
    of_arm = [joint.velocity_start() for joint in arm_joints(plant, arm.model)]
    weight = plant.CalcGravityGeneralizedForces(whole)[of_arm]
    np.testing.assert_allclose(arm.plant.CalcGravityGeneralizedForces(alone), weight, atol=1e-9)
    assert np.abs(weight).max() > 5
    inertia = plant.CalcMassMatrix(whole)[np.ix_(of_arm, of_arm)]
    np.testing.assert_allclose(arm.plant.CalcMassMatrix(alone), inertia, atol=1e-10)


@pytest.mark.parametrize("posture", POSTURES[1:3])
def test_tool_is_where_the_gripper_is_welded(both, posture):
    plant, arm = both
    whole, alone = contexts(both, posture)
    welded = plant.GetFrameByName(GRASPED_BY).CalcPoseInWorld(whole)
    assert arm.tool.CalcPoseInWorld(alone).IsNearlyEqualTo(welded, 1e-12)


def test_joints_stand_in_the_order_of_their_positions(tmp_path):
    """Which is that of the tree, whatever the order in the file."""
    joints = joint("revolute", "middle", "flange") + joint("prismatic", "base", "middle")
    scenario = small_arm(tmp_path, f'<link name="flange"/><link name="middle"/>{joints}', [0.25, 0.5])
    plant, arm = built(scenario)
    assert [j.name() for j in arm_joints(plant, arm.model)] == ["prismatic_to_middle", "revolute_to_flange"]
    flange = plant.GetFrameByName("flange").CalcPoseInWorld(plant.CreateDefaultContext())
    np.testing.assert_allclose(flange.translation(), [0, 0, 0.25], atol=1e-12)
    assert flange.rotation().ToAngleAxis().angle() == pytest.approx(0.5)


def test_what_is_carried_is_what_hangs_on_the_arm():
    models = [
        ModelConfig("bench", "x"),
        ModelConfig("arm", "x", parent="bench::top"),
        ModelConfig("gripper", "x", parent="arm::tool0"),
        ModelConfig("camera", "x", parent="gripper::palm"),
        ModelConfig("box", "x", parent="gripper::palm", free=True),
        ModelConfig("lamp", "x", parent="bench::top"),
    ]
    assert [model.name for model in carried_models(models, "arm")] == ["gripper", "camera"]


def changer():
    """A tool changer between flange and gripper, and a camera beside it."""
    scenario = ur5e()
    peg = "package://soft_gripper/objects/peg.sdf"
    scenario.models[1:] = [
        ModelConfig("camera", peg, parent="arm::tool0", X_PC=Transform(RigidTransform([0.3, 0, 0]))),
        ModelConfig("changer", peg, parent="arm::tool0", X_PC=Transform(RigidTransform([0, 0, 0.1]))),
        ModelConfig("gripper", GRIPPER, parent="changer::peg"),
    ]
    return scenario


def test_tool_is_what_carries_the_fingers():
    plant, arm = built(changer())
    assert arm.tool_model.name == "changer"
    welded = plant.GetFrameByName("peg", plant.GetModelInstanceByName("changer"))
    X_WTool = welded.CalcPoseInWorld(plant.CreateDefaultContext())
    context = arm.plant.CreateDefaultContext()
    arm.plant.SetPositions(context, HOME)
    assert arm.tool.CalcPoseInWorld(context).IsNearlyEqualTo(X_WTool, 1e-12)


def test_fingers_in_two_places_of_the_arm_are_refused():
    scenario = changer()
    scenario.models.append(ModelConfig("other", FINGER, parent="arm::forearm_link"))
    assert "does not carry the gripper" in complaint(scenario)


def complaint(scenario):
    with pytest.raises(InputError) as caught:
        built(scenario)
    return str(caught.value)


def test_an_arm_without_a_gripper_is_refused():
    scenario = ur5e()
    scenario.models = scenario.models[:1]
    line = complaint(scenario)
    assert "model = 'arm'" in line
    assert "does not carry the gripper; weld the gripper to it: parent: arm::..." in line


def test_a_home_for_other_joints_is_refused():
    assert "give a position for each of: shoulder_pan_joint, shoulder_lift" in complaint(ur5e([0.0] * 5))


@pytest.mark.parametrize("angle", [7.0, -7.0, np.nan])
def test_a_home_beyond_the_limits_is_refused(angle):
    line = complaint(ur5e([0, 0, 0, angle, 0, 0]))
    for part in ("home", "wrist_1_joint", str(angle), "-6.28319 to 6.28319"):
        assert part in line


def test_a_joint_of_several_degrees_of_freedom_is_refused(tmp_path):
    (tmp_path / "arm.sdf").write_text(BALL_ARM)
    scenario = ur5e([0.0] * 3)
    scenario.models[0].file = str(tmp_path / "arm.sdf")
    scenario.models[1].parent = "arm::flange"
    line = complaint(scenario)
    assert "shoulder" in line
    assert "several degrees of freedom" in line
