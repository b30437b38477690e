"""Pose and fingertip errors: the paper's metric, and the block that computes it."""

from dataclasses import replace

import numpy as np
import pytest

from soft_gripper.fingers.kinematics import as_points, forward_kinematics
from soft_gripper.truth.poses import PoseError, fingertip_error, pose_error


def test_pose_error_is_the_mean_distance_of_the_joints():
    true = np.array([0.0, 1.0, 2.0 + 1.0j, 3.0])
    found = true + np.array([0.0, 3e-3 + 4e-3j, -1e-3, 2e-3j])
    assert pose_error(true, found) == pytest.approx((0 + 5e-3 + 1e-3 + 2e-3) / 4, rel=1e-12)


def test_fingertip_error_is_a_distance():
    assert fingertip_error(np.array(1.0 + 1.0j), np.array(1.003 + 0.996j)) == pytest.approx(5e-3, rel=1e-12)


def test_batch_is_the_loop(bent):
    true, found = bent(2, 3, 12) + 0j, 1j * bent(2, 3, 12)
    for index in np.ndindex(2, 3):
        assert pose_error(true, found)[index] == pose_error(true[index], found[index])


def evaluate(finger, q, joints, tip, **shear):
    block = PoseError(finger)
    context = block.CreateDefaultContext()
    inputs = {"sampled_joint_angles": q, "joint_positions": as_points(joints).ravel(), "tip_pose": tip, **shear}
    for name, value in inputs.items():
        block.GetInputPort(name).FixValue(context, value)
    return [block.GetOutputPort(name).Eval(context)[0] for name in ("pose_error", "fingertip_error")]


def test_block_holds_the_estimate_against_the_chain(shipped_finger, bent):
    q = bent(12)
    chain = forward_kinematics(q, shipped_finger.segment_length)
    x, z = as_points(chain.tip)
    assert evaluate(shipped_finger, q, chain.joints, [x, z, 0.0]) == [0.0, 0.0]
    errors = evaluate(shipped_finger, q, chain.joints + 3e-3 + 4e-3j, [x + 6e-3, z - 8e-3, 0.0])
    np.testing.assert_allclose(errors, [5e-3, 10e-3], rtol=1e-12)


def test_the_truth_shears(shipped_finger, bent):
    finger, q, shear = replace(shipped_finger, shear_factor=0.857), bent(12), 0.01 * bent(12)
    chain = forward_kinematics(q, finger.segment_length, shear)
    tip = [*as_points(chain.tip), 0.0]
    assert evaluate(finger, q, chain.joints, tip, sampled_shear=shear) == [0.0, 0.0]
    assert evaluate(finger, q, chain.joints + 3e-3, tip, sampled_shear=shear)[0] == pytest.approx(3e-3, rel=1e-9)


def test_an_unknown_pose_has_no_error(shipped_finger):
    unknown = np.full(12, np.nan + 0j)
    assert np.isnan(evaluate(shipped_finger, np.zeros(12), unknown, np.full(3, np.nan))).all()
