"""Runs: from the beginning to the end, the same every time, and without a trace on the scenario."""

import numpy as np
import pytest
import xarray as xr
from finger_plants import free_bending

from soft_gripper.diagrams.simulation import advance, make_simulator, simulate, solver_config
from soft_gripper.diagrams.station import make_station
from soft_gripper.scenario.scenario_file import load_scenario


def test_progress_reports_the_time_after_every_step():
    times = []

    def reported(time):
        times.append(time)
        return True  # as a bar of tqdm does that was drawn

    recording = simulate(free_bending([0.0, 50e3, 20e3], 0.2, "plant_config.time_step=0.01"), progress=reported)
    assert sorted({round(time, 6) for time in times}) == pytest.approx(np.arange(61) / 100)
    assert recording["time"][-1] == pytest.approx(0.6)


def test_the_scenarios_integrator_is_for_a_continuous_plant():
    discrete = solver_config(load_scenario("free_bending", ["plant_config.time_step=0.005"]))
    assert (discrete.integration_scheme, discrete.use_error_control) == ("explicit_euler", False)
    continuous = solver_config(load_scenario("free_bending", ["plant_config.time_step=0"]))
    assert (continuous.integration_scheme, continuous.use_error_control) == ("cenic", True)


def test_interruption_leaves_the_run_at_once():
    def interrupt(time):
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        simulate(free_bending([0.0, 0.0], 0.1), progress=interrupt)


@pytest.mark.parametrize("time_step", [0.01, 0.0])
def test_to_advance_to_where_it_is_changes_nothing(time_step):
    """With a continuous plant, Drake would end the process."""
    station = make_station(free_bending([80e3], 0.1, f"plant_config.time_step={time_step}"))
    simulator = make_simulator(station)
    for time in (0.0, 0.0, 0.02, 0.02, 0.03):
        advance(simulator, station, time)
        assert simulator.get_context().get_time() == time
    again = make_simulator(station)
    advance(again, station, 0.02)
    advance(again, station, 0.03)
    xr.testing.assert_identical(
        station.recording(simulator.get_context()).data, station.recording(again.get_context()).data
    )
