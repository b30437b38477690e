"""Runs: from the beginning to the end, the same every time, by one seed for all random sources."""

import re

import numpy as np
import pytest
import xarray as xr
from finger_plants import free_bending
from pydrake.common import RandomDistribution
from pydrake.systems.framework import DiagramBuilder
from pydrake.systems.primitives import RandomSource

import soft_gripper as sg
from soft_gripper.diagrams.simulation import advance, make_simulator, seed_random_sources, simulate, solver_config
from soft_gripper.diagrams.station import make_station
from soft_gripper.scenario.model_files import model_path
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


@pytest.fixture(scope="module")
def nested():
    """A diagram with a source, and a diagram in it with another."""
    sources = [RandomSource(RandomDistribution.kGaussian, 2, 0.1) for _ in range(2)]
    inner, outer = DiagramBuilder(), DiagramBuilder()
    inner.AddSystem(sources[0])
    outer.AddSystem(inner.Build())
    outer.AddSystem(sources[1])
    diagram = outer.Build()

    def numbers(seed):
        context = diagram.CreateDefaultContext()
        seed_random_sources(diagram, context, seed)
        return [s.get_output_port().Eval(s.GetMyContextFromRoot(context)).tolist() for s in sources]

    return numbers


def test_every_source_has_a_stream_of_its_own(nested):
    first, second = nested(4)
    assert not np.isin(first, second).any()


def test_sensors_of_a_finger_err_alike_wherever_it_stands_in_the_file(tmp_path):
    text = model_path("package://soft_gripper/grippers/two_finger.urdf").read_text()
    swapped = re.sub(r"(<finger .*?</finger>)(\s*)(<finger .*?</finger>)", r"\3\2\1", text, flags=re.DOTALL)
    read = []
    for number, model in enumerate((text, swapped)):
        file = tmp_path / f"{number}.urdf"
        file.write_text(model)
        changes = "sensor.errors.preset=realistic", "pressure.settle=0.1", "pressure.steps.all=[5e4]"
        read.append(sg.simulate(sg.load_scenario("box_grasp", [f"models.0.file={file}", *changes])))
    for signal in ("left_finger.strain", "right_finger.strain"):
        np.testing.assert_allclose(*(recording[signal] for recording in read), atol=1e-12)
