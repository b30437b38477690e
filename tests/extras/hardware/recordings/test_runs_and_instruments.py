"""Several runs in a file, and columns of instruments beside the sensors."""

import numpy as np
import pytest
from hardware_files import swinging, whys, write_csv
from refusals import refused

from soft_gripper.extras.hardware.recordings import find_recordings, read_recording, read_recordings


def paused(pause=100.0, runs=3):
    """Runs of two seconds, with pauses between."""
    columns = swinging()
    parts = [{**columns, "time_s": columns["time_s"] + i * (pause + 2)} for i in range(runs)]
    return {name: np.concatenate([part[name] for part in parts]) for name in columns}


def test_a_pause_begins_another_run(tmp_path, describe):
    path = write_csv(tmp_path / "a.csv", paused())
    runs = read_recordings(path, describe("pause: 5"))
    alone = read_recording(write_csv(tmp_path / "b.csv", swinging()), describe())
    assert [run.name for run in runs] == ["a_1", "a_2", "a_3"]
    for run in runs:
        np.testing.assert_allclose(run.markers["tip_1"], alone.markers["tip_1"])
    assert runs[1].time[0] == pytest.approx(102)


def test_time_that_begins_anew_begins_another_run(tmp_path, describe):
    path = write_csv(tmp_path / "a.csv", paused(pause=-2.0))
    describe("pause: 5")
    runs = find_recordings([str(path)], str(tmp_path / "described.yaml"))
    assert [len(run.time) for run in runs] == [200] * 3


def test_pauses_up_to_that_are_within_a_run(tmp_path, describe):
    (run,) = read_recordings(write_csv(tmp_path / "a.csv", paused()), describe("pause: 200"))
    assert (run.name, len(run.time)) == ("a", 600)


def test_without_a_pause_described_a_file_is_one_run(tmp_path, describe):
    path = write_csv(tmp_path / "a.csv", paused())
    with refused("time_s") as caught:
        read_recordings(path, describe())
    assert "a gap of more than 60 s before row 202" in str(caught.value)
    with refused("pause", 5.0) as caught:
        read_recording(path, describe("pause: 5"))
    assert "the file has 3 runs" in str(caught.value)


@pytest.mark.parametrize(
    ("unit", "size", "apart"),
    [("min", 60, "167 us"), ("h", 3600, "2.78 us"), ("d", 86400, "116 ns"), ("ms", 1e-3, "10 s")],
)
def test_a_unit_of_time_that_is_not_stated_is_questioned(tmp_path, describe, unit, size, apart):
    columns = swinging()
    columns["time_s"] = 46351 + columns["time_s"] / size
    path = write_csv(tmp_path / "a.csv", columns)
    with refused("time_s") as caught:
        read_recording(path, describe())
    assert f"samples are {apart} apart: is `time_unit` right?" in str(caught.value)
    found = read_recording(path, describe(f"time_unit: {unit}")).time
    np.testing.assert_allclose(found - found[0], np.arange(200) / 100, atol=1e-6)


@pytest.mark.parametrize("step", [1e-4, 10.0])
def test_a_unit_of_time_that_is_stated_is_believed(tmp_path, describe, step):
    columns = swinging()
    columns["time_s"] *= step / 0.01
    found = read_recording(write_csv(tmp_path / "a.csv", columns), describe("time_unit: s"))
    assert found.time[1] == pytest.approx(step)


def test_times_of_zero_before_a_clock_is_set_are_left_out(tmp_path, describe):
    columns = swinging()
    columns["time_s"] += 1.6e9
    columns["time_s"][:10] = 0
    found = read_recording(write_csv(tmp_path / "a.csv", columns), describe())
    np.testing.assert_allclose(found.time, np.arange(190) / 100, atol=1e-6)
    assert whys(found) == ["10 of 200 rows: their time is 0: the clock was set before row 12"]


def test_a_clipped_length_is_noted(tmp_path, describe):
    columns = swinging()
    columns |= {"one": 100 + 10 * np.sin(5 * columns["time_s"]), "two": 90 + 9 * np.sin(5 * columns["time_s"])}
    columns["two"] = np.minimum(columns["two"], 94)
    of = "lengths: {wires: {one: {column: one}, two: {column: two, side: outer}}, unit: mm, spacing: 0.04}"
    found = read_recording(write_csv(tmp_path / "a.csv", columns), describe(of))
    share = 100 * np.mean(columns["two"] == 94)
    assert whys(found) == [f"length two = 0.094: has its largest value in {share:.0f} % of the samples: is it clipped?"]


def test_a_row_alone_is_no_run(tmp_path, describe):
    columns = paused(runs=2)
    columns["time_s"][250:] += 1000
    columns["time_s"][251:] += 1000
    with refused("time_s") as caught:
        read_recordings(write_csv(tmp_path / "a.csv", columns), describe("pause: 5"))
    assert "is a run by itself in row 252" in str(caught.value)


@pytest.mark.parametrize(
    ("kind", "unit", "size"),
    [
        *(("force", "gf", 9.80665e-3), ("force", "mN", 1e-3), ("force", "lbf", 4.4482216)),
        *(("torque", "N mm", 1e-3), ("angle", "deg", np.pi / 180)),
    ],
)
def test_units_signs_and_places_are_the_models(tmp_path, describe, kind, unit, size):
    columns = swinging()
    columns["measured"], columns["at"] = np.linspace(0, 10, 200), np.linspace(0, 8, 200)
    columns["measured"][3] = np.nan
    of = f"measured_{kind}: {{column: measured, unit: {unit}, sign: -1, place_column: at, place_unit: cm}}"
    found = read_recording(write_csv(tmp_path / "a.csv", columns), describe(of)).measured[kind]
    np.testing.assert_allclose(found.value, -size * columns["measured"])
    np.testing.assert_allclose(found.place, 0.01 * columns["at"])
