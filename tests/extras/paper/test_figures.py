"""The figures: every number of sensors has its line in every panel, and files are the same for the same rows."""

from dataclasses import replace
from itertools import product
from pathlib import Path

import pytest
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from soft_gripper.extras.paper.figures import contact_figure, free_bending_figure
from soft_gripper.pictures.style import save_figure
from soft_gripper.runs.scores.poses import PoseRow

UP_AND_DOWN = (0.0, 100.0, 200.0, 100.0, 0.0)  # kPa
CONTACT = ("obstructed_inside", "obstructed_outside", "box_grasp", "irregular_grasp")


def rows_of(scenario: str, scale: float = 1.0) -> list[PoseRow]:
    """Two fingers, 1 to 4 sensors; errs `scale` * pressure / sensors, 0.2 mm more on the right and at the tip."""
    return [
        PoseRow(
            scenario, finger, "arcs", "as simulated", n, p, 0.5 * p, scale * p / n + more, scale * p / n + more + 0.2
        )
        for (finger, more), n, p in product((("left", 0.0), ("right", 0.2)), (1, 2, 3, 4), UP_AND_DOWN)
    ]


def lines(axes: Axes) -> list[Line2D]:
    """The lines that stand in the legend; helping lines have no label."""
    return [line for line in axes.lines if not str(line.get_label()).startswith("_")]


@pytest.fixture
def figure() -> Figure:
    return free_bending_figure(rows_of("free_bending"))


def test_free_bending_has_means_over_the_fingers_and_both_ways_on_one_scale(figure: Figure) -> None:
    """Pose error on the left, fingertip error on the right, against the bend angle in degrees."""
    assert [axes.get_title() for axes in figure.axes] == ["Mean pose error", "Fingertip error"]
    assert len({axes.get_ylim() for axes in figure.axes}) == 1
    assert [axes.get_ylabel() for axes in figure.axes] == ["error [mm]", ""]
    for axes, more in zip(figure.axes, (0.1, 0.3), strict=True):
        assert [line.get_label() for line in lines(axes)] == ["1", "2", "3", "4"]
        assert len({line.get_marker() for line in lines(axes)}) == len({line.get_color() for line in lines(axes)}) == 4
        assert (axes.get_ylim()[0], axes.get_yscale()) == (0, "linear")
        for n, line in enumerate(lines(axes), start=1):
            assert list(line.get_xdata()) == pytest.approx([0.0, 50.0, 100.0])
            assert list(line.get_ydata()) == pytest.approx([p / n + more for p in (0.0, 100.0, 200.0)])


@pytest.mark.parametrize(
    ("error", "label", "more"),
    [("pose_error_mm", "mean pose error [mm]", 0.1), ("tip_error_mm", "fingertip error [mm]", 0.3)],
)
def test_contact_scenarios_have_means_of_the_error_that_is_asked_for_on_one_scale(
    error: str, label: str, more: float
) -> None:
    rows = [row for i, name in enumerate(CONTACT) for row in rows_of(name, scale=i + 1)]
    figure = contact_figure(rows, CONTACT, error)
    assert [axes.get_ylabel() for axes in figure.axes] == [label, "", label, ""]
    assert len({axes.get_ylim() for axes in figure.axes}) == 1
    for i, axes in enumerate(figure.axes):
        assert axes.get_title() == CONTACT[i].replace("_", " ").capitalize()
        for n, line in enumerate(lines(axes), start=1):
            assert line.get_label() == str(n)
            assert list(line.get_ydata()) == pytest.approx([(i + 1) * p / n + more for p in (0.0, 100.0, 200.0)])
            assert axes.get_ylim()[0] < min(line.get_ydata()) <= max(line.get_ydata()) < axes.get_ylim()[1]


def test_errors_of_contact_are_on_a_logarithmic_axis_without_what_is_zero() -> None:
    """The right finger errs at every step; the left one, and so the mean of one finger, not when it is straight."""
    left = [row for name in CONTACT for row in rows_of(name) if row.finger == "left"]
    for axes in contact_figure(left, CONTACT, "pose_error_mm").axes:
        assert axes.get_yscale() == "log"
        assert axes.get_ylim()[0] > 0.1
        assert [list(line.get_xdata()) for line in lines(axes)] == [[100.0, 200.0]] * 4


def test_a_growing_vacuum_runs_to_the_right() -> None:
    rows = [replace(row, pressure_kpa=-row.pressure_kpa) for row in rows_of("obstructed_outside")]
    figure = contact_figure([*rows, *rows_of("box_grasp")], ["obstructed_outside", "box_grasp"], "pose_error_mm")
    vacuum, pressure = figure.axes[:2]
    assert vacuum.get_xlim() == pytest.approx((8.0, -208.0))
    assert pressure.get_xlim() == pytest.approx((-8.0, 208.0))


@pytest.mark.slow
def test_files_are_the_same_for_the_same_rows(figure: Figure, tmp_path: Path) -> None:
    save_figure(figure, tmp_path / "one")
    save_figure(free_bending_figure(rows_of("free_bending")), tmp_path / "two")
    assert sorted(path.name for path in tmp_path.iterdir()) == ["one.png", "one.svg", "two.png", "two.svg"]
    for ending in (".png", ".svg"):
        one, two = ((tmp_path / name).with_suffix(ending).read_bytes() for name in ("one", "two"))
        assert one == two
    assert (tmp_path / "one.png").read_bytes().startswith(b"\x89PNG")
    assert b"<svg" in (tmp_path / "one.svg").read_bytes()
