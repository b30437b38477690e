"""Several runs in a file, and columns of instruments beside the sensors."""

import numpy as np
import pytest
from hardware_files import swinging, write_csv
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
