"""What the blocks cost, counted in calls, of Python and of C, which no other load on the machine changes."""

import sys
from pathlib import Path

import pytest
from pydrake.systems.analysis import ApplySimulatorConfig, Simulator

import soft_gripper
from soft_gripper import diagrams
from soft_gripper.diagrams.schema.scenario_file import load_scenario
from soft_gripper.diagrams.simulation import solver_config
from soft_gripper.diagrams.station import make_station

SECONDS = 0.5
OURS = tuple(str(Path(str(package.__file__)).parent) for package in (soft_gripper, diagrams))


def calls_per_sample(scenario, begin):
    """Calls of this code's own functions, and of C by them, a sample from `begin` on, s.

    Those of pydrake do not count: its versions differ in what they report and in what Python they need.
    """
    simulator = Simulator(make_station(scenario).diagram)
    ApplySimulatorConfig(solver_config(scenario), simulator)
    simulator.AdvanceTo(begin)
    calls = 0

    def count(frame, event, argument):
        nonlocal calls
        ours = frame.f_code.co_filename.startswith(OURS)
        of_drake = type(getattr(argument, "__self__", None)).__name__ == "PyCapsule"
        calls += ours and (event == "call" or (event == "c_call" and not of_drake))

    sys.setprofile(count)
    try:
        simulator.AdvanceTo(begin + SECONDS)
    finally:
        sys.setprofile(None)
    return calls * scenario.sensor.period / SECONDS


@pytest.mark.parametrize(
    ("name", "begin", "limit"),
    [("free_bending", 0.5025, 105), ("box_grasp", 10.0025, 124), ("pick_and_place_box", 0.5025, 303)],
)
def test_a_sample_takes_few_calls(name, begin, limit):
    """All two fingers, in the box grasp while they touch it."""
    assert calls_per_sample(load_scenario(name), begin) <= limit
