"""The cost of whole runs has two figures, with nothing read and with all; that of single blocks one for each class."""

import numpy as np
import pytest

from soft_gripper import load_scenario
from soft_gripper.diagrams.station import make_private_station, make_station
from studies.speed import block_costs

SHORT = ["pressure.steps.all=[60e3]", "pressure.settle=0.2", "pressure.hold_samples=5"]


@pytest.fixture(autouse=True)
def few(monkeypatch):
    monkeypatch.setattr(block_costs, "REPEATS", 2)
    monkeypatch.setattr(block_costs, "SAMPLES", 2)


def test_every_block_has_a_cost():
    """Those too that have discrete states but take no samples."""
    costs = block_costs.measure_blocks(make_station(load_scenario("free_bending", SHORT)))
    assert {"TrueContact", "StrainSensor", "ArcPoseEstimator"} <= costs.keys()
    assert np.isfinite([*costs.values()]).all()


def test_reading_all_takes_longer():
    station = make_private_station(load_scenario("free_bending", SHORT))
    unread, read = block_costs._speeds(station)
    assert 0 < read < unread
    unread, read = block_costs._run(station.diagram, station)
    assert 0 < unread < read
    assert np.ptp(block_costs._run(block_costs.bare_diagram(station.scenario), station)) == 0


def test_both_figures_are_printed(capsys):
    """Bars are for recordings of which nothing is read."""
    block_costs._print_rows("closed", np.array([[1.0, 1.2], [2.0, 2.2]]), "at most 1.5")
    rows = [line.split() for line in capsys.readouterr().out.splitlines()]
    assert rows == [["closed", "1.1", "1.0", "1.2", "at", "most", "1.5"], ["all", "read", "2.1", "2.0", "2.2"]]
