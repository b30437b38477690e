"""FingerShape: the pose of the chain as a block, with the ports that an estimator of its own pose has."""

import numpy as np
from pydrake.math import RigidTransform, RollPitchYaw

from soft_gripper.estimators.finger_shape import FingerShape
from soft_gripper.estimators.plane import pose_entries
from soft_gripper.fingers.kinematics import as_points, forward_kinematics

X_WB = RigidTransform(RollPitchYaw(0.3, -1.1, 2.0), [0.1, -0.2, 0.3])


def shape_of(finger, q):
    """All outputs of the block, {port: value}."""
    block = FingerShape(finger)
    context = block.CreateDefaultContext()
    block.GetInputPort("estimated_joint_angles").FixValue(context, q)
    block.GetInputPort("X_WB").FixValue(context, pose_entries(X_WB))
    ports = [block.get_output_port(i) for i in range(block.num_output_ports())]
    return {port.get_name(): port.Eval(context) for port in ports}


def test_points_are_those_of_the_chain(tapered_finger, bent):
    for q in bent(10, 5):
        outputs, chain = shape_of(tapered_finger, q), forward_kinematics(q, tapered_finger.segment_length)
        np.testing.assert_allclose(outputs["joint_positions"].reshape(5, 2), as_points(chain.joints), atol=1e-16)
        np.testing.assert_allclose(outputs["tip_pose"], [*as_points(chain.tip), q.sum()], atol=1e-15)
        world = [X_WB @ np.array([x, 0.0, z]) for x, z in as_points(chain.joints)]
        np.testing.assert_allclose(outputs["joint_positions_world"].reshape(5, 3), world, atol=1e-15)


def test_arcs_bend_as_the_joints_do_one_for_every_segment(tapered_finger, bent):
    q, length = bent(5), tapered_finger.segment_length
    x, z, heading, kappa, lengths, center_x, center_z = shape_of(tapered_finger, q)["arcs"].reshape(5, 7).T
    np.testing.assert_allclose(kappa * length, q, rtol=1e-14)
    np.testing.assert_allclose(heading, np.cumsum(q) - q, atol=1e-15)
    np.testing.assert_array_equal(lengths, length)
    np.testing.assert_allclose(np.hypot(center_x - x, center_z - z), np.abs(1 / kappa), rtol=1e-12)
    assert (x[0], z[0]) == (0.0, 0.0)
