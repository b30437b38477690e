"""The estimator `arcs` as a function: what its block puts out."""

import numpy as np
import pytest
from pydrake.math import RigidTransform, RollPitchYaw

from soft_gripper.estimators.arc_estimator import ArcPoseEstimator, ArcShape
from soft_gripper.estimators.plane import bending_plane, pose_entries
from soft_gripper.fingers.kinematics import as_planar
from soft_gripper.sensors.sensor_layout import SensorLayout, extension_ratios

GRAVITY = np.array([0.5, -1.0, -9.0])  # m/s^2
X_WB = RigidTransform(RollPitchYaw(2.0, 0.3, -0.4), [0.1, 0.2, 0.3])
DRIVING = np.linspace(0.05, 0.02, 12)  # N m


@pytest.mark.parametrize("borders", [None, (0.2, 0.5)])
def test_it_is_what_the_block_puts_out(shipped_finger, bent, borders):
    layout = SensorLayout(shipped_finger, 3, borders=borders)
    strain = layout.response.reading(extension_ratios(layout, bent(12)))
    block = ArcPoseEstimator(layout, GRAVITY)
    context = block.CreateDefaultContext()
    for name, value in (("strain", strain), ("driving_torque", DRIVING), ("X_WB", pose_entries(X_WB))):
        block.GetInputPort(name).FixValue(context, value)
    shape = ArcShape(layout)(strain, DRIVING, bending_plane(pose_entries(X_WB)).planar(GRAVITY))
    found = {name: block.GetOutputPort(name).Eval(context) for name in ("joint_positions", "tip_pose")}
    np.testing.assert_allclose(shape.q, block.GetOutputPort("estimated_joint_angles").Eval(context), atol=1e-15)
    points = shape.points(shipped_finger)
    np.testing.assert_allclose(points[:-1], as_planar(found["joint_positions"].reshape(-1, 2)), atol=1e-15)
    np.testing.assert_allclose(points[-1], as_planar(found["tip_pose"][:2]), atol=1e-15)
    assert (shape.covariance, shape.contact) == (None, None)


def test_a_batch_is_its_samples(layout, bent):
    strain = layout.response.reading(extension_ratios(layout, bent(3, 2, 12)))
    driving, gravity = 0.05 * bent(3, 2, 12), 9.81 * np.exp(1j * bent(3, 2))
    found = ArcShape(layout)(strain, driving, gravity)
    for index in np.ndindex(3, 2):
        alone = ArcShape(layout)(strain[index], driving[index], complex(gravity[index]))
        np.testing.assert_allclose(found.q[index], alone.q, atol=1e-14)
        np.testing.assert_allclose(found.curve[index], alone.curve, atol=1e-14)
