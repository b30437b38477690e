"""Files -> arrays: units, frame B, names of files, and whatever may be wrong with a file."""

import numpy as np
import pytest
from hardware_files import MARKERS, swinging, whys, write_csv

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


@pytest.mark.parametrize("how", ["ambient: 101.325", "zeroed: true"])
def test_a_pressure_against_vacuum_becomes_relative(tmp_path, describe, how):
    above = 0.6 * (np.arange(200) > 100)
    path = write_csv(tmp_path / "a.csv", swinging() | {"kPa": 101.325 + above})
    found = read_recording(path, describe(f"pressures: {{ columns: [kPa], unit: kPa, {how} }}")).pressures[:, 0]
    np.testing.assert_allclose(found, 1e3 * above, atol=1e-6)
