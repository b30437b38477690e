"""The cost of whole runs has two figures, with nothing read and with all; that of single blocks one for each class."""

import numpy as np
import pytest

from soft_gripper import load_scenario
from soft_gripper.diagrams.station import make_station
from studies.speed import block_costs

SHORT = ["pressure.steps.all=[60e3]", "pressure.settle=0.2", "pressure.hold_samples=5"]


@pytest.fixture(autouse=True)
def few(monkeypatch):
    monkeypatch.setattr(block_costs, "REPEATS", 2)
    monkeypatch.setattr(block_costs, "SAMPLES", 2)


def test_every_block_has_a_cost():
    """Those too that have discrete states but take no samples."""
    costs = block_costs.cost_of_blocks(make_station(load_scenario("free_bending", SHORT)))
    assert {"TrueContact", "StrainSensor", "ArcPoseEstimator"} <= costs.keys()
    assert np.isfinite([*costs.values()]).all()
