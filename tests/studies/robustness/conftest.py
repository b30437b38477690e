"""A short recording that the tests of robustness share."""

import pytest

from soft_gripper.diagrams.simulation import run_station
from soft_gripper.diagrams.station import make_station
from soft_gripper.scenario.scenario_file import load_scenario
from studies.robustness.plants import FingerAtRest

SHORT = ["pressure.steps.all=[0.0, 150e3]", "pressure.settle=0.3", "pressure.hold_samples=20"]


@pytest.fixture(scope="session")
def held() -> FingerAtRest:
    """A finger of free bending in two short steps."""
    station = make_station(load_scenario("free_bending", SHORT))
    return FingerAtRest(station, run_station(station), station.fingers[0])
