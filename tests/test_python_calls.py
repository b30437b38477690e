"""No Python runs at the plant's rate: the blocks are called with the samples of the sensors and at no other time."""

import sys
from collections import Counter

import pytest
from finger_plants import free_bending
from pydrake.systems.analysis import ApplySimulatorConfig, Simulator

from soft_gripper.diagrams.simulation import solver_config
from soft_gripper.diagrams.station import make_station

BEGIN = 0.5025  # s, between two samples


def calls_per_second(time_step, period=0.01):
    """Calls of every function of soft_gripper in one simulated second."""
    overrides = (f"plant_config.time_step={time_step}", f"sensor.period={period}")
    scenario = free_bending([50e3], 2.0, *overrides)
    simulator = Simulator(make_station(scenario).diagram)
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


@pytest.fixture(scope="module")
def baseline():
    return calls_per_second(time_step=0.01)


def test_blocks_work_once_a_sample_for_all_who_read_them(baseline):
    two_fingers = 2 * 100
    assert baseline["soft_gripper.strain_sensor._sample"] == two_fingers
    assert baseline["soft_gripper.arc_pose_estimator._estimate"] == two_fingers
    assert baseline["soft_gripper.metrics._calc_chain"] == two_fingers


@pytest.mark.parametrize("time_step", [0.002, 0.0])
def test_steps_of_the_plant_call_no_python(baseline, time_step):
    assert calls_per_second(time_step) == baseline


def test_calls_scale_with_the_sensors(baseline):
    assert calls_per_second(0.01, period=0.005) == Counter({name: 2 * n for name, n in baseline.items()})
