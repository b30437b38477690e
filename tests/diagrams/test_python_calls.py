"""No Python runs at the plant's rate: the blocks are called with the samples of the sensors and at no other time."""

import sys
from collections import Counter
from functools import cache

import pytest
from finger_plants import free_bending
from pydrake.systems.analysis import ApplySimulatorConfig, Simulator

from soft_gripper.diagrams.simulation import solver_config
from soft_gripper.diagrams.station import make_private_station, make_station
from soft_gripper.scenario.scenario_file import load_scenario

BEGIN = 0.5025  # s, between two samples
OF_THE_PLANT = (
    "soft_gripper.truth.contact.",
    "soft_gripper.control.task._",
)
CONTACT = "estimator.contact_threshold=2.5e-3"


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


@cache
def handling(name, time_step):
    """Calls in a station of an arm, a task, the grip control and all that is sensed, while the arm moves.

    How many contacts there are, and at which sample the fingers have come to rest, belongs to the plant: functions
    that go through them are left out.
    """
    calls = calls_per_second(load_scenario(name, [f"plant_config.time_step={time_step}", CONTACT]))
    return Counter({name: n for name, n in calls.items() if not name.startswith(OF_THE_PLANT)}), calls


@pytest.fixture(scope="module")
def baseline():
    return bending(time_step=0.01)


def test_where_every_block_runs_it_works_once_a_sample_for_all_who_read_it():
    calls = calls_per_second(free_bending([50e3], 2.0), make_station)
    assert calls["soft_gripper.estimators.arcs.bends_from_readings"] == 2 * 100  # of two fingers


@pytest.mark.parametrize("time_step", [0.002, 0.0])
def test_steps_of_the_plant_call_no_python(baseline, time_step):
    assert bending(time_step) == baseline


CALLBACKS = {  # calls in a second, for both fingers at once
    "estimators.arc_shapes.joint_angles": 100,
    "load.force_estimator.external_torque": 100,
    "load.contact_detector._touch": 0,  # nothing in the loop reads it
    "load.opening._width": 0,  # nothing reads it: it is computed after the run
    "truth.contact._collect": 100,
    "load.opening.opening": 100,
    "control.pid_controller._anti_windup_memory": 100,
    "control.pid_controller.step": 100,
    "control.task._next_state": 100,
    "control.task.step": 100,
}


@pytest.mark.slow
def test_blocks_of_a_task_work_once_a_sample():
    _, calls = handling("pick_and_place_box", 0.01)
    assert {name: calls[f"soft_gripper.{name}"] for name in CALLBACKS} == CALLBACKS
