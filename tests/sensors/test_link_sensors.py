"""Sensors of curvature and of orientation: what they read in the plane and in space, and what follows from it."""

from dataclasses import replace

import numpy as np
import pytest
from pydrake.math import RotationMatrix

from soft_gripper.estimators.gaussian import GaussianShape
from soft_gripper.estimators.spatial_curvature import SpatialCurvatureShape
from soft_gripper.estimators.uncertainty import Uncertainty
from soft_gripper.scenario.schema import SensorConfig
from soft_gripper.scenario.sensor_presets import sensor_layout
from soft_gripper.sensors.observability import observability, shared_equally

KINDS = ("curvature", "orientation")


@pytest.fixture
def spatial(shipped_finger):
    return replace(shipped_finger, yields=("bending", "sideways", "twist", "stretch"))


def sensors(finger, kind, sections=3):
    return sensor_layout(finger, SensorConfig(type=kind, sections=sections))


def test_in_the_plane_they_read_curvature_and_heading(shipped_finger, bent):
    q = 0.1 * bent(5, 12)
    curvature, orientation = (sensors(shipped_finger, kind) for kind in KINDS)
    np.testing.assert_allclose(curvature.read(q), q[:, 2::4] / shipped_finger.segment_length, rtol=1e-12)
    np.testing.assert_allclose(orientation.read(q), q.cumsum(axis=-1)[:, 3::4], atol=1e-12)
    driving = shipped_finger.pressure_torque(np.array([6e4]))
    free = driving / shipped_finger.stiffness
    for layout in (curvature, orientation):
        np.testing.assert_allclose(GaussianShape(layout)(layout.read(free), driving, np.zeros(3)).q, free, atol=1e-6)


def test_orientations_in_space_are_rotation_vectors(spatial):
    """A finger of one segment, by Drake's rotation matrices: bending, then sideways, then twist."""
    layout = sensors(replace(spatial, segments=1), "orientation", 1)
    angles = {"bending": 0.5, "sideways": -0.3, "twist": 0.8, "stretch": 1e-3}
    turned = RotationMatrix.MakeYRotation(0.5) @ RotationMatrix.MakeXRotation(-0.3) @ RotationMatrix.MakeZRotation(0.8)
    axis_angle = turned.ToAngleAxis()
    found = layout.predict(np.array([angles[way] for way in layout.deformations]))
    np.testing.assert_allclose(found, axis_angle.angle() * axis_angle.axis(), atol=1e-14)


@pytest.mark.parametrize("kind", KINDS)
def test_they_see_bends_and_twist_but_no_stretch(spatial, kind):
    seen = {each.deformation: each.is_seen for each in observability(sensors(spatial, kind), 1e-3)}
    assert seen == {"bending": True, "sideways": True, "twist": True, "stretch": False}


@pytest.mark.parametrize("kind", KINDS)
def test_sections_of_constant_curvature_are_found(spatial, kind):
    layout = sensors(replace(spatial, yields=("bending", "sideways", "twist")), kind)
    q = shared_equally(layout) @ np.array([0.6, 0.4, 0.3, 0.2, -0.1, 0.1, 0.15, 0.05, 0.0])
    estimate = SpatialCurvatureShape(layout, Uncertainty(reading=1e-4))
    np.testing.assert_allclose(estimate(layout.read(q), np.zeros(36), np.zeros(3)).q, q, atol=2e-6)
