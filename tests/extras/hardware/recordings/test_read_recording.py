"""Files -> arrays: units, frame B, names of files, and whatever may be wrong with a file."""

import numpy as np
import pytest
from hardware_files import MARKERS, published, swinging, whys, write_csv
from refusals import refused

from soft_gripper.errors import InputError
from soft_gripper.extras.hardware.recording_schema import load_description
from soft_gripper.extras.hardware.recordings import read_recording


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


def test_a_header_may_be_described(tmp_path, describe):
    path = write_csv(tmp_path / "a.txt", swinging())
    names, _, rows = path.read_text().partition("\n")
    path.write_text(rows)
    assert len(read_recording(path, describe(f"header: [{names}]")).time) == 200


def changed(**columns):
    return {**swinging(), **columns}


def exchanged(names, span):
    columns = swinging()
    a, b = ({axis: columns[f"{name}_{axis}_mm"].copy() for axis in "xyz"} for name in names)
    for axis in "xyz":
        columns[f"{names[0]}_{axis}_mm"][span], columns[f"{names[1]}_{axis}_mm"][span] = b[axis][span], a[axis][span]
    return columns


TIME = swinging()["time_s"]
SEVEN = {name: values for name, values in swinging().items() if name != "tip_2_y_mm"}
FALLING = changed(tip_1_x_mm=swinging()["tip_1_x_mm"] + 20 * TIME)
LOST = changed(**{f"tip_{i}_{axis}_mm": np.full(200, np.nan) for i in (1, 2, 3) for axis in "xyz"})


@pytest.mark.parametrize(
    ("columns", "said"),
    [
        (SEVEN, "tip_2_y_mm': no such column"),
        (SEVEN, "did you mean 'tip_"),
        (changed(time_s=np.roll(TIME, 50)), "runs backwards in row 52"),
        (changed(time_s=np.floor(TIME)), "most rows repeat a time"),
        ({name: 1000 * v if "mm" in name else v for name, v in swinging().items()}, "markers.unit"),
        ({name: v / 1000 if "mm" in name else v for name, v in swinging().items()}, "is the unit right?"),
        (exchanged(("tip_1", "tip_3"), slice(120, 150)), "tip_1, tip_3': swap names at 1.20, 1.50 s"),
        (exchanged(("tip_1", "base_1"), slice(120, None)), "swap names at 1.20 s"),
        (FALLING, "tip_1, tip_2': their distance changes by"),
        (FALLING, "on one rigid body? Markers along a finger need a body each"),
        (changed(base_1_x_mm=20 + 40 * np.sin(TIME)), "are their markers exchanged?"),
        (LOST, "none of them is ever seen"),
        (changed(time_s=np.full(200, np.nan)), "samples with a time"),
    ],
)
def test_what_cannot_be_is_refused(tmp_path, describe, columns, said):
    with pytest.raises(InputError) as error:
        read_recording(write_csv(tmp_path / "bad.csv", columns), describe())
    assert error.value.where == tmp_path / "bad.csv"
    assert said in str(error.value)


@pytest.mark.parametrize(
    ("column", "row", "value", "said"),
    [
        ("time_s", 100, 1e9, "before row 102, after 0.99"),
        ("tip_1_x_mm", 7, 1e308, "in row 9"),
        ("tip_1_x_mm", 7, -np.inf, "in row 9"),
        ("time_s", 199, np.inf, "in row 201"),
    ],
)
def test_row_and_value_of_a_number_out_of_range_are_named(tmp_path, describe, column, row, value, said):
    columns = swinging()
    columns[column][row] = value
    if column == "time_s":
        columns[column][row:] = value + np.arange(200 - row) / 100
    with pytest.raises(InputError) as error:
        read_recording(write_csv(tmp_path / "bad.csv", columns), describe())
    assert (error.value.field, error.value.value) == (column, value)
    assert said in error.value.expected


@pytest.mark.parametrize("rows", ["", "nothing,here\n", 12 * "," + "\n"])
def test_empty_files_are_refused(tmp_path, describe, rows):
    path = tmp_path / "empty.csv"
    path.write_text(",".join(swinging()) + "\n" + rows)
    with refused("file", "empty.csv"):
        read_recording(path, describe())


def test_a_wrong_pressure_unit_is_named(tmp_path, describe):
    path = write_csv(tmp_path / "a.csv", changed(p=np.full(200, 1e5)))
    with refused("pressures.unit", "bar"):
        read_recording(path, describe("pressures: {columns: [p], unit: bar}"))


def test_a_wrong_scale_of_wires_is_named(tmp_path, describe):
    path = write_csv(tmp_path / "a.csv", changed(wire=1 + TIME))
    with refused("lengths.unit or scale", "V"):
        read_recording(path, describe("lengths: {wires: {a: {column: wire}}, unit: V, scale: 200, spacing: 0.04}"))


@pytest.mark.parametrize("name", ["clamped_beam", "pneumatic_segment", "two_segment_arm"])
def test_published_recordings_are_read_without_gaps(name):
    files = sorted(path for path in published(name).iterdir() if path.suffix in (".csv", ".txt"))
    for path in files:
        recording = read_recording(path, load_description(name))
        assert recording.notes == ()
        assert len(recording.time) > 400
