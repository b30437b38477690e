"""Where the plant has a finger, and pose and fingertip errors: the paper's metric, and the blocks that compute it."""

import copy
import xml.etree.ElementTree as ET
from dataclasses import replace

import numpy as np
import pytest
from pydrake.math import RigidTransform, RollPitchYaw
from pydrake.multibody.parsing import Parser
from pydrake.multibody.plant import AddMultibodyPlantSceneGraph, MultibodyPlant
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import DiagramBuilder
from pydrake.systems.primitives import ConstantVectorSource

from soft_gripper.diagrams.recording import add_logs, read_logs
from soft_gripper.diagrams.wiring.drive import add_pressure_drive
from soft_gripper.diagrams.wiring.sensing import add_sensing
from soft_gripper.fingers.finger_parts import YIELDS
from soft_gripper.fingers.kinematics import as_points, forward_kinematics, in_space
from soft_gripper.fingers.plant_finger import PlantFinger
from soft_gripper.fingers.urdf import expand_urdf
from soft_gripper.models import DIRECTORY
from soft_gripper.truth.poses import PlantPoints, PoseError, TruePoses, fingertip_error, pose_error


def test_pose_error_is_the_mean_distance_of_the_joints():
    true = np.zeros((4, 3))
    found = 1e-3 * np.array([[2.0, 3.0, 6.0], [0.0, -1.0, 0.0], [0.0, 0.0, 0.0], [0.0, 0.0, 2.0]])
    assert pose_error(true, found) == pytest.approx((7e-3 + 1e-3 + 0 + 2e-3) / 4, rel=1e-12)


def test_fingertip_error_is_a_distance():
    assert fingertip_error(np.ones(3), np.array([1.002, 1.003, 0.994])) == pytest.approx(7e-3, rel=1e-12)


def test_batch_is_the_loop(bent):
    true, found = bent(2, 3, 12, 3), in_space(bent(2, 3, 12) + 0j)
    for index in np.ndindex(2, 3):
        assert pose_error(true, found)[index] == pose_error(true[index], found[index])


def evaluate(true_joints, true_tip, joints, tip):
    block = PoseError(len(true_joints))
    context = block.CreateDefaultContext()
    inputs = {"true_joint_positions": true_joints.ravel(), "true_tip_position": true_tip}
    inputs |= {"joint_positions": as_points(joints).ravel(), "tip_pose": [*as_points(tip), 0.0]}
    for name, value in inputs.items():
        block.GetInputPort(name).FixValue(context, value)
    return [block.GetOutputPort(name).Eval(context)[0] for name in ("pose_error", "fingertip_error")]


def test_block_compares_the_estimate_in_its_plane_with_the_truth_in_space(bent):
    chain = forward_kinematics(bent(12), 0.01)
    joints, tip = in_space(chain.joints), in_space(chain.tip)
    assert evaluate(joints, tip, chain.joints, chain.tip) == [0.0, 0.0]
    aside = np.array([2e-3, 3e-3, 6e-3])  # y too
    np.testing.assert_allclose(evaluate(joints + aside, tip - 2 * aside, chain.joints, chain.tip), [7e-3, 14e-3])


def test_an_unknown_pose_has_no_error():
    assert np.isnan(evaluate(np.zeros((12, 3)), np.zeros(3), np.full(12, np.nan + 0j), np.array(np.nan + 0j))).all()


def test_true_places_are_those_of_the_chain(tapered_finger, finger_plant, bent):
    plant, q = finger_plant(tapered_finger), bent(4, 3, 5)
    finger = PlantFinger(tapered_finger, plant, plant.GetModelInstanceByName("robot"))
    places = PlantPoints([finger])(np.concatenate([q, np.zeros_like(q)], axis=-1))
    np.testing.assert_allclose(
        places, in_space(forward_kinematics(q, tapered_finger.segment_length).points), atol=1e-15
    )
    assert not PlantPoints([finger])(np.zeros(10))[:, :2].any()
    block = TruePoses([finger])
    context = block.CreateDefaultContext()
    block.get_input_port().FixValue(context, np.concatenate([q[0, 0], np.zeros(5)]))
    names = ("tapered.true_joint_positions", "tapered.true_tip_position")
    joints, tip = (block.GetOutputPort(name).Eval(context) for name in names)
    np.testing.assert_array_equal(joints, places[0, 0, :-1].ravel())
    np.testing.assert_array_equal(tip, places[0, 0, -1])


HINGE, ANGLE = 6, 0.15  # the bending joint that a joint about x is put before, and its angle, rad


def hinged_finger(plant):
    """The shipped finger with one joint more, which turns what is beyond it out of the bending plane and stays so."""
    expanded = expand_urdf(DIRECTORY / "grippers/finger.urdf")
    robot = ET.fromstring(expanded.text)
    joint = next(joint for joint in robot.findall("joint") if joint.get("name") == f"finger_joint_{HINGE}")
    hinge = ET.SubElement(robot, "joint", name="sideways", type="revolute")
    hinge.extend([ET.Element("parent", link=f"finger_link_{HINGE}"), ET.Element("child", link="between")])
    hinge.extend([copy.deepcopy(joint.find("origin")), ET.Element("axis", xyz="1 0 0")])
    ET.SubElement(hinge, "dynamics", damping="1e3")
    joint.find("parent").set("link", "between")
    joint.find("origin").set("xyz", "0 0 0")
    inertial = ET.SubElement(ET.SubElement(robot, "link", name="between"), "inertial")
    ET.SubElement(inertial, "mass", value="1e-6")
    ET.SubElement(inertial, "inertia", ixx="1e-10", iyy="1e-10", izz="1e-10", ixy="0", ixz="0", iyz="0")
    (model,) = Parser(plant).AddModelsFromString(ET.tostring(robot, encoding="unicode"), "urdf")
    plant.GetJointByName("sideways").set_default_angle(ANGLE)
    return PlantFinger(expanded.fingers[0], plant, model)


def test_points_are_where_the_plant_puts_its_bodies(shipped_finger, finger_plant):
    """Whatever the joints on the way are: bending, sliding, one across the plane, with a base that rests or moves."""
    sheared, hinged = replace(shipped_finger, shear_factor=0.8), MultibodyPlant(0.0)
    plant = finger_plant(sheared)
    spatial = replace(shipped_finger, yields=YIELDS)
    in_space = finger_plant(spatial)
    fingers = [PlantFinger(sheared, plant, plant.GetModelInstanceByName("robot")), hinged_finger(hinged)]
    fingers.append(PlantFinger(spatial, in_space, in_space.GetModelInstanceByName("robot")))
    hinged.Finalize()
    for finger in fingers:
        context = finger.plant.CreateDefaultContext()
        state = np.random.default_rng(1).uniform(-0.4, 0.4, (5, finger.plant.num_multibody_states()))
        for row, points in zip(state, PlantPoints([finger])(state), strict=True):
            finger.plant.SetPositionsAndVelocities(context, row)
            poses = [frame.CalcPose(context, finger.base.body_frame()) for frame in finger.frames]
            np.testing.assert_allclose(points, [pose.translation() for pose in poses], atol=1e-15)


def test_what_bends_out_of_the_plane_is_an_error_of_the_pose():
    """A straight finger whose outer part stands sideways: sensors and estimator know nothing of it, the truth does."""
    builder = DiagramBuilder()
    plant, _ = AddMultibodyPlantSceneGraph(builder, time_step=0.005)
    plant.mutable_gravity_field().set_gravity_vector(np.zeros(3))
    finger = hinged_finger(plant)
    mounted = RigidTransform(RollPitchYaw(0.3, 2, 1), [1, 2, 3])
    plant.WeldFrames(plant.world_frame(), plant.GetFrameByName("mount"), mounted)
    plant.Finalize()
    drive = add_pressure_drive(builder, [finger])
    signals = add_sensing(builder, [finger], drive.pressures)
    builder.Connect(builder.AddSystem(ConstantVectorSource([0.0])).get_output_port(), drive.commands["finger"])
    logs = add_logs(builder, signals, period=0.005)
    simulator = Simulator(builder.Build())
    simulator.AdvanceTo(0.05)
    recording = read_logs(logs, simulator.get_context())

    arms = np.maximum(np.arange(12) - HINGE, 0) * 0.01
    moved = {"pose_error": arms.mean(), "fingertip_error": 0.12 - (HINGE + 0.5) * 0.01}
    for name, arm in moved.items():
        error = recording[f"finger.{name}"].values[-1].item()
        assert error == pytest.approx(2 * arm * np.sin(ANGLE / 2), rel=1e-3)
    assert recording["finger.fingertip_error"].values[-1] > 8e-3
    tip = np.array([0, -np.sin(ANGLE), np.cos(ANGLE)]) * 0.055 + [0, 0, 0.065]
    np.testing.assert_allclose(recording["finger.true_tip_position"].values[-1], tip, atol=1e-5)
    np.testing.assert_allclose(recording["finger.tip_pose"].values[-1], [0, 0.12, 0], atol=1e-5)
