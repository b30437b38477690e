"""Piecewise constant curvature in space, and the block that estimates shapes there."""

from dataclasses import replace

import numpy as np
import pytest
from refusals import refused

from soft_gripper.diagrams.simulation import simulate
from soft_gripper.diagrams.station import make_station
from soft_gripper.estimators.driving_torque import recorded_inputs
from soft_gripper.estimators.finger_shape import Places
from soft_gripper.estimators.spatial_curvature import SpatialCurvatureShape
from soft_gripper.estimators.uncertainty import Uncertainty
from soft_gripper.scenario.scenario_file import load_scenario
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


STEPS = [
    "pressure.steps={finger::inner: [0.0], finger::left: [40000.0], finger::right: [0.0]}",
    *("pressure.settle=0.79", "pressure.hold_samples=1"),
]
IN_SPACE = ["sensor.sections=2", "sensor.layout=four_faces_and_diagonal", "estimator.type=gaussian"]


@pytest.fixture(scope="module")
def scenario():
    return load_scenario("three_chambers", [*STEPS, *IN_SPACE])


@pytest.fixture(scope="module")
def recording(scenario):
    return simulate(scenario).data


def test_tip_twist_and_all_joints_are_estimated(recording):
    last = recording.isel(time=-1)
    true = last["finger.true_tip_position"].values
    assert abs(true[1]) > 8e-3
    np.testing.assert_allclose(last["finger.estimated_tip_position"], true, atol=3e-4)
    np.testing.assert_allclose(last["finger.estimated_joint_positions"], last["finger.true_joint_positions"], atol=3e-4)
    for way in ("sideways", "twist"):
        np.testing.assert_allclose(last[f"finger.estimated_{way}_angles"], last[f"finger.true_{way}_angles"], atol=3e-3)
    assert last["finger.estimated_stretch_lengths"].sum() > 2e-4
    driving = {way: last[f"finger.{way}_driving_torque"].attrs["units"] for way in ("sideways", "twist", "stretch")}
    assert driving == {"sideways": "N m", "twist": "N m", "stretch": "N"}
    assert last["finger.fingertip_error"] < 4e-4
    assert np.all((last["finger.tip_position_std"] > 0) & (last["finger.tip_position_std"] < 2e-3))


def test_ports_in_the_plane_have_the_shape_as_seen_there(recording):
    last = recording.isel(time=-1)
    tip = last["finger.estimated_tip_position"].values
    np.testing.assert_array_equal(last["finger.tip_pose"].values[:2], tip[::2])
    joints = last["finger.estimated_joint_positions"].values
    np.testing.assert_array_equal(last["finger.joint_positions"], joints[:, ::2])
    X_WB = last["finger.X_WB"].values.reshape(3, 4)
    np.testing.assert_allclose(last["finger.joint_positions_world"], joints @ X_WB[:, :3].T + X_WB[:, 3], atol=1e-15)


def test_an_estimator_of_the_plane_refuses_sensors_that_see_a_finger_leave_it():
    with refused("type", "arcs"):
        make_station(load_scenario("three_chambers", [*IN_SPACE, "estimator.type=arcs"]))
