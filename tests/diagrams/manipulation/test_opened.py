"""A gripper that is not open, by all that is estimated, does not descend to the object: the shipped task, simulated."""

import numpy as np
import pytest
from pydrake.systems.analysis import Simulator

from soft_gripper.arrays import Array
from soft_gripper.control.task import Outcome
from soft_gripper.diagrams.recording import Recording
from soft_gripper.diagrams.simulation import make_simulator
from soft_gripper.diagrams.station import make_station
from soft_gripper.diagrams.station_parts import Station
from soft_gripper.scenario.scenario_file import load_scenario

pytestmark = pytest.mark.slow

APPROACH, OVER_THE_OBJECT = 0, 0.1  # number of the phase; m, its height
BENT = 0.02  # rad, toward the object, of every joint of a blocked finger
SHORT = ["task.timeout=0.5"]


def block(simulator: Simulator, station: Station, finger: str) -> None:
    """Locks the joints of a finger where they are bent."""
    context = station.plant.GetMyMutableContextFromRoot(simulator.get_mutable_context())
    for i in range(12):
        joint = station.plant.GetJointByName(f"{finger}_joint_{i}")
        joint.set_angle(context, BENT)
        joint.Lock(context)


def heights(station: Station, recording: Recording) -> Array:
    """Of the palm over where it grasps, m, at every sample."""
    task = station.scenario.task
    plant, context = station.plant, station.plant.CreateDefaultContext()
    (X_WO,) = (model.X_PC.GetDeterministicValue() for model in station.scenario.models if model.name == task.object)
    grasp = (X_WO @ task.X_OG.GetDeterministicValue()).translation()[2]
    found = []
    for state in recording["plant.state"].values:
        plant.SetPositionsAndVelocities(context, state)
        found.append(plant.GetBodyByName("palm").EvalPoseInWorld(context).translation()[2] - grasp)
    return np.array(found)


def assert_stayed_away(station: Station, recording: Recording) -> None:
    """The task has failed, in the approach, and the arm has gone home without a descent."""
    own = recording["task.phase"].values < len(station.scenario.task.phases)
    assert set(recording["task.phase"].values[own]) == {APPROACH}
    assert recording["task.outcome"].values[-1] == Outcome.NOT_OPENED
    assert heights(station, recording).min() > OVER_THE_OBJECT - 2e-3
    arm = station.plant.GetModelInstanceByName("arm")
    context = station.plant.CreateDefaultContext()
    station.plant.SetPositionsAndVelocities(context, recording["plant.state"].values[-1])
    np.testing.assert_allclose(station.plant.GetPositions(context, arm), station.scenario.arm.home, atol=0.02)


@pytest.mark.parametrize("finger", ["left_finger", "right_finger"])
def test_with_a_finger_that_is_blocked(finger):
    station = make_station(load_scenario("pick_and_place_box", SHORT))
    simulator = make_simulator(station)
    block(simulator, station, finger)
    while not station.task.is_over(station.task.GetMyContextFromRoot(simulator.get_context())):
        simulator.AdvanceTo(simulator.get_context().get_time() + 0.5)
    assert_stayed_away(station, station.recording(simulator.get_context()))
