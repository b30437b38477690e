"""Calibration from logs of a bench: raw counts in rows of text or lines of JSON, and what is refused."""

import re

import numpy as np
import pytest
from command_line import soft_gripper
from hardware_files import write_csv
from pydrake.systems.framework import DiagramBuilder

from soft_gripper.diagrams.scene import add_plant
from soft_gripper.estimators.plane import planar_gravity
from soft_gripper.fingers.kinematics import forward_kinematics
from soft_gripper.fingers.statics import resting_angles, softened
from soft_gripper.scenario.calibration_file import load_calibration
from soft_gripper.scenario.scenario_file import load_scenario
from soft_gripper.sensors.sensor_layout import SensorLayout, extension_ratios
from soft_gripper.sensors.strain_errors import StrainErrors, begin, disturb, draw

SCENARIO = """models:
- name: finger
  file: package://soft_gripper/grippers/finger.urdf
gravity: [0, 0, -9.81]
sensor: {sections: 2, period: 0.02, response: [[1.0, 2048], [1.5, 4048]]}
"""
BENCH = """source: "file:log.csv"
format: text
fields: [t, a, b, c, d, p, x, z]
time: t
pressure_unit: kPa
fingers:
  finger: { readings: [a, b, c, d], pressures: [p], tip: [x, z] }
"""
LEVELS = 0, 40, 80, 120, 150, 110, 70, 30, 0, -30, 0, 60, 120, 60, 0  # kPa
ERRORS = StrainErrors(hysteresis=0.01, gain_error=0.03, offset=0.005, drift=1e-3, noise=2e-3)


@pytest.fixture
def bench(tmp_path):
    """A folder with a scenario, a description and a log of raw counts; true gains and offsets."""
    (tmp_path / "one.yaml").write_text(SCENARIO)
    (tmp_path / "bench.yaml").write_text(BENCH)
    scenario = load_scenario(str(tmp_path / "one.yaml"))
    (finger,) = add_plant(DiagramBuilder(), scenario, visuals=False).fingers
    layout, period = SensorLayout(finger.finger, 2), 0.05
    steps = [np.append(np.linspace(p, q, 10), np.full(20, q)) for p, q in zip((0, *LEVELS), LEVELS, strict=False)]
    pressure = np.concatenate(steps)
    gravity = planar_gravity(finger.X_WB.GetAsMatrix34(), np.array(scenario.gravity))
    q = resting_angles(softened(layout.finger, 1.1), 1e3 * pressure, gravity)
    draws = draw(np.random.default_rng(4), (len(q), 4))
    counts = 2048 + 4000 * (disturb(ERRORS, extension_ratios(layout, q), period, draws) - 1)
    tip = forward_kinematics(q, layout.finger.segment_length).points[:, -1]
    rows = np.column_stack([period * np.arange(len(q)), counts.round(), pressure, tip.imag.round(4), tip.real.round(4)])
    np.savetxt(tmp_path / "log.csv", rows, fmt="%.6g", delimiter=",")
    true = begin(ERRORS, draws.run)
    return tmp_path, true.gain, true.offset


def calibrate(folder, log="log.csv", **options):
    given = {"bench": folder / "bench.yaml", "scenario": folder / "one.yaml", "out": folder / "mine.yaml"} | options
    arguments = [part for name, value in given.items() if value is not None for part in (f"--{name}", value)]
    return soft_gripper("calibrate", folder / log, *arguments)


def test_raw_counts_in_rows_of_text_are_calibrated(bench):
    folder, gains, offsets = bench
    result = calibrate(folder)
    assert result.code == 0, result.err
    found = load_calibration(str(folder / "mine.yaml")).fingers["finger"]
    assert found.bend_ratio == pytest.approx(1.1, rel=3e-3)
    np.testing.assert_allclose(found.gains[2:], gains[2:], rtol=5e-3)
    np.testing.assert_allclose(found.offsets, offsets, atol=1e-3)
    assert "the gains of readings 0, 1 are not determined" in result.out
    assert "cannot be told apart" not in result.out
    scenario = load_scenario(str(folder / "one.yaml"), [f"nominal.calibration={folder / 'mine.yaml'}"])
    assert scenario.nominal.calibration is not None


def test_holds_in_which_a_force_is_measured_are_not_taken_for_free(bench):
    """Of one hold of 120 kPa, in which something presses; the scale begins at 0.3 N, which is no contact."""
    folder, *_ = bench
    rows = np.loadtxt(folder / "log.csv", delimiter=",")
    touched = np.arange(90, 120)
    rows[touched, 1:5] += 80
    force = np.full((len(rows), 1), 0.3)
    force[touched] = 0.8
    np.savetxt(folder / "touched.csv", np.hstack([rows, force]), fmt="%.6g", delimiter=",")
    text = BENCH.replace("x, z]\ntime", "x, z, f]\ntime")
    (folder / "blind.yaml").write_text(text)
    (folder / "weighed.yaml").write_text(
        text.replace("tip: [x, z] }", "tip: [x, z], measured_force: { column: f, unit: N, place: 0.1 } }")
    )
    blind, weighed = (calibrate(folder, "touched.csv", bench=folder / name) for name in ("blind.yaml", "weighed.yaml"))
    assert "does not fit free bending" in blind.out
    assert weighed.code == 0, weighed.err
    assert "does not fit free bending" not in weighed.out
    found = load_calibration(str(folder / "mine.yaml")).fingers["finger"]
    assert found.bend_ratio == pytest.approx(1.1, rel=3e-3)


def test_what_is_looked_for_is_printed_and_written(bench):
    folder, *_ = bench
    arguments = ["--bench", folder / "bench.yaml", "--scenario", folder / "one.yaml", "--out", folder / "mine.yaml"]
    result = soft_gripper("calibrate", folder / "log.csv", *arguments, "--find", "pressure", "response")
    assert result.code == 0, result.err
    assert "pressure offset" in result.out
    assert "response curvature" in result.out
    found = load_calibration(str(folder / "mine.yaml")).fingers["finger"]
    assert abs(found.pressure_offset) < 3 * found.pressure_offset_std < 1000
    assert abs(found.response_curvature) < 3 * found.response_curvature_std < 0.2


def changed(folder, old, new, file="bench.yaml"):
    (folder / file).write_text((folder / file).read_text().replace(old, new))


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("finger: { readings", "thumb: { readings", "the scenario has no such finger; it has finger"),
        ("[a, b, c, d], pressures", "[a, b, c], pressures", "give 4, as many as the scenario's sensors have"),
        ("pressures: [p]", "pressures: []", "give the one pressure that bends the finger"),
        ("time: t\n", "", "a log needs the time of every row"),
        (
            "fields: [t, a, b, c, d, p, x, z]",
            "fields: [t, a, b, c, d, p, x, y, z]",
            "has 8 cells, and there are 9 columns",
        ),
        ("tip: [x, z]", "tip: [x]", "tip"),
    ],
)
def test_descriptions_that_do_not_fit_are_refused(bench, old, new, message):
    folder, *_ = bench
    changed(folder, old, new)
    result = calibrate(folder)
    assert result.code == 2
    assert message in result.err
    assert not (folder / "mine.yaml").exists()


def test_logs_that_do_not_fit_are_refused(bench):
    folder, *_ = bench
    rows = (folder / "log.csv").read_text().splitlines()
    (folder / "back.csv").write_text("\n".join([*rows, rows[0]]))
    assert "times must increase" in calibrate(folder, "back.csv").err
    (folder / "gap.csv").write_text("\n".join([*rows[:-1], rows[-1].replace(",0,", ",,")]))
    assert "give a pressure" in calibrate(folder, "gap.csv").err
    assert "logs need --scenario" in calibrate(folder, scenario=None).err
    assert "either --bench or --as" in calibrate(folder, **{"as": folder / "bench.yaml"}).err


@pytest.mark.parametrize("clipped", [True, False])
def test_a_reading_that_is_clipped_or_dead_is_refused(bench, clipped):
    """Fitted, it would have another gain."""
    folder, *_ = bench
    rows = np.loadtxt(folder / "log.csv", delimiter=",")
    rows[:, 4] = np.minimum(rows[:, 4], np.quantile(rows[:, 4], 0.7).round()) if clipped else 2048
    np.savetxt(folder / "stuck.csv", rows, fmt="%.6g", delimiter=",")
    result = calibrate(folder, "stuck.csv")
    assert result.code == 2
    assert not (folder / "mine.yaml").exists()
    said = (
        r"reading 3 has its largest value in (30|31|32) % .* is it clipped\?"
        if clipped
        else "reading 3 .*never changes"
    )
    assert re.search(said, result.err), result.err


RECORDING = """time: t
readings: [a, b, c, d]
pressures: {columns: [p], unit: kPa}
markers: {columns: "{marker}_{axis}", bodies: {tip: [tip]}, unit: m}
frame: {origin: [0.1, -0.2, 0.3], z: [0, 0, 1], x: [0, 1, 0]}
length: 0.1
"""  # the marker in the axes of a camera


def columns_of(folder):
    """The columns of the log, and the marker at the tip."""
    rows = np.loadtxt(folder / "log.csv", delimiter=",")
    columns = dict(zip(("t", "a", "b", "c", "d", "p", "x", "z"), rows.T, strict=True))
    x, z = columns.pop("x"), columns.pop("z")
    return columns | {"tip_x": 0.1 + 0 * x, "tip_y": x - 0.2, "tip_z": z + 0.3}


def test_a_recording_of_the_tip_says_the_same(bench):
    """Its own gravity counts, in its own axes: without any the finger would seem to bend further or less."""
    folder, *_ = bench
    found = [calibrated(folder, "log.csv")]
    write_csv(folder / "log_2.csv", columns_of(folder))
    changed(folder, "gravity: [0, 0, -9.81]", "gravity: [0, 0, 0]", "one.yaml")
    for gravity in ("gravity: [0, 0, -9.81]\n", ""):
        (folder / "recording.yaml").write_text(RECORDING + gravity)
        found.append(calibrated(folder, "log_2.csv", **{"bench": None, "as": folder / "recording.yaml"}))
    text, same, weightless = found
    np.testing.assert_allclose(same.gains, text.gains, rtol=1e-5)
    np.testing.assert_allclose(same.offsets, text.offsets, atol=1e-6)
    assert same.bend_ratio == pytest.approx(text.bend_ratio, rel=1e-5)
    assert weightless.bend_ratio != pytest.approx(text.bend_ratio, rel=1e-3)
    assert same.tip_measured


def calibrated(folder, log, **options):
    result = calibrate(folder, log, **options)
    assert result.code == 0, result.err
    return load_calibration(str(folder / "mine.yaml")).fingers["finger"]
