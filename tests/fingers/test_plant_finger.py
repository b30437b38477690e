"""PlantFinger: which links, joints, forces and actuators of a plant are those of one finger."""

import xml.etree.ElementTree as ET
from dataclasses import replace

import numpy as np
import pytest
from pydrake.math import RigidTransform, RollPitchYaw
from pydrake.multibody.parsing import Parser
from pydrake.multibody.plant import MultibodyPlant
from pydrake.multibody.tree import MultibodyForces, RevoluteJoint, SpatialInertia

from soft_gripper.diagrams.loaded_model import add_fingers
from soft_gripper.fingers.finger_element import FingerElement
from soft_gripper.fingers.finger_links import finger_to_urdf
from soft_gripper.fingers.finger_parts import YIELDS
from soft_gripper.fingers.plant_finger import add_torsion_springs
from soft_gripper.fingers.spatial_chain import spatial_chain
from soft_gripper.fingers.urdf import expand_urdf
from soft_gripper.models import DIRECTORY

FINGER, TWO_FINGER = DIRECTORY / "grippers/finger.urdf", DIRECTORY / "grippers/two_finger.urdf"
X_WPALM = RigidTransform(RollPitchYaw(0.3, -0.5, 1.2), [0.1, 0.2, 0.3])
POSES = [RigidTransform(RollPitchYaw(0, 0, yaw), [x, 0, 0.03]) for x, yaw in ((-0.0353, 0.0), (0.0353, np.pi))]


@pytest.fixture(scope="module")
def crowded():
    """A plant of a free body, a gripper that stands askew and another on a hinge; and the fingers of both."""
    plant = MultibodyPlant(0.01)
    inertia = SpatialInertia.SolidCubeWithDensity(1000.0, 0.1)
    plant.AddRigidBody("crate", inertia)
    wrist = plant.AddRigidBody("wrist", inertia)
    plant.AddJoint(RevoluteJoint("hinge", plant.world_frame(), wrist.body_frame(), [0, 1, 0]))
    anchored, carried = (add_fingers(Parser(plant), TWO_FINGER, name) for name in ("anchored", "carried"))
    for (finger, _), parent, X in ((anchored, plant.world_frame(), X_WPALM), (carried, wrist.body_frame(), None)):
        plant.WeldFrames(parent, plant.GetFrameByName("palm", finger.model), X or RigidTransform())
    plant.Finalize()
    return plant, anchored, carried


def test_fingers_of_two_models_have_the_model_in_their_names(crowded):
    _, anchored, carried = crowded
    assert [finger.name for finger in anchored] == ["anchored.left_finger", "anchored.right_finger"]
    assert [finger.name for finger in carried] == ["carried.left_finger", "carried.right_finger"]


def test_links_and_joints_are_those_of_its_model_from_base_to_tip(crowded):
    for finger in (*crowded[1], *crowded[2]):
        own = finger.finger.name
        assert [link.name() for link in finger.links] == [f"{own}_link_{i}" for i in range(13)]
        assert [joint.name() for joint in finger.joints] == [f"{own}_joint_{i}" for i in range(12)]
        assert {part.model_instance() for part in (*finger.links, *finger.joints)} == {finger.model}


def test_base_stands_where_the_file_and_the_weld_put_it(crowded):
    _, anchored, carried = crowded
    for finger, X_PalmB in zip(anchored, POSES, strict=True):
        assert finger.is_anchored
        assert finger.X_WB.IsNearlyEqualTo(X_WPALM @ X_PalmB, 1e-12)
    assert not any(finger.is_anchored for finger in carried)
    assert carried[1].base is not anchored[1].base


def test_position_selector_picks_the_joint_angles(crowded):
    plant, anchored, carried = crowded
    context = plant.CreateDefaultContext()
    for i, finger in enumerate((*anchored, *carried)):
        for j, joint in enumerate(finger.joints):
            joint.set_angle(context, i + j / 100)
            joint.set_angular_rate(context, 50.0)
    state = plant.GetPositionsAndVelocities(context)
    for i, finger in enumerate((*anchored, *carried)):
        np.testing.assert_array_equal(finger.position_selector() @ state, i + np.arange(12) / 100)


def test_torque_selector_picks_generalized_forces_of_the_model(crowded):
    plant, anchored, carried = crowded
    forces = np.random.default_rng(1).uniform(-1, 1, plant.num_velocities())
    for finger in (*anchored, *carried):
        expected = [forces[joint.velocity_start()] for joint in finger.joints]
        of_model = plant.GetVelocitiesFromArray(finger.model, forces)
        np.testing.assert_array_equal(finger.torque_selector() @ of_model, expected)


def test_actuator_selector_spreads_torques_over_the_joints(crowded):
    plant, anchored, carried = crowded
    torques = np.arange(1.0, 13.0)
    for finger in (*anchored, *carried):
        u = np.zeros(plant.num_actuators())
        plant.SetActuationInArray(finger.model, torques @ finger.actuator_selector(), u)
        generalized = plant.MakeActuationMatrix() @ u
        np.testing.assert_array_equal(generalized[[joint.velocity_start() for joint in finger.joints]], torques)
        assert np.count_nonzero(generalized) == 12


@pytest.fixture(scope="module")
def torsion():
    """The shipped finger with torsion springs, on the ground."""
    plant, expanded = MultibodyPlant(0.01), expand_urdf(FINGER, springs="torsion")
    (model,) = Parser(plant).AddModelsFromString(expanded.text, "urdf")
    finger = add_torsion_springs(plant, model, expanded.fingers[0])
    plant.WeldFrames(plant.world_frame(), plant.GetFrameByName("mount"))
    plant.mutable_gravity_field().set_gravity_vector([0.0, 0.0, 0.0])
    plant.Finalize()
    return finger


def elastic_torque(finger, context, q):
    """Of all force elements, N m, at joint angles `q` rad."""
    plant = finger.plant
    plant.SetPositions(context, q)
    forces = MultibodyForces(plant)
    plant.CalcForceElementsContribution(context, forces)
    return plant.CalcGeneralizedForces(context, forces)


def test_torsion_springs_are_linear_at_any_angle(torsion, bent):
    q = 5 * bent(12)  # up to 2 rad a joint
    torque = elastic_torque(torsion, torsion.plant.CreateDefaultContext(), q)
    np.testing.assert_allclose(torque, -torsion.finger.elastic_torque(q), rtol=1e-14)


def test_a_finger_in_space_has_torsion_springs_in_every_way_that_it_turns(shipped_finger, bent):
    finger, plant = replace(shipped_finger, segments=4, yields=YIELDS), MultibodyPlant(0.01)
    robot = ET.Element("robot", name="robot")
    robot.extend(finger_to_urdf(FingerElement(finger, "world"), springs="torsion"))
    (model,) = Parser(plant).AddModelsFromString(ET.tostring(robot, encoding="unicode"), "urdf")
    found = add_torsion_springs(plant, model, finger)
    plant.mutable_gravity_field().set_gravity_vector([0.0, 0.0, 0.0])
    plant.Finalize()
    chain = spatial_chain(finger)
    q, stiffness = np.where(chain.turns, 5.0, 0.01) * bent(16), chain.interleaved(finger.stiffnesses)
    torque = elastic_torque(found, plant.CreateDefaultContext(), q)
    np.testing.assert_allclose(torque, -stiffness * q, rtol=1e-9)
    assert len(found.torsion_springs) == 3 * 4
    assert [spring.joint() for spring in found.torsion_springs[:4]] == found.joints


def test_stiffness_of_torsion_springs_is_a_parameter_of_the_context(torsion, bent):
    q, contexts = bent(12), [torsion.plant.CreateDefaultContext() for _ in range(2)]
    for spring, stiffness in zip(torsion.torsion_springs, torsion.finger.stiffness, strict=True):
        spring.SetStiffness(contexts[0], 1.1 * stiffness)
    stiffer, unchanged = (elastic_torque(torsion, context, q) for context in contexts)
    np.testing.assert_allclose(stiffer, 1.1 * unchanged, rtol=1e-14)
