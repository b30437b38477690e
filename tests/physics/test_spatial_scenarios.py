"""Fingers in space in whole scenarios: what is in the plane stays there, and what is not comes to rest in balance."""

import numpy as np
import pytest
from finger_plants import free_bending

from soft_gripper.diagrams.simulation import kept_station, simulate
from soft_gripper.fingers.spatial_chain import posture, resting_positions, spatial_chain, weights
from soft_gripper.scenario.scenario_file import load_scenario

WAYS = "yields=bending sideways twist"
IN_SPACE = [f"models.{finger}.fingers.all.{WAYS}" for finger in ("left_finger", "right_finger")]


def test_a_finger_in_space_bends_in_its_plane_as_one_that_bends_alone():
    planar, spatial = (simulate(free_bending([60e3], 0.2, *more)) for more in ((), IN_SPACE))
    assert {name for name in spatial.data if name not in planar.data} == {
        f"{finger}_finger.true_{way}_angles" for finger in ("left", "right") for way in ("sideways", "twist")
    }
    for name in ("sampled_joint_angles", "estimated_joint_angles", "true_tip_position", "external_torque"):
        expected = planar[f"left_finger.{name}"].values
        np.testing.assert_allclose(spatial[f"left_finger.{name}"], expected, atol=1e-4 * np.nanmax(np.abs(expected)))
    for way in ("sideways", "twist"):
        angles = spatial[f"left_finger.true_{way}_angles"]
        assert angles.sizes["joint"] == 12
        np.testing.assert_allclose(angles, 0, atol=1e-9)


@pytest.mark.parametrize("springs", ["linear", "torsion"])
def test_weight_across_the_plane_bends_and_twists_as_the_balance_says(springs):
    gravity = np.array([2.0, 7.0, -6.0])
    torsion = [f"models.{finger}.springs={springs}" for finger in ("left_finger", "right_finger")]
    scenario = free_bending([100e3], 3.0, *IN_SPACE, *torsion, f"gravity={gravity.tolist()}")
    recording, station = simulate(scenario), kept_station(scenario)
    for in_plant in station.fingers:
        finger = in_plant.finger
        chain = spatial_chain(finger)
        driving = chain.spread({"bending": finger.pressure_torque(100e3)})
        weight = weights(finger, chain, in_plant.X_WB.rotation().inverse() @ gravity)
        q = resting_positions(chain, chain.spread(finger.stiffnesses), driving, weight)
        assert np.abs(q[np.array(chain.ways) == "twist"]).max() > 1e-3
        at = posture(chain, q)
        tip = at.origins[-1] + at.rotations[-1, :, 2] * finger.segment_length / 2
        np.testing.assert_allclose(recording[f"{in_plant.name}.true_tip_position"][-1], tip, atol=2e-5)
        for way, name in (("sideways", "true_sideways_angles"), ("twist", "true_twist_angles")):
            found = recording[f"{in_plant.name}.{name}"][-1]
            np.testing.assert_allclose(found, q[np.array(chain.ways) == way], atol=1e-4)


def test_a_box_that_is_turned_twists_the_fingers():
    steps, recordings = ("pressure.steps.all=[100e3]", "pressure.settle=0.99", "pressure.hold_samples=1"), []
    for ways in ("bending", "bending sideways twist"):
        scenario = load_scenario("turned_box_grasp", [*steps, f"models.gripper.fingers.all.yields={ways}"])
        recordings.append(simulate(scenario))
    planar, spatial = recordings
    assert abs(spatial["left_finger.true_twist_angles"].values[-1].sum()) > np.radians(3)
    for recording in (planar, spatial):
        assert 0.5 < recording["left_finger.normal_force"][-1] < 1.5
    yaw = [2 * np.arctan2(pose[3], pose[0]) for pose in (each["box.pose"].values[-1] for each in (planar, spatial))]
    assert yaw[1] < yaw[0] - np.radians(2)
