"""The table of a replay: numbers of errors that are worked out by hand, for each body, recording and all of them."""

from types import SimpleNamespace

import numpy as np
import pytest
import xarray as xr

from soft_gripper.extras.hardware.replay.held_out import ALL, BAND, FAR, replay_table

ROWS = {"arcs_2": ("arcs", 2)}
LATE = np.append(np.zeros(98), [7.0, 8.0, 9.0])  # mm, of 101 samples


def replayed(name, *bodies):
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
    table = replay_table([replayed("a", 10 * np.arange(101.0), np.arange(101.0))], ROWS)
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
    one = replayed("a", LATE, LATE)
    one.first = first
    row = row_of(replay_table([one], ROWS), "a", "tip")
    assert (row.mean_mm, row.median_mm, row.max_mm) == pytest.approx((mean, median, 9.0))
    assert (row.within_band_percent, row.band_mm, row.far_percent) == pytest.approx((within, 7.5, far))


def test_only_arcs_with_a_sensor_for_each_section_have_a_band():
    one = replayed("a", LATE, LATE)
    signals = one.signals.rename({"arcs_2.body_error": "other.body_error"})
    for row in (("arcs", 1), ("gaussian", 2)):
        table = replay_table([SimpleNamespace(name="a", signals=signals, first=1)], {"other": row})
        assert np.isnan(row_of(table, "a", "tip").within_band_percent)


def test_all_are_the_samples_of_every_recording_not_the_mean_of_their_rows():
    """A sample that was not seen counts nowhere."""
    short, long = np.array([4.0, np.nan]), np.array([1.0, 1.0, 1.0])
    table = replay_table([replayed("a", short, short), replayed("b", long, long)], ROWS)
    assert [row.mean_mm for row in table if row.body == "tip"] == [4.0, 1.0, 7 / 4]
    assert row_of(table, ALL, "tip").max_mm == 4.0
