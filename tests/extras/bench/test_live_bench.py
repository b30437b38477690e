"""The bench computes what a station does; instruments beside it change nothing."""

import numpy as np
import pytest
from command_line import soft_gripper
from csv_rows import csv_rows
from refusals import refusal
from scale_files import GRAM, write_log

from soft_gripper.diagrams.recording import Recording
from soft_gripper.diagrams.simulation import run_station
from soft_gripper.diagrams.station import make_station
from soft_gripper.diagrams.wiring import estimation
from soft_gripper.extras.bench.bench import Bench
from soft_gripper.scenario.scenario_file import load_scenario

SHORT = ["control.set_points=[0.06, 0.04]", "control.hold=0.5"]


def scenario(*changes):
    return load_scenario("tip_distance_steps", [*SHORT, *changes])


def samples(recording, bench):
    """What the bench measures at every sample of a recording; its first row is before the first sample."""
    signals = {name: name.replace(".pressure", ".sampled_pressure") for name in bench.inputs}
    for row in range(1, recording.data.sizes["time"]):
        yield row, {name: np.ravel(recording[signal].values[row]) for name, signal in signals.items()}


@pytest.mark.parametrize("estimator", ["arcs", "gaussian", pytest.param("recursive", marks=pytest.mark.slow)])
@pytest.mark.parametrize("errors", [(), ("sensor.errors.preset=realistic",)], ids=["ideal", "realistic"])
def test_it_computes_what_the_station_computed(estimator, errors):
    """To rounding, as a station computes two fingers at once. Errors are drawn twice at time 0, as a PID remembers."""
    chosen = scenario(f"estimator.type={estimator}", "control.hold=0.2", *errors)
    recording, bench = run_station(make_station(chosen)), Bench(chosen)
    signals = [name for name in bench.signals if name in recording.data]
    if errors:
        signals = [name for name in signals if not name.endswith("pressure_command")]
    assert {"left_finger.external_torque", "grip.opening", "right_finger.X_WB"} <= set(signals)
    for row, measured in samples(recording, bench):
        bench.step(measured)
        for name, value in bench.read(signals).items():
            expected = np.ravel(recording[name].values[row])
            np.testing.assert_allclose(value, expected, rtol=1e-9, atol=1e-9, err_msg=name)


@pytest.mark.parametrize("estimator", ["contact", "recursive"])
def test_equal_fingers_are_computed_together_as_each_alone(estimator, monkeypatch):
    chosen = scenario(f"estimator.type={estimator}")
    together = Bench(chosen)
    monkeypatch.setattr(estimation, "is_own", lambda _: True)
    alone = Bench(chosen)
    assert together.signals.keys() == alone.signals.keys()
    for i in range(6):
        inputs = {name: np.full(size, 0.01 * i) for name, size in together.inputs.items()}
        inputs["left_finger.strain"] *= 2.0
        for bench in (together, alone):
            bench.step(inputs)
        for name, value in alone.read([*alone.signals]).items():
            np.testing.assert_allclose(together.read([name])[name], value, rtol=1e-9, atol=1e-12, err_msg=name)


@pytest.mark.slow
@pytest.mark.parametrize(("estimator", "trace"), [("gaussian", 0.0), ("recursive", 1e-3)])
def test_missing_samples_leave_little_trace(estimator, trace):
    """A tenth of a second without readings: what has no memory is as ever afterwards, what learns has learnt less."""
    chosen = scenario(f"estimator.type={estimator}")
    recording, whole, holed = run_station(make_station(chosen)), Bench(chosen), Bench(chosen)
    for row, measured in samples(recording, whole):
        whole.step(measured)
        if 30 <= row < 40:
            holed.skip()
        else:
            holed.step(measured)
    tips = [bench.read(["left_finger.tip_pose"])["left_finger.tip_pose"] for bench in (whole, holed)]
    np.testing.assert_allclose(*tips, rtol=0, atol=trace)


def test_free_readings_are_those_of_fingers_that_touch_nothing():
    chosen = scenario("estimator.type=gaussian")
    recording, bench = run_station(make_station(chosen)), Bench(chosen)
    for _, measured in samples(recording, bench):
        bench.step(measured)
    for name, free in bench.free_readings().items():
        np.testing.assert_allclose(free, measured[name], atol=1e-5)
        assert np.abs(free).max() > 0.03


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
