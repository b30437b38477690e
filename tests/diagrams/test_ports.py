"""Every port that can be seen can be read: before a run, during it, by Drake's own loggers, and whenever it begins."""

import numpy as np
import pytest
from logged_ports import LoggedStation, assert_same
from pydrake.systems.framework import Diagram

from soft_gripper.scenario.scenario_file import load_scenario
from soft_gripper.scenario.shipped import scenario_names

TIMES = (0.0, 0.04, 0.08)  # s
LATER = 10.0  # s
LOGGED = 10  # ports of each scenario
# Others hold the same blocks.
SLOW = "bottle_grasp", "box_grasp", "conforming_grasp", "irregular_grasp", "obstructed_inside", "obstructed_outside"
SLOW += "pick_and_place_apple", "pick_and_place_box", "pick_and_place_irregular", "probing_grasp"


@pytest.fixture(
    scope="module",
    params=[pytest.param(name, marks=[pytest.mark.slow] * (name in SLOW)) for name in scenario_names()],
)
def station(request):
    scenario, random = load_scenario(request.param), np.random.default_rng(len(request.param))
    return LoggedStation(scenario, lambda names: random.permutation(sorted(names))[:LOGGED])


def blocks(system):
    """The blocks of the project in a system."""
    if isinstance(system, Diagram):
        return [block for inner in system.GetSystems() for block in blocks(inner)]
    return [system] if type(system).__module__.startswith("soft_gripper.") else []


def read_blocks(diagram, root):
    """Reads every port of every block."""
    count = 0
    for block in blocks(diagram):
        context = block.GetMyContextFromRoot(root)
        for port in map(block.get_output_port, range(block.num_output_ports())):
            port.Eval(context)
            count += 1
    return count


def test_every_port_is_read_before_and_during_a_run_and_is_what_is_recorded(station):
    simulator, diagram = station.simulator(), station.station.diagram
    assert len(station.read(simulator)) == diagram.num_output_ports() > LOGGED
    read = []
    for time in TIMES:
        assert read_blocks(diagram, simulator.get_context()) > LOGGED
        simulator.AdvanceTo(time) if time else simulator.Initialize()
        read.append(station.read(simulator))
    recorded = station.recorded(simulator)
    rows = [round(time / station.station.scenario.sensor.period) for time in TIMES]
    assert_same(
        {name: np.array([each[name] for each in read]) for name in read[0]},
        {name: values[rows] for name, values in recorded.items()},
    )
    logged = station.logged(simulator)
    assert len(logged) == LOGGED
    assert_same(logged, {name: recorded[name] for name in logged})


def test_a_station_may_begin_at_any_time(station):
    """The times of contacts are times, and shifted."""
    runs = []
    for begin in (0.0, LATER):
        simulator = station.simulator(begin)
        simulator.AdvanceTo(begin + TIMES[-1])
        recorded = station.recorded(simulator)
        runs.append({name: values - begin * name.endswith("contact_time") for name, values in recorded.items()})
    assert_same(*runs, share=1e-9)
