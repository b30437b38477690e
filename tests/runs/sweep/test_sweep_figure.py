"""The figure of a sweep of one or two keys."""

import numpy as np
import pytest

from soft_gripper.runs.sweep.figure import sweep_figure

MEASURES = {"error_mm": ["1", "", "3", "nan"], "outcome": ["done", "", "lost", "done"]}


def test_true_and_false_are_drawn_as_one_and_zero():
    (axes,) = sweep_figure({"key": ["1", "2", "3"]}, {"is_held": ["True", "False", ""]}, "").axes
    np.testing.assert_array_equal(axes.lines[0].get_ydata(), [1, 0, np.nan])


def test_a_map_of_a_grid_and_dots_of_samples_with_crosses_where_runs_failed():
    grid = sweep_figure({"a": ["1", "1", "2", "2"], "b": ["5", "6", "5", "6"]}, MEASURES, "").axes[0]
    np.testing.assert_array_equal(np.ma.filled(grid.collections[0].get_array(), np.nan), [[1, 3], [np.nan, np.nan]])
    assert len(grid.lines[0].get_xdata()) == 2
    dots = sweep_figure({"a": ["1", "1.5", "2", "3"], "b": ["5", "6", "7", "6"]}, MEASURES, "").axes[0]
    np.testing.assert_array_equal(dots.collections[0].get_offsets(), [[1, 5], [2, 7]])


@pytest.mark.parametrize(
    ("varied", "measured"), [({k: ["1"] for k in "abc"}, {"m": ["1"]}), ({"a": ["1"]}, {"m": [""], "n": ["done"]})]
)
def test_what_cannot_be_drawn_has_no_figure(varied, measured):
    assert sweep_figure(varied, measured, "") is None


def test_many_points_are_an_image_in_an_svg(tmp_path):
    cells = [str(value) for value in range(20_000)]
    figure = sweep_figure({"a": cells, "b": cells[::-1]}, {"measure": cells}, "")
    assert figure is not None
    figure.savefig(tmp_path / "sweep.svg")
    assert (tmp_path / "sweep.svg").stat().st_size < 1e6
