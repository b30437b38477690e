"""netCDF files of others as tables."""

import numpy as np
import pytest
import xarray as xr
from refusals import refused

from soft_gripper.diagrams.recording_file import write_netcdf
from soft_gripper.extras.hardware.table import Columns
from soft_gripper.extras.hardware.table_files import read_table


def write_netcdf_3(data, path):
    data.to_netcdf(path, engine="scipy")


@pytest.fixture(params=[write_netcdf_3, write_netcdf])
def file(tmp_path, request):
    """Variables of one and of three dimensions, the last not over time, and a clock with a date."""
    data = {
        "p": ("t", [1.0, 2.0, np.nan]),
        "a": (("row", "t", "column"), np.arange(12.0).reshape(2, 3, 2)),
        "constant": ("row", [7.0, 8.0]),
    }
    clock = np.datetime64("2026-11-24T10:00:00", "ns") + np.array([0, 10, 25], "m8[ms]")
    found = xr.Dataset(data, {"t": [0.0, 0.1, 0.2], "clock": ("t", clock)})
    request.param(found, tmp_path / "a.nc")
    return tmp_path / "a.nc"


def test_columns_are_variables_over_the_time(file):
    table = read_table(file, Columns(dict.fromkeys(["p", "clock", "a[1,0]", "a[0,1]"], "readings"), "t"))
    np.testing.assert_array_equal(table.columns(["p"])[:, 0], [1.0, 2.0, np.nan])
    np.testing.assert_array_equal(table.columns(["a[1,0]", "a[0,1]"]), [[6, 1], [8, 3], [10, 5]])


def test_dates_are_counted_from_the_first(file):
    np.testing.assert_allclose(read_table(file, Columns({}, "clock")).columns(["clock"])[:, 0], [0, 0.01, 0.025])
    in_ms = read_table(file, Columns({}, "clock", time_unit=1e-3))
    np.testing.assert_allclose(in_ms.columns(["clock"])[:, 0], [0, 10, 25])


def test_what_has_no_time_is_refused(file):
    with refused("time", "a") as error:
        read_table(file, Columns({}, "a"))
    assert "p" in error.value.expected
    with refused("time", "none"):
        read_table(file, Columns({}, "none"))
