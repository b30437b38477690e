"""A user's own estimator in the placement of sensors: the same function leads to the same numbers."""

import pytest

from soft_gripper.diagrams.simulation import run_station
from soft_gripper.diagrams.station import make_station
from soft_gripper.extras.hardware.recorded_run import RecordedRun
from soft_gripper.extras.placement.errors import Assumptions
from soft_gripper.extras.placement.place_sensors import place_sensors
from soft_gripper.extras.placement.samples import held_fingers
from soft_gripper.scenario.scenario_file import load_scenario

OWN, THEIRS = "own_blocks:contact_again", "contact"
SHORT = ["pressure.steps.all=[0.0, 150e3]", "pressure.settle=0.3", "pressure.hold_samples=20"]


@pytest.fixture(scope="module")
def recorded():
    station = make_station(load_scenario("free_bending", SHORT))
    return station, run_station(station)


def test_placement(recorded):
    station, recording = recorded
    samples = held_fingers("free", RecordedRun(recording, station.scenario, station.fingers))
    theirs, own = (place_sensors(1, samples, Assumptions(), name).best[0] for name in (THEIRS, OWN))
    assert own.made["free"].pose == theirs.made["free"].pose
