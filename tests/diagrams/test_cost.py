"""What the blocks cost, counted in calls, of Python and of C, which no other load on the machine changes.

From drake 1.58 on pydrake's own functions do not count, but copy the vectors that they return by numpy.copy, which is
left out; so the limits are those of drake 1.51, and none of these tests is `slow`, which would run with one version of
Drake only. To read a value in the cache takes three calls instead of one, so that Drake can free the block (`Cached`).
"""

import sys
from collections import Counter

import pytest
from pydrake.systems.analysis import ApplySimulatorConfig, Simulator

from soft_gripper.diagrams.simulation import solver_config
from soft_gripper.diagrams.station import make_private_station
from soft_gripper.scenario.scenario_file import load_scenario

SECONDS = 0.5
COPIES = ("copy", "_copy_dispatcher")  # of numpy


def calls_per_sample(scenario, begin):
    """Calls of a sample from `begin` on, s."""
    simulator = Simulator(make_private_station(scenario).diagram)
    ApplySimulatorConfig(solver_config(scenario), simulator)
    simulator.AdvanceTo(begin)
    calls = Counter()
    sys.setprofile(lambda frame, event, _: calls.update([event] * (frame.f_code.co_name not in COPIES)))
    try:
        simulator.AdvanceTo(begin + SECONDS)
    finally:
        sys.setprofile(None)
    return (calls["call"] + calls["c_call"]) * scenario.sensor.period / SECONDS


@pytest.mark.parametrize(
    ("name", "begin", "limit"),
    [
        ("free_bending", 0.5025, 18),
        ("box_grasp", 10.0025, 80),  # six each for the area and the largest pressure of two patches
        ("pick_and_place_box", 0.5025, 560),  # a tenth of them for task and PID as steps, which run in MuJoCo too
    ],
)
def test_a_sample_takes_few_calls(name, begin, limit):
    """All two fingers, in the box grasp while they touch it."""
    assert calls_per_sample(load_scenario(name), begin) <= limit
