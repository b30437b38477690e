"""The estimators `arcs` and `constant_curvature` as functions."""

from dataclasses import replace

import numpy as np

from soft_gripper.estimators.arc_shapes import ArcShape, ConstantCurvatureShape
from soft_gripper.fingers.statics import free_bending_angles
from soft_gripper.sensors.sensor_layout import SensorLayout

DRIVING = np.linspace(0.05, 0.02, 12)  # N m


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
