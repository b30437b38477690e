"""Fingers in space in whole scenarios: what is in the plane stays there, and what is not comes to rest in balance."""

import numpy as np
import pytest
from finger_plants import free_bending

from soft_gripper.diagrams.simulation import cached_station, simulate
from soft_gripper.fingers.spatial_chain import (
    posture,
    resting_positions,
    spatial_chain,
    weights,
)

WAYS = "yields=bending sideways twist"
IN_SPACE = [f"models.{finger}.fingers.all.{WAYS}" for finger in ("left_finger", "right_finger")]


@pytest.mark.parametrize("springs", ["linear", "torsion"])
def test_weight_across_the_plane_bends_and_twists_as_the_balance_says(springs):
    gravity = np.array([2.0, 7.0, -6.0])
    torsion = [f"models.{finger}.springs={springs}" for finger in ("left_finger", "right_finger")]
    scenario = free_bending([100e3], 3.0, *IN_SPACE, *torsion, f"gravity={gravity.tolist()}")
    recording, station = simulate(scenario), cached_station(scenario)
    for in_plant in station.fingers:
        finger = in_plant.finger
        chain = spatial_chain(finger)
        driving = chain.interleaved({"bending": finger.pressure_torque(100e3)})
        weight = weights(finger, chain, in_plant.X_WB.rotation().inverse() @ gravity)
        q = resting_positions(chain, chain.interleaved(finger.stiffnesses), driving, weight)
        assert np.abs(q[np.array(chain.deformations) == "twist"]).max() > 1e-3
        at = posture(chain, q)
        tip = at.origins[-1] + at.rotations[-1, :, 2] * finger.segment_length / 2
        np.testing.assert_allclose(recording[f"{in_plant.name}.true_tip_position"][-1], tip, atol=2e-5)
        for way, name in (("sideways", "true_sideways_angles"), ("twist", "true_twist_angles")):
            found = recording[f"{in_plant.name}.{name}"][-1]
            np.testing.assert_allclose(found, q[np.array(chain.deformations) == way], atol=1e-4)
