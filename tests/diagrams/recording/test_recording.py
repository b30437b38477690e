"""Recordings: labelled signals with units, true to the maths of the blocks, saved and drawn."""

import h5py
import numpy as np
import pytest
import xarray as xr
from finger_plants import free_bending

from soft_gripper.diagrams.recording import Recording
from soft_gripper.diagrams.simulation import run_station
from soft_gripper.diagrams.station import make_station
from soft_gripper.scenario.scenario_file import load_scenario

RESPONSE = "sensor.response=[[0.7, -0.2], [1.0, 0.0], [1.4, 0.9]]"


@pytest.fixture(scope="module")
def run():
    """A station of fingers under different pressures, and what it recorded."""
    scenario = free_bending(
        [0.0],
        0.4,
        "pressure.steps.left_finger=[120.0e3, -30.0e3]",
        "pressure.steps.right_finger=[60.0e3]",
        "sensor.sections=3",
        RESPONSE,
    )
    station = make_station(scenario)
    return station, run_station(station)


def test_samples_are_the_plants_state_one_sample_before(run):
    station, recording = run
    state = recording["plant.state"].values
    for finger in station.fingers:
        positions = station.plant.GetPositionsFromArray
        truth = [positions(finger.model, row[: station.plant.num_positions()]) for row in state]
        sampled = recording[f"{finger.name}.sampled_joint_angles"].values
        np.testing.assert_array_equal(sampled[1:], truth[:-1])


def test_saved_file_holds_the_same_and_opens_without_xarray(run, tmp_path):
    _, recording = run
    path = tmp_path / "recording.nc"
    recording.save(path)
    xr.testing.assert_identical(Recording.load(path).data, recording.data)
    with h5py.File(path) as file:
        theta = file["left_finger.theta"]
        np.testing.assert_array_equal(theta[:], recording["left_finger.theta"])
        assert theta.attrs["units"] == "rad"


EVERYTHING = [
    *("task.time_limit=0.1", "sensor.errors.preset=realistic", "estimator.contact_threshold=2.5e-3"),
    *("estimator.type=recursive", "estimator.alongside=[spline, contact, gaussian]"),
]


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "overrides"), [("pick_and_place_box", EVERYTHING), ("tip_distance_steps", ["control.hold=0.1"])]
)
def test_every_variable_and_coordinate_has_units_in_the_file_too(tmp_path, name, overrides):
    """One for all entries, or one for each along the last axis, as the coordinate of units has them."""
    recording = run_station(make_station(load_scenario(name, overrides)))
    recording.save(tmp_path / "recording.nc")
    for data in (recording.data, Recording.load(tmp_path / "recording.nc").data):
        assert [name for name, variable in data.variables.items() if not variable.attrs.get("units")] == []
        for signal in data.data_vars.values():
            each = signal.coords.get(f"{signal.dims[-1]}_units")
            assert each is None or signal.attrs["units"] == ", ".join(each.values.tolist())
    with h5py.File(tmp_path / "recording.nc") as file:
        assert [name for name, array in file.items() if not array.attrs.get("units")] == []
