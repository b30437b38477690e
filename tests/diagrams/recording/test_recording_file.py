"""Files of recordings: compressed, written signal by signal, and nothing outside of them is read."""

import tracemalloc

import h5py
import numpy as np
import pytest
import xarray as xr
from refusals import refused

from soft_gripper.diagrams.recording import Recording
from soft_gripper.errors import InputError

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
