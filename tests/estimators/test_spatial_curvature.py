"""Piecewise constant curvature in space: exact where sections are such, with the uncertainty of what is not seen."""

from dataclasses import replace

import numpy as np
import pytest

from soft_gripper.estimators.finger_shape import Places
from soft_gripper.estimators.recorded_inputs import recorded_inputs
from soft_gripper.estimators.spatial_curvature import SpatialCurvatureShape
from soft_gripper.estimators.uncertainty import Uncertainty
from soft_gripper.scenario.schema import SensorConfig
from soft_gripper.scenario.sensor_presets import sensor_layout
from soft_gripper.sensors.observability import observability, shared_equally

WAYS = ("bending", "sideways", "twist")
SECTIONS = np.array([0.6, 0.4, 0.2, -0.1, 0.15, 0.05])  # rad: bends, sideways, twist; two sections


@pytest.fixture
def spatial(shipped_finger):
    return replace(shipped_finger, yields=WAYS)


def estimate(layout, readings, **assumed):
    return SpatialCurvatureShape(layout, Uncertainty(**assumed))(readings, np.zeros(36), np.zeros(3))


@pytest.mark.parametrize("name", ["four_faces_and_diagonal", "outer_pair_and_diagonals"])
def test_sections_that_bend_equally_are_found(spatial, name):
    layout = sensor_layout(spatial, SensorConfig(layout=name, sections=2))
    q = shared_equally(layout) @ SECTIONS
    found = estimate(layout, layout.read(np.stack([q, 0.5 * q, 0 * q])))
    np.testing.assert_allclose(found.q, [q, 0.5 * q, 0 * q], atol=2e-6)


def test_the_tip_converges_to_that_of_the_exponential_of_a_rotation_vector(spatial):
    """p = l (I + (1 - cos w) / w^2 [w] + (w - sin w) / w^3 [w]^2) e_z , with the square of the segment length."""
    turn, length = np.array([0.2, 0.9, 0.5]), spatial.length
    w, across = np.linalg.norm(turn), np.cross(turn, np.eye(3)).T
    series = np.eye(3) + (1 - np.cos(w)) / w**2 * across + (w - np.sin(w)) / w**3 * across @ across
    errors = []
    for segments in (12, 24):
        finger = replace(spatial, segments=segments)
        q = np.repeat([turn[1], turn[0], turn[2]], segments) / segments
        errors.append(np.linalg.norm(Places(finger, WAYS)(q)[0][-1] - length * series[:, 2]))
    assert errors[1] < 3e-5
    assert errors[0] / errors[1] == pytest.approx(4, rel=0.1)


def test_standard_deviations_are_those_that_were_promised(spatial):
    layout = sensor_layout(spatial, SensorConfig(layout="four_faces_and_diagonal", sections=2))
    found = estimate(layout, layout.read(np.zeros(36)), reading=1e-3)
    promised = np.concatenate([each.std for each in observability(layout, 1e-3)])
    sums = 6 * shared_equally(layout).T
    np.testing.assert_allclose(np.sqrt(np.diag(sums @ found.covariance @ sums.T)), promised, rtol=1e-6)


def test_sensors_that_drift_are_zeroed_and_less_certain_with_time(spatial):
    """Readings of a finger that is open for ten minutes; it may be known to be."""
    layout = sensor_layout(spatial, SensorConfig(layout="four_faces_and_diagonal", sections=2))
    driving, gravity = np.zeros((20, 36)), np.zeros((20, 3))
    readings = np.broadcast_to(layout.read(layout.straight) + 0.01, (20, layout.readings))
    uncertainty = Uncertainty(drift=1e-3)
    for free_pressure in (2e3, 0.0):
        shape = SpatialCurvatureShape(layout, replace(uncertainty, free_pressure=free_pressure), 30.0)
        found = shape(*recorded_inputs(shape, readings, driving, gravity))
        grown = np.trace(found.covariance[-1]) / np.trace(found.covariance[0])
        assert (grown > 5) == (free_pressure == 0)
        assert (np.abs(found.q[-1]).max() < 1e-6) == (free_pressure > 0)
