"""The estimators `arcs` and `constant_curvature` as functions."""

from dataclasses import replace

import numpy as np
import pytest
from pydrake.math import RigidTransform, RollPitchYaw

from soft_gripper.estimators.arc_shapes import ArcShape, ConstantCurvatureShape
from soft_gripper.estimators.plane import in_base, pose_entries
from soft_gripper.estimators.shape_estimator import ShapeEstimator
from soft_gripper.fingers.kinematics import as_planar, gravity_torque, in_space
from soft_gripper.fingers.statics import free_bending_angles
from soft_gripper.sensors.sensor_layout import SensorLayout, extension_ratios

GRAVITY = np.array([0.5, -1.0, -9.0])  # m/s^2
X_WB = RigidTransform(RollPitchYaw(2.0, 0.3, -0.4), [0.1, 0.2, 0.3])
DRIVING = np.linspace(0.05, 0.02, 12)  # N m


@pytest.mark.parametrize("borders", [None, (0.2, 0.5)])
def test_it_is_what_the_block_puts_out(shipped_finger, bent, borders):
    layout = SensorLayout(shipped_finger, 3, borders=borders)
    strain = layout.response.reading(extension_ratios(layout, bent(12)))
    block = ShapeEstimator(ArcShape(layout), layout, GRAVITY)
    context = block.CreateDefaultContext()
    for name, value in (("strain", strain), ("driving_torque", DRIVING), ("X_WB", pose_entries(X_WB))):
        block.GetInputPort(name).FixValue(context, value)
    shape = ArcShape(layout)(strain, DRIVING, in_base(pose_entries(X_WB), GRAVITY))
    found = {name: block.GetOutputPort(name).Eval(context) for name in ("joint_positions", "tip_pose")}
    np.testing.assert_allclose(shape.q, block.GetOutputPort("estimated_joint_angles").Eval(context), atol=1e-15)
    points = shape.points(shipped_finger)
    np.testing.assert_allclose(points[:-1], as_planar(found["joint_positions"].reshape(-1, 2)), atol=1e-15)
    np.testing.assert_allclose(points[-1], as_planar(found["tip_pose"][:2]), atol=1e-15)
    assert (shape.covariance, shape.contact) == (None, None)


def test_a_batch_is_its_samples(layout, bent):
    strain = layout.response.reading(extension_ratios(layout, bent(3, 2, 12)))
    driving, gravity = 0.05 * bent(3, 2, 12), 9.81 * np.exp(1j * bent(3, 2))
    found = ArcShape(layout)(strain, driving, in_space(gravity))
    for index in np.ndindex(3, 2):
        alone = ArcShape(layout)(strain[index], driving[index], in_space(gravity[index]))
        np.testing.assert_allclose(found.q[index], alone.q, atol=1e-14)
        np.testing.assert_allclose(found.curve.joints[index], alone.curve.joints, atol=1e-14)


def test_constant_curvature_shares_equally_on_the_curve_of_arcs(layout, bent):
    strain = layout.read(bent(5, 12))
    found, arcs = (
        make(layout)(strain, DRIVING, np.array([9.81, 0.0, 0.0])) for make in (ConstantCurvatureShape, ArcShape)
    )
    np.testing.assert_array_equal(found.curve.joints, arcs.curve.joints)
    for section in range(layout.sections):
        shared = found.q[:, layout.joint_sections == section]
        np.testing.assert_array_equal(shared, np.broadcast_to(shared[:, :1], shared.shape))
    np.testing.assert_allclose(layout.sums(found.q), arcs.curve.theta, atol=1e-14)


def test_free_bending_of_an_even_finger_is_no_torque(shipped_finger):
    """Whatever the number of sections; under a load at the joints, the torque is that load."""
    even = replace(shipped_finger, tip=shipped_finger.base)
    pressure, load = np.array([-3e4, 0.0, 8e4]), np.array([-0.02, 0.01, 0.03])[:, None]
    driving = even.pressure_torque(pressure)
    for sections in (1, 4):
        estimate = ConstantCurvatureShape(SensorLayout(even, sections))
        free = estimate(estimate.layout.read(free_bending_angles(even, pressure)), driving, np.zeros(3))
        np.testing.assert_allclose(free.external_torque, np.zeros((3, 12)), atol=1e-4)
        loaded = estimate(estimate.layout.read(even.angle(driving + load)), driving, np.zeros(3))
        np.testing.assert_allclose(loaded.external_torque, np.broadcast_to(load, (3, 12)), atol=1e-4)


def test_the_weight_is_taken_out_where_gravity_is_given(layout, bent):
    strain = layout.read(bent(12))
    with_weight, without = (
        ConstantCurvatureShape(layout)(strain, DRIVING, np.array(g)) for g in ((0.0, 0.0, 0.0), (2.0, 0.0, 9.81))
    )
    weight = gravity_torque(layout.finger, without.q, 9.81 + 2j)
    np.testing.assert_allclose(with_weight.external_torque - without.external_torque, weight, atol=1e-15)


def test_its_block_puts_out_the_torque(layout, bent):
    function = ConstantCurvatureShape(layout)
    block, strain = ShapeEstimator(function, layout, GRAVITY), layout.read(bent(12))
    context = block.CreateDefaultContext()
    for name, value in (("strain", strain), ("driving_torque", DRIVING), ("X_WB", pose_entries(X_WB))):
        block.GetInputPort(name).FixValue(context, value)
    expected = function(strain, DRIVING, in_base(pose_entries(X_WB), GRAVITY)).external_torque
    np.testing.assert_array_equal(block.GetOutputPort("external_torque").Eval(context), expected)
