"""The block that estimates shapes in space: a finger with three chambers, which bends all ways and stretches."""

import numpy as np
import pytest
from refusals import refused

from soft_gripper.diagrams.simulation import simulate
from soft_gripper.diagrams.station import make_station
from soft_gripper.scenario.scenario_file import load_scenario

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
