"""A finger that presses on a scale: its contact force and external torque compared with what the scale reads."""

from dataclasses import replace

import numpy as np
import pytest
import xarray as xr
from command_line import soft_gripper
from csv_rows import csv_rows
from refusals import refusal
from scale_files import DRIFT, FORCES, GRAM, LATE, PERIOD, RAMP, ZERO, write_log

from soft_gripper.diagrams.recording import Recording
from soft_gripper.estimators.mechanics import Mechanics
from soft_gripper.estimators.uncertainty import Uncertainty
from soft_gripper.extras.hardware.finger_logs import load_log, read_finger_logs
from soft_gripper.extras.hardware.replay.measured_scores import _lasting_band, _torque_std, replay_measured
from soft_gripper.extras.hardware.scoring import NORMAL_95
from soft_gripper.load.force_estimator import DELAY
from soft_gripper.sensors.calibrated_states import CalibratedStates
from soft_gripper.sensors.fitted_states import FittedStates, Widths
from soft_gripper.sensors.sensor_layout import SensorLayout

PRESSED = [force for forces in FORCES.values() for force in forces]
PLACES = [1e3 * place for place, forces in FORCES.items() for _ in forces]


@pytest.fixture(scope="module")
def log(tmp_path_factory):
    return write_log(tmp_path_factory.mktemp("scale"))


def logs(log, bench="bench.yaml", described_as=None):
    folder = log.parent
    how = load_log(str(folder / "one.yaml"), folder / bench if bench else None, described_as, "replay")
    return read_finger_logs(log, how), how.scenario


def replayed(log, bench="bench.yaml", estimators=("contact",)):
    return replay_measured(*logs(log, bench), estimators)


@pytest.fixture(scope="module")
def found(log):
    return replayed(log)


def rows(found, quantity):
    return [row for row in found.presses if row.quantity == quantity]


def test_each_press_is_compared(found):
    forces = rows(found, "contact force")
    assert [row.recording for row in forces] == ["press_1"] * 3 + ["press_2"] * 3
    assert [row.place_mm for row in forces] == pytest.approx(PLACES)
    np.testing.assert_allclose([row.measured for row in forces], PRESSED, atol=1.5 * GRAM)
    np.testing.assert_allclose([row.estimated for row in forces], PRESSED, atol=0.04)
    for row in forces:
        assert row.least <= row.estimated <= row.most
        assert row.within_band_percent == 100


def test_the_band_of_a_torque_counts_a_drive_that_varies_along_the_finger(shipped_finger):
    """Of joints that are known exactly, by shares of the driving torque: common, linear and quadratic."""
    data = {
        "finger.joint_angle_covariance": (("time", "joint", "joint2"), np.zeros((2, 12, 12))),
        "sampled_pressure": (("time",), np.full(2, 80e3)),
    }
    mechanics = Mechanics(SensorLayout(shipped_finger, 2), Uncertainty(bend_per_pressure=0.05, bend_variation=0.1))
    joint = np.array([0, 11])
    found = _torque_std(Recording(xr.Dataset(data)), "finger", joint, mechanics)
    x = 2 * shipped_finger.joint_arc_lengths[joint] / shipped_finger.length - 1
    shares = np.sqrt(0.05**2 + (0.1 * x) ** 2 + (0.06 * (1.5 * x**2 - 0.5)) ** 2)
    np.testing.assert_allclose(found, shares * shipped_finger.pressure_torque(80e3)[joint], rtol=1e-12)


def test_a_common_scale_of_finger_and_sensors_is_no_error_of_a_torque(shipped_finger):
    """A finger that bends further is as much softer: a band of 3 % of the bend leaves none of the torque."""
    layout, q = SensorLayout(shipped_finger, 2), np.full((2, 12), 0.04)
    states = CalibratedStates(
        FittedStates(np.zeros((1, 7)), np.ones(7)), Widths(np.zeros(1), 0.0), np.inf, 2, bend_std=0.03
    )
    mechanics = Mechanics(replace(layout, calibrated=states), Uncertainty(bend_per_pressure=0.0))
    known = 1e-3**2 * np.eye(12)
    data = {
        "finger.joint_angle_covariance": (("time", "joint", "joint2"), known + mechanics.scale_covariance(q)),
        "finger.estimated_joint_angles": (("time", "joint"), q),
        "finger.state_distance": (("time", "part"), np.zeros((2, 3))),
        "sampled_pressure": (("time",), np.full(2, 80e3)),
    }
    found = _torque_std(Recording(xr.Dataset(data)), "finger", np.array([0, 11]), mechanics)
    np.testing.assert_allclose(found, 1e-3 * shipped_finger.stiffness[[0, 11]], rtol=1e-9)


@pytest.mark.parametrize(("noise", "lasting"), [(0.0, 0.02), (0.03, 0.02), (0.03, 0.0)])
def test_the_noise_of_samples_averages_out_in_the_band_of_a_median(noise, lasting):
    samples = 0.5 + noise * np.tile([-1.0, 1.0], 200)
    half = NORMAL_95 * np.hypot(noise, lasting)
    least, most = _lasting_band(0.5, 0.5 - half, 0.5 + half, samples)
    expected = NORMAL_95 * max(lasting, noise / 20)
    assert (least, most) == pytest.approx((0.5 - expected, 0.5 + expected))


def test_a_finger_rests_half_a_second_after_its_pressure_is_steady(found):
    rest = found.runs[0].rest.reshape(2 * len(FORCES[0.07]) + 1, -1)  # by the pressures that it is held at
    begin = round((RAMP + 0.5) / PERIOD)
    assert not rest[1:, 1 : begin - 1].any()
    assert rest[1:, begin + 1 :].all()


def test_delay_zero_and_drift_of_the_scale_are_found(found):
    """External torque belongs to the sample two before, which shortens the delay."""
    scale = found.instruments["force"]
    assert scale.delay == pytest.approx(LATE - DELAY * PERIOD, abs=0.021)
    assert scale.drift == pytest.approx(DRIFT * GRAM, rel=0.2)
    np.testing.assert_allclose(scale.zeros, ZERO * GRAM, atol=0.5 * GRAM)


def test_the_torque_at_the_base_is_that_of_the_force(found):
    """The lever is that of the estimated shape; the torque that of ideal sensors."""
    torques = rows(found, "base torque")
    for row, force in zip(torques, PRESSED, strict=True):
        assert row.estimated == pytest.approx(row.measured, rel=0.1)
        assert np.sign(row.estimated) == -np.sign(force)  # what presses on the inner side holds the finger open
        assert row.within_band_percent == 100


def test_scores_are_those_of_the_presses(found):
    score = next(score for score in found.scores if score.quantity == "contact force")
    errors = [abs(row.estimated - row.measured) for row in rows(found, "contact force")]
    assert (score.presses, score.answered) == (6, 6)
    assert score.median_error == pytest.approx(np.median(errors))
    assert score.ratio == pytest.approx(1, abs=0.08)
    z = [3.92 * (row.estimated - row.measured) / (row.most - row.least) for row in rows(found, "contact force")]
    assert score.rms_z == pytest.approx(np.sqrt(np.mean(np.square(z))), rel=1e-3)
    widths = [(row.most - row.least) / abs(row.measured) for row in rows(found, "contact force")]
    assert score.median_width_percent == pytest.approx(100 * np.median(widths))
    assert score.within_band_percent == 100


def test_a_force_along_an_axis_is_a_part_of_that_across_the_finger(log, found):
    """Of a finger that turns by less than 60 degrees, more than half of the force is along x of the base."""
    text = (log.parent / "bench.yaml").read_text()
    (log.parent / "tilted.yaml").write_text(text.replace("place_unit: mm", "place_unit: mm, along: [-1, 0]"))
    tilted = rows(replayed(log, "tilted.yaml"), "contact force")
    straight = rows(found, "contact force")
    for row, across in zip(tilted, straight, strict=True):
        assert row.measured == across.measured
        assert 0.5 < row.estimated / across.estimated < 1.0


def test_torque_and_angle_are_compared_at_their_places(log):
    text = (log.parent / "bench.yaml").read_text()
    begin = text.index("    measured_force")
    more = (
        "    measured_torque: { column: base, unit: N m, place: 0 }\n"
        "    measured_angle: { column: turn, unit: rad, place_column: mm, place_unit: mm }\n"
    )
    (log.parent / "others.yaml").write_text(text[:begin] + more)
    found = replayed(log, "others.yaml", estimators=("gaussian",))
    torques, angles = rows(found, "torque"), rows(found, "angle")
    for row in torques:
        assert row.estimated == pytest.approx(row.measured, rel=0.1)
    assert len(torques) == 6
    assert len(angles) > 6  # some of a finger that is free, too
    for row in angles:
        assert row.estimated == pytest.approx(row.measured, abs=0.02)
        assert row.within_band_percent >= 90


def test_the_command_writes_presses_scores_figure_and_signals(log, tmp_path):
    folder = log.parent
    how = ["--bench", folder / "bench.yaml", "--scenario", folder / "one.yaml", "--out", tmp_path / "out"]
    outcome = soft_gripper("replay", log, *how, "--estimator", "gaussian")
    assert outcome.code == 0, outcome.err
    assert "force: reads 0.3" in outcome.out
    names = {path.name for path in (tmp_path / "out").iterdir()}
    assert names == {"replay.csv", "scores.csv", "replay.png", "replay.svg", "press_1.nc", "press_2.nc"}
    assert {row["quantity"] for row in csv_rows(tmp_path / "out/replay.csv")} == {"base torque"}
    data = Recording.load(tmp_path / "out/press_1.nc").data
    assert data["measured_force"].attrs["units"] == "N"
    assert data["measured_force"].sizes == data["gaussian.external_torque"][:, 0].sizes


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ("column: scale", "column: sclae", "did you mean 'scale'?"),
        ("column: scale", "column: empty", "is empty, or NaN, everywhere"),
        ("unit: gf", "unit: kgf", "the largest is then"),
        ("unit: gf", "unit: gf, sign: 2", "must be 1 or -1"),
        ("place_unit: mm", "place_unit: cm", "must be on the finger: 0 to 0.12 m from its base"),
        ("place_column: mm, ", "", "give either it or `place_column`"),
        ("place_unit: mm", "along: [0, 0]", "must be a direction"),
    ],
)
def test_descriptions_that_do_not_fit_are_refused(log, tmp_path, monkeypatch, old, new, said):
    monkeypatch.chdir(tmp_path)
    names = "t,a,b,c,d,p,scale,mm,base,turn,empty\n"
    (tmp_path / "press.csv").write_text(names + "".join(line + ",\n" for line in log.read_text().splitlines()))
    text = (log.parent / "scale.yaml").read_text()
    (tmp_path / "scale.yaml").write_text(
        text.replace("header: [t, a, b, c, d, p, scale, mm, base, turn]\n", "").replace(old, new)
    )
    error = refusal("replay", "press.csv", "--as", "scale.yaml", "--scenario", log.parent / "one.yaml")
    assert said in error
    assert "measured_force" in error
    assert not (tmp_path / "results/replay/replay.csv").exists()


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (["--scenario", "one.yaml"], "either --bench or --as"),
        (["--scenario", "one.yaml", "--bench", "bench.yaml", "--fit", "press.csv"], "leave it out with --scenario"),
        (["--as", "scale.yaml", "--set", "gravity=[0,0,0]"], "give that too"),
    ],
)
def test_options_that_do_not_go_together_are_refused(log, monkeypatch, arguments, said):
    monkeypatch.chdir(log.parent)
    assert said in refusal("replay", "press.csv", *arguments)
