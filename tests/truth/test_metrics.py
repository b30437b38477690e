"""True poses and errors, and the links that are touched."""

import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from pydrake.common.schema import Transform
from pydrake.math import RigidTransform, RollPitchYaw

from soft_gripper.diagrams.simulation import make_simulator, simulate
from soft_gripper.diagrams.station import make_station
from soft_gripper.fingers.finger import Finger
from soft_gripper.fingers.finger_parts import YIELDS
from soft_gripper.fingers.kinematics import as_points, forward_kinematics, in_space
from soft_gripper.fingers.plant_finger import PlantFinger
from soft_gripper.scenario.schema import ModelConfig, PressureConfig, Scenario
from soft_gripper.truth.contact import touches
from soft_gripper.truth.poses import PlantPoints, PoseError, pose_error


def test_pose_error_is_the_mean_distance_of_the_joints():
    true = np.zeros((4, 3))
    found = 1e-3 * np.array([[2.0, 3.0, 6.0], [0.0, -1.0, 0.0], [0.0, 0.0, 0.0], [0.0, 0.0, 2.0]])
    assert pose_error(true, found) == pytest.approx((7e-3 + 1e-3 + 0 + 2e-3) / 4, rel=1e-12)


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


@pytest.mark.parametrize("changes", [{"shear_factor": 0.8}, {"yields": YIELDS}], ids=["sheared", "in space"])
def test_points_are_where_the_plant_puts_its_bodies(shipped_finger, finger_plant, changes):
    """Whatever the joints on the way are: bending, sliding, across the plane."""
    changed = replace(shipped_finger, **changes)
    plant = finger_plant(changed)
    finger, context = PlantFinger(changed, plant, plant.GetModelInstanceByName("robot")), plant.CreateDefaultContext()
    state = np.random.default_rng(1).uniform(-0.4, 0.4, (5, plant.num_multibody_states()))
    found = zip(state, PlantPoints([finger])(state), finger.screws.poses(state), strict=True)
    for row, points, links_and_tip in found:
        plant.SetPositionsAndVelocities(context, row)
        frames = [finger.base.body_frame(), *finger.frames]
        poses = np.array([frame.CalcPose(context, frames[0]).GetAsMatrix34() for frame in frames])
        np.testing.assert_allclose(points, poses[1:, :, 3], atol=1e-15)
        np.testing.assert_allclose(links_and_tip, poses, atol=1e-14)


HEIGHT, RADIUS, GAP = 0.2, 0.01, 2e-4  # m, of the bases, of the peg of models/objects, between peg and finger


def hanging(name: str, x: float) -> ModelConfig:
    turned = Transform(RigidTransform(RollPitchYaw(np.pi, 0, 0), [x, 0.0, HEIGHT]))
    return ModelConfig(name=name, file="package://soft_gripper/grippers/finger.urdf", X_PC=turned)


def peg_at(finger: Finger, s: float) -> ModelConfig:
    """A peg beside the inner side of a finger that hangs at x = 0, `s` m from its base."""
    x = float(finger.section(s).inner_face) + RADIUS + GAP
    place = Transform(RigidTransform([x, 0.0, HEIGHT - s]))
    return ModelConfig(name="peg", file="package://soft_gripper/objects/peg.sdf", X_PC=place)


def pressed(finger: Finger, s: float):
    """What is recorded at last of a finger that closes softly against the peg, beside one that is free."""
    models = [hanging("obstructed", 0.0), hanging("free", -0.3), peg_at(finger, s)]
    pressure = PressureConfig(steps={"all": [15e3]}, settle=1.5, hold_samples=1)
    return simulate(Scenario(models=models, pressure=pressure)).data.isel(time=-1)


@pytest.mark.parametrize("at_joint", [False, True], ids=["beside a link", "where two links meet"])
def test_a_peg_touches_the_links_beside_it_and_nothing_else(shipped_finger: Finger, at_joint: bool) -> None:
    """The force, and its lever about the first joint, are those of the external torque there."""
    ends, link = shipped_finger.link_ends, shipped_finger.segments // 2
    s = float(ends[link + 1]) if at_joint else float(ends[link : link + 2].mean())
    last = pressed(shipped_finger, s)
    force, touching = (last["obstructed.link_contact_force"].values, [link, link + 1] if at_joint else [link])
    np.testing.assert_array_equal(np.flatnonzero(touches(force)), touching)
    torque = last["obstructed.true_external_torque"].values[0]
    assert force.sum() == pytest.approx(-torque / (s - shipped_finger.joint_arc_lengths[0]), rel=0.1)
    assert force.sum() > 0.05
    np.testing.assert_array_equal(last["free.link_contact_force"], 0)


def test_the_peg_receives_the_opposite_of_all_that_the_finger_does(shipped_finger: Finger) -> None:
    """Without gravity its weld to the world bears what is pressed on it, friction included."""
    models = [hanging("finger", 0.0), peg_at(shipped_finger, 0.08)]
    pressure = PressureConfig(steps={"all": [15e3]})
    station = make_station(Scenario(models=models, pressure=pressure, gravity=[0.0, 0.0, 0.0]))
    simulator = make_simulator(station)
    simulator.AdvanceTo(1.0)
    context = station.plant.GetMyContextFromRoot(simulator.get_context())
    (weld,) = station.plant.GetJointIndices(station.plant.GetModelInstanceByName("peg"))
    reaction = station.plant.get_reaction_forces_output_port().Eval(context)[weld].translational()
    total, across = (
        station.diagram.GetOutputPort(f"finger.{signal}").Eval(simulator.get_context())
        for signal in ("true_contact_total", "true_contact_force")
    )
    assert total == pytest.approx(np.linalg.norm(reaction), rel=1e-6)
    assert 0.05 < across <= total


def test_a_link_touches_from_the_force_on_that_the_page_says() -> None:
    page = (Path(__file__).parents[2] / "docs" / "evaluation.md").read_text()
    least = float(re.search(r"counts as touching if that is above ([0-9.]+) mN", page)[1])
    np.testing.assert_array_equal(touches(1e-3 * least * np.array([0.99, 1.01])), [False, True])
