"""Recordings: what they hold, in memory and in their files, which are whole or refused."""

import tracemalloc

import h5py
import numpy as np
import pytest
import xarray as xr
from finger_plants import free_bending
from pydrake.trajectories import PiecewisePolynomial
from refusals import refused

from soft_gripper.control.task import Phase
from soft_gripper.diagrams.recording import Recording, phase_spans
from soft_gripper.diagrams.simulation import run_station
from soft_gripper.diagrams.station import make_station
from soft_gripper.errors import InputError
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


T, SIGNALS = 20_000, 10


@pytest.fixture(scope="module")
def recording():
    """Random walks that stand still between samples of a sensor, 1 MB each."""
    rng = np.random.default_rng(1)
    walks = {f"s{i}": rng.normal(size=(T // 5, 6)).cumsum(axis=0).repeat(5, axis=0) for i in range(SIGNALS)}
    variables = {name: (("time", "axis"), values, {"units": "rad"}) for name, values in walks.items()}
    coords = {"time": ("time", 0.01 * np.arange(T), {"units": "s"}), "axis": list("abcdeé")}
    return Recording(xr.Dataset(variables, coords, {"scenario": 100_000 * "a"}))


def test_a_file_is_smaller_and_exact(recording, tmp_path):
    recording.save(tmp_path / "a.nc")
    assert (tmp_path / "a.nc").stat().st_size < 0.4 * recording.data.nbytes
    found = Recording.load(tmp_path / "a.nc")
    assert found.signals == recording.signals
    xr.testing.assert_identical(found.data, recording.data)


def test_saving_takes_memory_for_one_signal(recording, tmp_path):
    Recording(recording.data[["s0"]]).save(tmp_path / "a.nc")  # what is imported is not counted
    tracemalloc.start()
    try:
        recording.save(tmp_path / "b.nc")
        peak = tracemalloc.get_traced_memory()[1]
    finally:
        tracemalloc.stop()
    assert peak < 3 * recording["s0"].nbytes


@pytest.mark.parametrize("form", ["NETCDF3_CLASSIC", "NETCDF3_64BIT"])
def test_netcdf_3_is_still_read_and_saved(recording, tmp_path, form):
    few = recording.data.isel(time=slice(100))
    few.to_netcdf(tmp_path / "a.nc", engine="scipy", format=form, unlimited_dims=["time"])
    found = Recording.load(tmp_path / "a.nc")
    xr.testing.assert_equal(found.data, few)
    found.save(tmp_path / "b.nc")
    xr.testing.assert_identical(Recording.load(tmp_path / "b.nc").data, found.data)


def virtual(file):
    layout = h5py.VirtualLayout((3,), float)
    layout[:] = h5py.VirtualSource("other.h5", "s", (3,))
    file.create_virtual_dataset("s", layout)


@pytest.mark.parametrize(
    "add",
    [
        virtual,
        lambda file: file.create_dataset("s", (3,), float, external=[("/dev/zero", 0, 24)]),
        lambda file: file.update(s=h5py.ExternalLink("other.h5", "s")),
        lambda file: file.update(s=h5py.SoftLink("/t")),
    ],
)
def test_arrays_outside_of_the_file_are_refused(tmp_path, add):
    with h5py.File(tmp_path / "a.nc", "w", libver="v110") as file:
        file["t"] = np.zeros(3)
        add(file)
    with refused("array", "s"):
        Recording.load(tmp_path / "a.nc")


def test_what_has_no_checksums_is_refused(recording, tmp_path):
    """A damaged one could be read for ever."""
    recording.data.isel(time=slice(9)).to_netcdf(tmp_path / "a.nc", engine="h5netcdf")
    with refused("file", "a.nc"):
        Recording.load(tmp_path / "a.nc")


def test_a_damaged_file_is_refused(recording, tmp_path):
    """Wherever a byte of its structure is wrong, which most of a short file is."""
    few = recording.data.isel(time=slice(9)).drop_encoding().drop_attrs()
    Recording(few).save(tmp_path / "a.nc")
    content, random = (tmp_path / "a.nc").read_bytes(), np.random.default_rng(1)
    ends = []
    for place in random.integers(9, len(content), 60):
        (tmp_path / "b.nc").write_bytes(content[:place] + bytes([content[place] ^ 0x55]) + content[place + 1 :])
        try:
            Recording.load(tmp_path / "b.nc")
            ends.append("read")
        except InputError:
            ends.append("refused")
    assert ends.count("refused") > 30


STAY = PiecewisePolynomial(np.zeros((6, 1)))
PHASES = [Phase(name, STAY, 0.05, i + 1) for i, name in enumerate(("approach", "close", "lift", "rescue"))]


@pytest.mark.parametrize(
    ("numbers", "expected"),
    [
        ([0, 0, 1, 2, 2, 2, 4, 4], [("approach", 0.0, 1.0), ("close", 1.0, 1.5), ("lift", 1.5, 3.0)]),
        ([0, 1, 3, 3, 4], [("approach", 0.0, 0.5), ("close", 0.5, 1.0), ("rescue", 1.0, 2.0)]),
        ([0, 0, 1, 1], [("approach", 0.0, 1.0), ("close", 1.0, 1.5)]),
        ([0, 0, 0], [("approach", 0.0, 1.0)]),
        ([0, 0, 1], [("approach", 0.0, 1.0)]),
    ],
    ids=["done", "rescued", "out of time", "only one", "ends as one begins"],
)
def test_spans(numbers: list[int], expected: list[tuple[str, float, float]]) -> None:
    data = xr.Dataset({"task.phase": ("time", np.array(numbers, dtype=float))})
    recording = Recording(data.assign_coords(time=0.5 * np.arange(len(numbers))))
    spans = phase_spans(recording, PHASES)
    assert [(span.phase.name, span.begin, span.end) for span in spans] == expected
