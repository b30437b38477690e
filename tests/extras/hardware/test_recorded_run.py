"""A recording is read with its scenario and its fingers; a file that is not one, or is damaged, is refused."""

from dataclasses import astuple

import numpy as np
import pytest
import xarray as xr
from refusals import refused

from soft_gripper.diagrams.recording import Recording
from soft_gripper.diagrams.simulation import simulate
from soft_gripper.errors import InputError
from soft_gripper.extras.hardware.calibration import calibrate_recordings
from soft_gripper.extras.hardware.finger_logs import load_run, read_signal
from soft_gripper.scenario.scenario_file import load_scenario

STEPS = ("pressure.steps.all=[0, 180e3]", "pressure.settle=0.6", "pressure.hold_samples=10", "sensor.sections=2")
CALIBRATED_BY = ("strain", "sampled_pressure", "X_WB")


def test_scenario_and_fingers_come_back(tmp_path):
    overrides = ["pressure.steps.all=[0]", "pressure.settle=0.02", "pressure.hold_samples=2", "sensor.sections=3"]
    simulate(load_scenario("free_bending", overrides)).save(tmp_path / "recording.nc")
    recording, scenario, fingers = load_run(tmp_path / "recording.nc")
    assert [finger.name for finger in fingers] == ["left_finger", "right_finger"]
    assert scenario.sensor.sections == 3
    assert read_signal("file", recording, "left_finger.sampled_joint_angles", 12).shape == (5, 12)
    with refused("signal", "left_finger.temperature"):
        read_signal("file", recording, "left_finger.temperature")


@pytest.fixture(scope="module")
def recorded():
    """What is read of a recording, of one finger."""
    data = simulate(load_scenario("free_bending", STEPS)).data
    return data[[name for name in data if name.partition(".")[2] in CALIBRATED_BY]]


def calibrated(file):
    found = calibrate_recordings([file]).fingers.values()
    return [(*astuple(finger)[4:-1], *(astuple(finger.fitted)[1:5] if finger.fitted else ())) for finger in found]


@pytest.mark.parametrize(
    ("change", "field", "value"),
    [
        (lambda data: data.assign_coords(time=data["time"] + 1e9 * (data["time"] > 1)), "time[101]", 1e9 + 1.01),
        (lambda data: data.assign_coords(time=data["time"] + 0.015 * (data["time"] > 0.505)), "time[51]", 0.525),
        (lambda data: data.isel(time=slice(None, None, -1)), "time[0]", 1.39),
        (lambda data: data.rename_dims(time="x"), "time", "float64 ('x',)"),
        (lambda data: data.assign_attrs(scenario=1.5), "scenario", 1.5),
        (lambda data: data.isel(section=slice(0, 1)), "left_finger.strain", "float64 (140, 2, 1)"),
        (lambda data: data.drop_vars("left_finger.X_WB"), "signal", "left_finger.X_WB"),
        (lambda data: data + np.inf, "left_finger.sampled_pressure", np.inf),
    ],
)
def test_the_signal_and_its_value_are_named(recorded, tmp_path, change, field, value):
    with xr.set_options(keep_attrs=True):
        Recording(change(recorded)).save(tmp_path / "recording.nc")
    with pytest.raises(InputError) as error:
        calibrated(tmp_path / "recording.nc")
    assert error.value.field == field
    assert error.value.value == (value if isinstance(value, str) else pytest.approx(value))


def test_samples_may_be_missing_only_where_a_sensor_can_drop_out(recorded, tmp_path):
    recording = Recording(recorded.copy(deep=True))
    recording["left_finger.strain"][3] = np.nan
    assert np.isnan(read_signal("file", recording, "left_finger.strain", 2, 2, allow_nan=True)[3]).all()
    with pytest.raises(InputError) as error:
        read_signal("file", recording, "left_finger.strain", 2, 2)
    assert error.value.field == "left_finger.strain"


@pytest.mark.parametrize("kind", ["missing", "folder", "text", "HDF5"])
def test_a_file_that_is_not_a_recording_is_refused_in_one_sentence(tmp_path, kind):
    file = tmp_path / "recording.nc"
    if kind == "folder":
        file.mkdir()
    elif kind != "missing":
        file.write_bytes({"text": b"time,strain\n0,1\n", "HDF5": b"\x89HDF\r\n\x1a\n"}[kind])
    with pytest.raises(InputError) as error:
        load_run(file)
    assert error.value.field == "file"
    assert "\\n" not in str(error.value)
