"""ShapeEstimate: where joints and tip lie, by the joint angles or by what an estimator knows better."""

import numpy as np

from soft_gripper.estimators.estimate import ShapeEstimate
from soft_gripper.fingers.kinematics import forward_kinematics


def test_points_follow_from_the_joint_angles(shipped_finger, bent):
    q = bent(3, 12)
    points = ShapeEstimate(q).points(shipped_finger)
    chain = forward_kinematics(q, shipped_finger.segment_length)
    assert points.shape == (3, 13)
    np.testing.assert_array_equal(points[:, :-1], chain.joints)
    np.testing.assert_array_equal(points[:, -1], chain.tip)


def test_a_curve_comes_before_the_joint_angles(shipped_finger, bent):
    curve = bent(3, 13) + 1j * bent(3, 13)
    assert ShapeEstimate(bent(3, 12), curve=curve).points(shipped_finger) is curve
