"""No Python runs at the plant's rate: the blocks are called with the samples of the sensors and at no other time."""

import sys
from collections import Counter

import pytest
from finger_plants import free_bending
from pydrake.systems.analysis import ApplySimulatorConfig, Simulator

from soft_gripper.diagrams.simulation import solver_config
from soft_gripper.diagrams.station import make_private_station, make_station

BEGIN = 0.5025  # s, between two samples


def calls_per_second(scenario, make=make_private_station):
    """Calls of every function of soft_gripper in one simulated second."""
    simulator = Simulator(make(scenario).diagram)
    ApplySimulatorConfig(solver_config(scenario), simulator)
    simulator.AdvanceTo(BEGIN)
    calls = Counter()

    def count(frame, event, _):
        module = frame.f_globals.get("__name__", "")
        if event == "call" and module.startswith("soft_gripper."):
            calls[f"{module}.{frame.f_code.co_name}"] += 1

    sys.setprofile(count)
    try:
        simulator.AdvanceTo(BEGIN + 1.0)
    finally:
        sys.setprofile(None)
    return calls


def bending(time_step, period=0.01):
    """Calls in a station of two fingers and pressure steps."""
    return calls_per_second(free_bending([50e3], 2.0, f"plant_config.time_step={time_step}", f"sensor.period={period}"))


@pytest.fixture(scope="module")
def baseline():
    return bending(time_step=0.01)


def test_where_every_block_runs_it_works_once_a_sample_for_all_who_read_it():
    calls = calls_per_second(free_bending([50e3], 2.0), make_station)
    assert calls["soft_gripper.estimators.arcs.bends_from_readings"] == 2 * 100  # of two fingers


@pytest.mark.parametrize("time_step", [0.002, 0.0])
def test_steps_of_the_plant_call_no_python(baseline, time_step):
    assert bending(time_step) == baseline
