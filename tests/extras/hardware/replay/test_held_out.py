"""Replays: protocol, leakage, the published recordings, and a table of errors that are worked out by hand."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
import xarray as xr
from hardware_files import published
from refusals import refused

from soft_gripper.errors import InputError
from soft_gripper.extras.hardware.recordings import find_recordings
from soft_gripper.extras.hardware.replay.arm_estimation import arm_recording, stretched_arm
from soft_gripper.extras.hardware.replay.held_out import ALL, BAND, FAR, estimator_rows, replay_recordings, replay_table
from soft_gripper.fingers.kinematics import as_points

DOWN = np.array([0.0, 0.0, 9.81])
ROWS = {"arcs 1": ("arcs", 1), "arcs 2": ("arcs", 2), "gaussian 1": ("gaussian", 1)}


@pytest.fixture(scope="module")
def replayed(arms, arm_finger):
    return replay_recordings(arms, None, ROWS, arm_finger, DOWN).replayed


@pytest.mark.slow
def test_two_arcs_find_an_arm_of_two_arcs(replayed):
    table = {(row.estimator, row.sections): row for row in replay_table(replayed, ROWS) if _is_tip(row)}
    assert table["arcs", 2].mean_mm < 1.5
    assert table["arcs", 1].mean_mm > 20  # bent twice, either way
    assert table["gaussian", 1].mean_mm < 10


def _is_tip(row):
    return row.body == "tip" and row.recording == ALL


@pytest.mark.slow
def test_the_blocks_do_what_the_functions_do(arms, replayed, arm_finger):
    arm, recording = replayed[1].fitted.arm, arms[1]
    theta, length = arm.wires.sections(recording.inner, recording.outer)
    _, bodies, _ = stretched_arm(arm.parts, np.repeat(theta / 6, 6, axis=-1), length, arm_finger.section_ends(2))
    logged = replayed[1].signals["arcs 2.body_positions"].values[1:]  # each as a reader finds it: the sample before
    np.testing.assert_allclose(logged, as_points(bodies)[: len(logged)], atol=1e-4)


def test_zeroed_wires_place_the_bodies_again_and_their_first_seconds_are_not_scored(arms, arm_finger):
    moved = replace(arms[0], inner=arms[0].inner + np.array([0.02, -0.01]))
    rows = {"arcs 2": ("arcs", 2)}
    plain, zeroed = (replay_recordings([moved], arms[1:], rows, arm_finger, DOWN, zero) for zero in (0.0, 0.5))
    assert [found.replayed[0].first for found in (plain, zeroed)] == [1, 27]
    errors = [found.table[-1].mean_mm for found in (plain, zeroed)]
    assert errors[0] > 10 > 2 > errors[1]
    assert zeroed.table[-1].within_band_percent > 90


def test_what_is_reported_is_not_fitted_to(arms, arm_finger):
    with pytest.raises(InputError) as caught:
        replay_recordings(arms[:2], arms[1:], ROWS, arm_finger, DOWN)
    assert (caught.value.field, caught.value.value) == ("--fit", ["run_1"])
    with refused("FILE", ["run_0"]):
        replay_recordings(arms[:1], None, ROWS, arm_finger, DOWN)


def test_estimators_by_name():
    assert list(estimator_rows(["arcs", "gaussian"], 2)) == ["arcs 1", "gaussian 1", "arcs 2", "gaussian 2"]
    own = "own_blocks:contact_again"
    assert estimator_rows([own], 2) == {f"{own} 1": (own, 1), f"{own} 2": (own, 2)}
    with refused("--estimator", "arks"):
        estimator_rows(["arks"], 2)


@pytest.mark.slow
def test_the_published_arm(arm_finger):
    folder = published("two_segment_arm")
    files = [str(folder / f"trial_{i}.txt") for i in range(1, 6)]
    recordings = find_recordings(files, "two_segment_arm")
    rows = {"arcs 2": ("arcs", 2)}
    arms = [arm_recording(recording) for recording in recordings]
    (tip,) = (row for row in replay_recordings(arms, None, rows, arm_finger, DOWN).table if _is_tip(row))
    assert tip.mean_mm < 2.6
    assert tip.percentile_95_mm < 5.6


ONE_ROW = {"arcs_2": ("arcs", 2)}
LATE = np.append(np.zeros(98), [7.0, 8.0, 9.0])  # mm, of 101 samples


def recorded_errors(name, *bodies):
    """A recording with errors in mm, (bodies, samples), after one that is logged before anything is read."""
    errors = 1e-3 * np.concatenate([[np.full(len(bodies), 1e3)], np.transpose(bodies)])
    signals = {"arcs_2.body_error": errors, BAND: np.full(errors.shape, 7.5e-3)}
    data = xr.Dataset({name: (("time", "body"), of) for name, of in signals.items()}, {"body": ["elbow", "tip"]})
    data[FAR] = "time", np.arange(len(errors)) > len(errors) // 2
    return SimpleNamespace(name=name, signals=data, first=1)


def row_of(table, recording, body):
    (row,) = (row for row in table if (row.recording, row.body) == (recording, body))
    return row


def test_each_body_has_its_own_errors():
    """Nothing of the elbow's errors, ten times as large, comes into those of the tip."""
    table = replay_table([recorded_errors("a", 10 * np.arange(101.0), np.arange(101.0))], ONE_ROW)
    for body, scale in (("elbow", 10.0), ("tip", 1.0)):
        row = row_of(table, "a", body)
        numbers = row.mean_mm, row.median_mm, row.percentile_95_mm, row.max_mm
        assert numbers == pytest.approx(scale * np.array([50.0, 50.0, 95.0, 100.0]))
        assert (row.estimator, row.sections) == ("arcs", 2)


@pytest.mark.parametrize(
    ("first", "mean", "median", "within", "far"),
    [(1, 24 / 101, 0.0, 100 * 99 / 101, 100 * 50 / 101), (99, 8.0, 8.0, 100 / 3, 100)],
)
def test_mean_median_percentile_and_largest_are_four_numbers(first, mean, median, within, far):
    """Of samples after those that zero the wires."""
    one = recorded_errors("a", LATE, LATE)
    one.first = first
    row = row_of(replay_table([one], ONE_ROW), "a", "tip")
    assert (row.mean_mm, row.median_mm, row.max_mm) == pytest.approx((mean, median, 9.0))
    assert (row.within_band_percent, row.band_mm, row.far_percent) == pytest.approx((within, 7.5, far))


def test_only_arcs_with_a_sensor_for_each_section_have_a_band():
    one = recorded_errors("a", LATE, LATE)
    signals = one.signals.rename({"arcs_2.body_error": "other.body_error"})
    for row in (("arcs", 1), ("gaussian", 2)):
        table = replay_table([SimpleNamespace(name="a", signals=signals, first=1)], {"other": row})
        assert np.isnan(row_of(table, "a", "tip").within_band_percent)


def test_all_are_the_samples_of_every_recording_not_the_mean_of_their_rows():
    """A sample that was not seen counts nowhere."""
    short, long = np.array([4.0, np.nan]), np.array([1.0, 1.0, 1.0])
    table = replay_table([recorded_errors("a", short, short), recorded_errors("b", long, long)], ONE_ROW)
    assert [row.mean_mm for row in table if row.body == "tip"] == [4.0, 1.0, 7 / 4]
    assert row_of(table, ALL, "tip").max_mm == 4.0
