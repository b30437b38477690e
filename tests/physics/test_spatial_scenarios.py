"""Fingers in space in whole scenarios: what is in the plane stays there, and what is not comes to rest in balance."""

import numpy as np
import pytest
from finger_plants import free_bending
from pydrake.common.schema import Transform
from pydrake.math import RigidTransform, RollPitchYaw

from soft_gripper.diagrams.simulation import cached_station, simulate
from soft_gripper.fingers.spatial_chain import (
    Loads,
    posture,
    resting_positions,
    spatial_chain,
    torques,
    weights,
)
from soft_gripper.scenario.scenario_file import load_scenario

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


@pytest.mark.slow
def test_true_contact_of_a_turned_box_that_is_held_in_the_air():
    """It weighs what the fingers carry; its forces, at the centres of pressure, have the torques about every axis."""
    steps = "pressure.steps.all=[100e3, 125e3, 150e3]"
    scenario = load_scenario("box_grasp", [steps, f"models.gripper.fingers.all.{WAYS}"])
    box = scenario.models[-1]
    box.X_PC = Transform(RigidTransform(RollPitchYaw(0, 0, np.radians(20)), [0, 0, 0.03001]))
    recording, station = simulate(scenario), cached_station(scenario)
    last = recording.data.isel(time=-1)
    carried = sum(last[f"{finger.name}.true_contact_force_world"].values for finger in station.fingers)
    plant = station.plant
    mass = plant.CalcTotalMass(plant.CreateDefaultContext(), [plant.GetModelInstanceByName(box.name)])
    assert last[f"{box.name}.pose"][-1] > 0.0303
    np.testing.assert_allclose(carried, [0, 0, -9.81 * mass], atol=2e-3 * 9.81 * mass)
    for finger in station.fingers:
        _check_torques(finger, {name: last[f"{finger.name}.{name}"].values for name in NEEDED})


NEEDED = (
    *("true_contact_force_world", "contact_center", "true_contact_arc_length", "true_contact_side", "X_WB"),
    *("sampled_joint_angles", "true_sideways_angles", "true_twist_angles"),
    *("true_external_torque", "true_sideways_torque", "true_twist_torque"),
)


def _check_torques(finger, last):
    """One patch on the last link: the static torques of its force about the three axes of every joint."""
    chain = spatial_chain(finger.finger)
    ways = {"bending": "sampled_joint_angles", "sideways": "true_sideways_angles", "twist": "true_twist_angles"}
    at = posture(chain, chain.interleaved({way: last[name] for way, name in ways.items()}))
    X_WB = np.reshape(last["X_WB"], (3, 4))
    R_WB, p_WB = X_WB[:, :3], X_WB[:, 3]
    center, force = R_WB.T @ (last["contact_center"] - p_WB), R_WB.T @ last["true_contact_force_world"]
    R, origin = at.rotations[-1], at.origins[-1]
    tip = len(chain.deformations)
    loads = Loads(np.array([tip]), (R.T @ (center - origin))[None], force[None], np.zeros((1, 3)))
    expected = torques(at, loads)
    for way, name in (("bending", "external"), ("sideways", "sideways"), ("twist", "twist")):
        of_way = expected[np.array(chain.deformations) == way]
        np.testing.assert_allclose(last[f"true_{name}_torque"], of_way, atol=0.02 * np.abs(of_way).max())
    assert np.abs(last["true_twist_torque"]).max() > 1e-3
    assert abs(last["true_contact_side"]) < np.radians(60)
    assert 0.9 * finger.finger.length < last["true_contact_arc_length"] < 1.02 * finger.finger.length
