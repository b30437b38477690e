"""Splits, predictions and statistics that all experiments on recordings share, against numbers worked out by hand."""

import numpy as np
import pytest

from soft_gripper.extras.hardware.scoring import (
    Split,
    error_columns,
    leave_groups_out,
    leave_one_out,
    predictions,
)


def test_each_is_predicted_by_a_fit_to_the_others_alone():
    found = predictions(leave_one_out("abc"), lambda fitted: lambda one: (one, "".join(fitted)))
    assert list(found) == [("a", "bc"), ("b", "ac"), ("c", "ab")]


def test_all_that_a_split_tests_is_predicted_by_one_fit():
    fits = []

    def fit(fitted):
        fits.append(fitted)
        return str.upper

    assert list(predictions([Split("ab", "cd")], fit)) == ["C", "D"]
    assert fits == ["ab"]


def test_groups_are_left_out_of_all_recordings_and_rows_without_one_never():
    first, second = leave_groups_out([np.array(["b", "", "a"]), np.array(["a", "a"])])
    assert [rows.tolist() for rows in first] == [[True, True, False], [False, False]]
    assert [rows.tolist() for rows in second] == [[False, True, True], [True, True]]


def test_statistics_are_those_that_their_columns_name():
    errors = np.array([3.0, np.nan, 4.0, 0.0, 0.0])
    found = error_columns(errors, "mean_mm", "median_mm", "percentile_95", "max_mm", "rms")
    assert found == pytest.approx({"mean_mm": 1.75, "median_mm": 1.5, "percentile_95": 3.85, "max_mm": 4.0, "rms": 2.5})
