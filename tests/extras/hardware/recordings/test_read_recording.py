"""Files -> arrays: units, frame B, names of files, several runs, instruments, and where files are looked for."""

import numpy as np
import pytest
from hardware_files import DESCRIPTION, MARKERS, swinging, whys, write_csv
from refusals import refused

from soft_gripper.extras.hardware.recordings import find_recordings, read_recording, read_recordings


def test_markers_are_metres_in_frame_b(tmp_path, describe):
    """With z along -y of the recording and x along its x, B is a rotation about x: y_B = z_B x x_B = +z."""
    config = describe()
    config.frame.origin, config.frame.z = [0.01, 0.0, 0.0], [0.0, -3.0, 0.0]
    recording = read_recording(write_csv(tmp_path / "a.csv", swinging()), config)
    x, y, z = np.array(MARKERS["base_1"]) * 1e-3
    np.testing.assert_allclose(recording.markers["base_1"][0], [x - 0.01, z, -y], atol=1e-12)
    np.testing.assert_allclose(recording.time, np.arange(200) / 100)
    assert recording.notes == ()


def test_the_reference_is_the_mean_over_its_span(tmp_path, describe):
    recording = read_recording(write_csv(tmp_path / "a.csv", swinging()), describe("reference: 0.3"))
    mean = 10e-3 * np.sin(5 * np.arange(31) / 100).mean()
    np.testing.assert_allclose(recording.reference["tip_1"], [0.010 + mean, 0.020, 0.100])


def test_gravity_turns_with_the_frame(tmp_path, describe):
    config = describe("gravity: [0, 0, -9.81]")
    config.frame.z = [0.0, 0.0, -1.0]
    recording = read_recording(write_csv(tmp_path / "a.csv", swinging()), config)
    np.testing.assert_allclose(recording.gravity, [0, 0, 9.81])


@pytest.mark.parametrize(
    ("name", "pressure", "mass"),
    [
        ("35kPa", 35e3, 0.0),
        ("day2_150mbar", 15e3, 0.0),
        ("load_101g", None, 0.102),
        ("load_52g_again", None, 0.052),
        ("gravity", None, 0.0),
    ],
)
def test_what_a_name_says(tmp_path, describe, name, pressure, mass):
    lines = r"""
commanded_pressure: [{pattern: '{number}kPa', unit: kPa}, {pattern: '{number}mbar', unit: mbar}]
load: {pattern: 'load_{number}g', masses: {'101': 0.102}}
"""
    recording = read_recording(write_csv(tmp_path / f"{name}.csv", swinging()), describe(lines))
    assert recording.commanded_pressure == pressure
    assert recording.load_mass == pytest.approx(mass)


def test_poses_pressures_and_lengths(tmp_path, describe):
    """A body that has turned by 90 degrees about y; psi, V and ms; wires by name; the base, as it was, as origin."""
    time = np.arange(50) / 10
    ones, half = np.ones(50), np.sqrt(0.5) * np.ones(50)
    columns = {
        "time": 1e3 * time,
        **{f"b{axis}": ones + (axis == "x") * 0.1 * (time > 1) for axis in "xyz"},
        **{f"t{axis}": ones + (axis == "z") * 0.2 for axis in "xyz"},
        **{"qw": half, "qx": 0 * ones, "qy": half, "qz": 0 * ones},
        **{"p": 10 * ones, "l": 1 + 0.1 * time, "iw": ones, "io": 0 * ones},
    }
    config = describe(
        text="""
length: 0.2
time_unit: ms
poses:
  base: {position: [bx, by, bz], quaternion: [iw, io, io, io]}
  tip: {position: [tx, ty, tz], quaternion: [qw, qx, qy, qz]}
pressures: {columns: [p], unit: psi}
lengths: {wires: {left: {column: l}}, unit: V, scale: 0.2, spacing: 0.04}
"""
    )
    recording = read_recording(write_csv(tmp_path / "arm.csv", columns), config)
    np.testing.assert_allclose(recording.time, time)
    np.testing.assert_allclose(recording.poses["tip"].p[-1], [0, 0, 0.2], atol=1e-12)
    by_y = [[0, 0, 1], [0, 1, 0], [-1, 0, 0]]  # a quarter turn about y: z lies along x, and x against z
    np.testing.assert_allclose(recording.poses["tip"].R[0], by_y, atol=1e-12)
    np.testing.assert_allclose(recording.pressures[:, 0], 68947.57293168)
    np.testing.assert_allclose(recording.lengths["left"], 0.2 + 0.02 * time)


def test_gaps_are_reported_and_kept_as_nan(tmp_path, describe):
    columns = swinging()
    columns["tip_1_x_mm"][50:60] = np.nan
    for axis in "xyz":
        columns[f"tip_2_{axis}_mm"][:31] = 0.0  # as some systems write what they do not see
    recording = read_recording(write_csv(tmp_path / "a.csv", columns), describe())
    assert np.isnan(recording.markers["tip_1"][50:60]).all()
    assert np.isfinite(recording.markers["tip_1"][60:]).all()
    gap = "they are missing, the first at 0.50 s; the longest gap is 0.11 s"
    assert f"10 of 200 samples of tip_1: {gap}" in whys(recording)
    assert "the reference of tip_2: it is not seen in the reference span" in whys(recording)


def test_rows_that_do_not_parse_are_counted(tmp_path, describe):
    path = write_csv(tmp_path / "a.csv", swinging())
    lines = path.read_text().splitlines()
    lines[5], lines[9] = lines[5].replace(",", ",[").replace("\n", "]"), "what is this"
    lines[12] = lines[12] + ",1"
    path.write_text("\n".join(lines))
    recording = read_recording(path, describe())
    assert len(recording.time) == 198
    assert whys(recording) == ["2 of 200 rows: the first of them, row 10, has 1 cells, and there are 13 columns"]


@pytest.mark.parametrize("how", ["ambient: 101.325", "zeroed: true"])
def test_a_pressure_against_vacuum_becomes_relative(tmp_path, describe, how):
    above = 0.6 * (np.arange(200) > 100)
    path = write_csv(tmp_path / "a.csv", swinging() | {"kPa": 101.325 + above})
    found = read_recording(path, describe(f"pressures: {{ columns: [kPa], unit: kPa, {how} }}")).pressures[:, 0]
    np.testing.assert_allclose(found, 1e3 * above, atol=1e-6)


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


@pytest.fixture
def data(tmp_path):
    (tmp_path / "mine").mkdir()
    write_csv(tmp_path / "mine/run.csv", swinging())
    (tmp_path / "mine.yaml").write_text(DESCRIPTION)
    return tmp_path


def test_below_the_data_folder_or_that_of_the_environment(data, monkeypatch):
    for file in ("mine/run.csv", "run.csv"):
        (found,) = find_recordings([file], str(data / "mine.yaml"), data)
        assert found.name == "run"
    monkeypatch.setenv("SOFT_GRIPPER_DATA", str(data))
    assert len(find_recordings(["run.csv", "mine/run.csv"], str(data / "mine.yaml"))) == 2


def test_a_description_beside_the_file(data):
    file = [str(data / "mine/run.csv")]
    with refused("description", None):
        find_recordings(file)
    for name in ("recording.yaml", "run.yaml"):
        (data / "mine" / name).write_text(DESCRIPTION)
        assert len(find_recordings(file)) == 1


def test_no_file(data, monkeypatch):
    monkeypatch.delenv("SOFT_GRIPPER_DATA", raising=False)
    for files, given in ((["walk.csv"], (str(data / "mine.yaml"), data)), (["walk.csv"], ("x.yaml",)), ([], ())):
        with refused("FILE", files[0] if files else []):
            find_recordings(files, *given)
