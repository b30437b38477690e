"""Stations that are used again: runs are the same to the bit, and nothing that has changed is missed."""

import os
import shutil
from dataclasses import replace

import pytest
import xarray as xr
from finger_plants import free_bending

from soft_gripper.diagrams import simulation as kept_stations
from soft_gripper.diagrams.simulation import MAX_STATIONS, cached_station, run_station, simulate
from soft_gripper.diagrams.station import make_private_station
from soft_gripper.models import DIRECTORY
from soft_gripper.scenario.scenario_file import load_scenario

SHORT = ["pressure.steps.all=[60e3]", "pressure.settle=0.1", "pressure.hold_samples=2"]
NOISY = [*SHORT, "sensor.errors.preset=realistic", "sensor.errors.dropout=0.1"]


@pytest.fixture
def built(monkeypatch):
    """The scenarios of the stations that are built, of none at first."""
    scenarios = []
    monkeypatch.setattr(kept_stations, "_stations", type(kept_stations._stations)())
    monkeypatch.setattr(kept_stations, "make_private_station", lambda s: scenarios.append(s) or make_private_station(s))
    return scenarios


def anew(scenario):
    return run_station(make_private_station(scenario)).data


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "overrides"),
    [
        ("box_grasp", [*NOISY, "estimator.type=recursive", "estimator.contact_threshold=2.5e-3"]),
        ("tip_distance_steps", ["control.hold=0.1", "sensor.errors.preset=realistic"]),
        pytest.param("pick_and_place_box", ["task.time_limit=0.6"], marks=pytest.mark.slow),
    ],
)
def test_a_run_is_the_same_to_the_bit(built, name, overrides):
    """Between two of one seed lies one of another, and of another solver."""
    one, other = (load_scenario(name, [*overrides, f"sensor.seed={seed}"]) for seed in (1, 2))
    other.simulator_config.accuracy = 1e-2
    first, between, again = simulate(one), simulate(other), simulate(one)
    assert len(built) == 1
    xr.testing.assert_identical(first.data, again.data)
    xr.testing.assert_identical(again.data, anew(one))
    xr.testing.assert_identical(between.data, anew(other))


def test_a_file_that_has_changed_is_read_again(built, tmp_path):
    """Even within the resolution of its date, and where it has the same size."""
    file = tmp_path / "finger.urdf"
    shutil.copy(DIRECTORY / "grippers" / "finger.urdf", file)
    scenario = free_bending([50e3], 0.1, f"models.0.file={file}")
    first, _ = simulate(scenario), simulate(scenario)
    assert len(built) == 1
    times = file.stat().st_atime_ns, file.stat().st_mtime_ns
    file.write_text(file.read_text().replace('length="0.12"', 'length="0.13"'))
    os.utime(file, ns=times)
    longer = simulate(scenario)
    assert len(built) == 2
    assert not longer.data.equals(first.data)


def test_a_model_of_several_files_is_read_for_every_run(built, tmp_path):
    file = tmp_path / "finger.urdf"
    text = (DIRECTORY / "grippers" / "finger.urdf").read_text()
    file.write_text(text.replace("</robot>", "<!-- <mesh/> --></robot>"))
    scenario = free_bending([50e3], 0.1, f"models.0.file={file}")
    cached_station(scenario)
    assert len(kept_stations._stations) == 0


@pytest.mark.slow
def test_the_last_few_are_kept(built):
    scenarios = [load_scenario("free_bending", [*SHORT, f"sensor.sections={n}"]) for n in range(1, MAX_STATIONS + 2)]
    for scenario in scenarios:
        cached_station(scenario)
    assert len(kept_stations._stations) == MAX_STATIONS
    for scenario in scenarios[1:]:
        cached_station(replace(scenario))
    assert len(built) == MAX_STATIONS + 1
    cached_station(scenarios[0])
    assert len(built) == MAX_STATIONS + 2
