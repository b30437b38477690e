"""The figure of a sweep of one or two keys."""

import numpy as np
import pytest

from soft_gripper.runs.sweep.run_sweep import PANELS, sweep_figure

MEASURES = {"error_mm": ["1", "", "3", "nan"], "outcome": ["done", "", "lost", "done"]}


def test_a_line_in_order_of_the_key_without_what_failed():
    figure = sweep_figure({"key": ["4", "3", "2", "1"]}, MEASURES, "title")
    (axes,) = figure.axes
    assert (axes.get_xlabel(), axes.get_ylabel()) == ("key", "error_mm")
    np.testing.assert_array_equal(axes.lines[0].get_xdata(), [1, 2, 3, 4])
    np.testing.assert_array_equal(axes.lines[0].get_ydata(), [np.nan, 3, np.nan, 1])


def test_percent_are_numbers_and_names_are_places():
    percent = sweep_figure({"key": ["-10 %", "+0 %", "+10 %", "+20 %"]}, MEASURES, "").axes[0]
    np.testing.assert_array_equal(percent.lines[0].get_xdata(), [-10, 0, 10, 20])
    named = sweep_figure({"key": ["arcs", "spline", "arcs", "contact"]}, MEASURES, "").axes[0]
    assert [text.get_text() for text in named.get_xticklabels()] == ["arcs", "spline", "contact"]


def test_true_and_false_are_drawn_as_one_and_zero():
    (axes,) = sweep_figure({"key": ["1", "2", "3"]}, {"is_held": ["True", "False", ""]}, "").axes
    np.testing.assert_array_equal(axes.lines[0].get_ydata(), [1, 0, np.nan])


def test_a_map_of_a_grid_and_dots_of_samples_with_crosses_where_runs_failed():
    grid = sweep_figure({"a": ["1", "1", "2", "2"], "b": ["5", "6", "5", "6"]}, MEASURES, "").axes[0]
    np.testing.assert_array_equal(np.ma.filled(grid.collections[0].get_array(), np.nan), [[1, 3], [np.nan, np.nan]])
    assert len(grid.lines[0].get_xdata()) == 2
    dots = sweep_figure({"a": ["1", "1.5", "2", "3"], "b": ["5", "6", "7", "6"]}, MEASURES, "").axes[0]
    np.testing.assert_array_equal(dots.collections[0].get_offsets(), [[1, 5], [2, 7]])


def test_no_more_panels_than_can_be_seen():
    many = {f"m{i}": ["1", "2", "3", "4"] for i in range(9)}
    assert len(sweep_figure({"k": ["1", "2", "3", "4"]}, many, "").axes) == PANELS


@pytest.mark.parametrize(
    ("varied", "measured"), [({k: ["1"] for k in "abc"}, {"m": ["1"]}), ({"a": ["1"]}, {"m": [""], "n": ["done"]})]
)
def test_what_cannot_be_drawn_has_no_figure(varied, measured):
    assert sweep_figure(varied, measured, "") is None


def test_ticks_are_at_the_values_and_what_is_not_held_is_crossed_out():
    keys = {"a": ["-20 %", "-20 %", "+20 %", "+20 %"], "b": ["5", "6", "5", "6"]}
    measured = {"grasp": ["held", "dropped", "", "resting"], "force": ["1", "2", "", "3"]}
    figure = sweep_figure(keys, measured, "title")
    axes = figure.axes[0]
    assert (axes.get_xlabel(), axes.get_xticks().tolist()) == ("a [%]", [-20, 20])
    assert [line.get_xydata().tolist() for line in axes.lines] == [[[20, 5]], [[-20, 6], [20, 6]]]
    assert figure.get_suptitle() == "title, crosses: not held"


def test_measures_that_do_not_vary_are_left_out():
    measured = {"weight": ["0.2943", "0.294301", "0.2943", "nan"], "force": ["1", "2", "3", "4"]}
    (axes,) = sweep_figure({"key": ["1", "2", "3", "4"]}, measured, "").axes
    assert axes.get_ylabel() == "force"
