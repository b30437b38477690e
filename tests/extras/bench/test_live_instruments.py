"""A scale beside the sensors of a bench: recorded by `live`, never used by estimators, and read again by `replay`."""

import numpy as np
import pytest
from command_line import soft_gripper
from csv_rows import csv_rows
from refusals import refusal
from scale_files import GRAM, write_log

from soft_gripper.diagrams.recording import Recording

FORCE = "finger.measured_force"
CHANGES = "estimator.type=gaussian"


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    folder = tmp_path_factory.mktemp("bench")
    write_log(folder)
    return folder


def live(folder, log, out, bench="bench.yaml"):
    how = ["--bench", folder / bench, "--source", f"file:{log}", "--sink", f"file:{out}.csv", "--out", out]
    return soft_gripper("live", folder / "one.yaml", *how, "--fast", "--set", CHANGES)


@pytest.fixture(scope="module")
def recorded(folder):
    outcome = live(folder, folder / "press.csv", folder / "out")
    assert outcome.code == 0, outcome.err
    return Recording.load(folder / "out/recording.nc").data


def test_it_is_recorded_in_si_units_with_its_place(folder, recorded):
    rows = np.loadtxt(folder / "press.csv", delimiter=",")
    np.testing.assert_allclose(recorded[FORCE].values, rows[:, [6, 7]] * [GRAM, 1e-3])
    assert recorded[FORCE].attrs["units"] == "N, m"
    assert list(recorded["instrument"].values) == ["value", "place"]


def test_estimates_do_not_depend_on_it(folder, recorded):
    text = (folder / "press.csv").read_text().splitlines()
    (folder / "other.csv").write_text("\n".join(",".join((*line.split(",")[:6], "0,0,0,0")) for line in text))
    assert live(folder, folder / "other.csv", folder / "without").code == 0
    other = Recording.load(folder / "without/recording.nc").data
    assert not other[FORCE].values.any()
    for name in ("finger.tip_pose", "finger.external_torque"):
        np.testing.assert_array_equal(other[name], recorded[name])


def test_such_a_recording_is_replayed(folder, recorded, tmp_path):
    """netCDF is a table of columns; a session has one clock, in which the pause has no length."""
    (tmp_path / "live.yaml").write_text("""time: time
length: 0.12
readings: ["finger.strain[0,0]", "finger.strain[0,1]", "finger.strain[1,0]", "finger.strain[1,1]"]
pressures: { columns: [finger.sampled_pressure], unit: Pa }
measured_force: { column: "finger.measured_force[0]", unit: N, place_column: "finger.measured_force[1]" }
frame: { origin: [0, 0, 0] }
""")
    how = ["--as", tmp_path / "live.yaml", "--scenario", folder / "one.yaml", "--estimator", "gaussian"]
    outcome = soft_gripper("replay", folder / "out/recording.nc", *how, "--out", tmp_path / "out")
    assert outcome.code == 0, outcome.err
    (score,) = csv_rows(tmp_path / "out/scores.csv")
    assert (score["quantity"], score["presses"], score["answered"]) == ("base torque", "6", "6")
    assert float(score["median_error_percent"]) < 10


def test_a_place_that_is_not_on_the_finger_is_refused_at_once(folder, monkeypatch):
    monkeypatch.chdir(folder)
    text = (folder / "bench.yaml").read_text().replace("place_column: mm, place_unit: mm", "place: 0.2")
    (folder / "beyond.yaml").write_text(text)
    said = refusal("live", folder / "one.yaml", "--bench", folder / "beyond.yaml", "--fast")
    assert "fingers.finger.measured_force.place = 0.2: must be on the finger: 0 to 0.12 m" in said
