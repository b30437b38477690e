"""ShapeEstimate: where joints and tip lie, by the joint angles or by what an estimator knows better."""

import numpy as np

from soft_gripper.estimators.arcs import ArcCurve, join_arcs, joints_on_arcs
from soft_gripper.estimators.estimate import ShapeEstimate
from soft_gripper.fingers.kinematics import forward_kinematics
from soft_gripper.sensors.sensor_layout import SensorLayout


def test_points_follow_from_the_joint_angles(shipped_finger, bent):
    q = bent(3, 12)
    points = ShapeEstimate(q).points(shipped_finger)
    chain = forward_kinematics(q, shipped_finger.segment_length)
    assert points.shape == (3, 13)
    np.testing.assert_array_equal(points[:, :-1], chain.joints)
    np.testing.assert_array_equal(points[:, -1], chain.tip)


def test_a_curve_comes_before_the_joint_angles(shipped_finger, bent):
    curve = ArcCurve(SensorLayout(shipped_finger, 3), bent(4, 3), np.full((4, 3), 0.04))
    shape = ShapeEstimate(bent(4, 12), curve=curve)
    points = shape.points(shipped_finger)
    np.testing.assert_array_equal(points[:, :-1], joints_on_arcs(curve.layout, join_arcs(curve.theta, curve.length)))
    np.testing.assert_array_equal(points[:, -1], curve.arcs.end[:, -1])
    np.testing.assert_array_equal(shape.at(np.array([2, 0])).points(shipped_finger), points[[2, 0]])
