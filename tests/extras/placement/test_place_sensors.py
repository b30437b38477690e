"""Placing, end to end on fingers made up: what is ranked, what is reported, how it is drawn."""

from dataclasses import replace

import numpy as np
import pytest
from refusals import refused

from soft_gripper.extras.placement.place_sensors import LeftOut, place_sensors
from soft_gripper.extras.placement.samples import Assumptions
from soft_gripper.extras.placement.tables import left_out_rows, placement_figure, placement_rows, run_rows

KINK = 5  # segments from the base, where the made-up finger begins to bend the other way


@pytest.fixture(scope="module")
def kinked(free_finger):
    """A finger of two circular arcs: two sections that meet between them measure it exactly."""
    bend = np.where(np.arange(12) < KINK, 0.1, -0.12)
    return replace(free_finger, q=np.linspace(0.2, 1, len(free_finger.q))[:, None] * bend)


@pytest.fixture(scope="module")
def placed(kinked, free_finger):
    """By an estimator that knows no pressure."""
    runs = {"kinked": [kinked], "free": [free_finger]}
    calls = []
    found = place_sensors(2, runs, Assumptions("spline"), progress=lambda: calls.append(1))
    assert len(calls) == 11
    return found


def test_sections_meet_where_the_curvature_changes(kinked):
    found = place_sensors(2, {"kinked": [kinked]}, Assumptions("arcs"))
    assert found.placements[0] == (KINK,)
    assert found.mean_pose_errors[0] < 0.2 * found.mean_pose_errors[1]
    assert found.placements[found.equal] == (6,)
    assert found.left_out == []
    assert found.contacts is None


def test_runs_count_alike_and_the_best_is_first(placed):
    means = placed.pose_errors.mean(axis=1)
    np.testing.assert_array_equal(means, placed.mean_pose_errors)
    assert np.all(np.diff(means) >= 0)
    assert sorted(placed.placements) == [(end,) for end in range(1, 12)]


def test_rows(placed):
    rows = placement_rows(placed)
    assert [row.rank for row in rows] == list(range(1, 12))
    assert rows[placed.equal].borders == "0.5"
    assert rows[0].pose_error_mm == pytest.approx(1e3 * placed.mean_pose_errors[0])
    assert np.isnan(rows[0].force_error_n)
    of_runs = run_rows(placed)
    assert [(row.rank, row.run) for row in of_runs[:3]] == [(1, "kinked"), (1, "free"), (2, "kinked")]
    assert [row.pose_error_mm for row in of_runs] == pytest.approx(1e3 * placed.pose_errors.ravel())


def test_left_out_rows_say_by_how_much_placed_sensors_are_better(placed):
    assert [row.run for row in left_out_rows(placed)] == ["kinked", "free"]
    (row,) = left_out_rows(replace(placed, left_out=[LeftOut("other", (3,), 2e-3, 0.5e-3)]))
    assert (row.run, row.borders) == ("other", "0.25")
    assert (row.equal_mm, row.placed_mm, row.gain_percent) == pytest.approx((2, 0.5, 75))


def test_the_figure_draws_sections_to_scale(placed):
    figure = placement_figure(placed)
    *fingers, errors = figure.axes
    for axes, i in zip(fingers, (0, placed.equal, 10), strict=True):
        (border,) = placed.placements[i]
        corners = [patch.get_xy()[:, 0] for patch in axes.patches]
        assert [(corner.min(), corner.max()) for corner in corners] == [
            pytest.approx((0, 10 * border)),
            pytest.approx((10 * border, 120)),
        ]
        assert axes.get_aspect() == 1
    lines = {line.get_label(): line for line in errors.lines}
    np.testing.assert_allclose(lines["mean"].get_ydata(), 1e3 * placed.mean_pose_errors)
    assert lines["equal sections"].get_xdata()[0] == placed.equal + 1


def test_a_count_beyond_the_segments_is_refused(free_finger):
    with refused("count", 13):
        place_sensors(13, {"free": [free_finger]}, Assumptions())
