"""Where the plant has a finger, and pose and fingertip errors: the paper's metric, and the blocks that compute it."""

from dataclasses import replace

import numpy as np
import pytest

from soft_gripper.fingers.finger_parts import YIELDS
from soft_gripper.fingers.kinematics import as_points, forward_kinematics, in_space
from soft_gripper.fingers.plant_finger import PlantFinger
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
