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


def test_free_bending_has_two_panels_of_four_lines(figure: Figure) -> None:
    assert len(figure.axes) == 2
    for axes in figure.axes:
        assert [line.get_label() for line in lines(axes)] == ["1", "2", "3", "4"]
        assert axes.get_ylim()[0] == 0
        assert axes.get_yscale() == "linear"
    assert len({axes.get_ylim() for axes in figure.axes}) == 1
    assert [axes.get_title() for axes in figure.axes] == ["Mean pose error", "Fingertip error"]


def test_every_point_is_inside_its_panel(figure: Figure) -> None:
    rows = [row for name in CONTACT for row in rows_of(name)]
    for axes in (*figure.axes, *contact_figure(rows, CONTACT, "tip_error_mm").axes):
        for line in lines(axes):
            for values, (low, high) in ((line.get_xdata(), axes.get_xlim()), (line.get_ydata(), axes.get_ylim())):
                assert low <= min(values) <= max(values) <= high


def test_lines_differ_in_more_than_color(figure: Figure) -> None:
    for axes in figure.axes:
        assert len({line.get_marker() for line in lines(axes)}) == 4
        assert len({line.get_color() for line in lines(axes)}) == 4


def test_points_average_the_fingers_and_both_ways(figure: Figure) -> None:
    """Pose error on the left, fingertip error on the right, against the bend angle in degrees."""
    for axes, more in zip(figure.axes, (0.1, 0.3), strict=True):
        for n, line in enumerate(lines(axes), start=1):
            assert list(line.get_xdata()) == pytest.approx([0.0, 50.0, 100.0])
            assert list(line.get_ydata()) == pytest.approx([p / n + more for p in (0.0, 100.0, 200.0)])


def test_axes_name_their_units(figure: Figure) -> None:
    assert all("[degrees]" in axes.get_xlabel() for axes in figure.axes)
    assert "[mm]" in figure.axes[0].get_ylabel()


@pytest.mark.parametrize(
    ("error", "label"), [("pose_error_mm", "mean pose error [mm]"), ("tip_error_mm", "fingertip error [mm]")]
)
def test_contact_figure_names_the_error_the_pressure_and_the_sensors(error: str, label: str) -> None:
    figure = contact_figure([row for name in CONTACT for row in rows_of(name)], CONTACT, error)
    assert [axes.get_ylabel() for axes in figure.axes] == [label, "", label, ""]
    assert {axes.get_xlabel() for axes in figure.axes} == {"pressure [kPa]"}
    legend = figure.axes[0].get_legend()
    assert legend is not None
    assert legend.get_title().get_text() == "sensors per side"
    for handle, text, line in zip(legend.get_lines(), legend.get_texts(), lines(figure.axes[0]), strict=True):
        assert text.get_text() == line.get_label()
        assert (handle.get_color(), handle.get_marker()) == (line.get_color(), line.get_marker())


def test_contact_scenarios_share_one_scale() -> None:
    rows = [row for i, name in enumerate(CONTACT) for row in rows_of(name, scale=i + 1)]
    figure = contact_figure(rows, CONTACT, "pose_error_mm")
    assert len(figure.axes) == len(CONTACT)
    assert len({axes.get_ylim() for axes in figure.axes}) == 1
    for i, axes in enumerate(figure.axes):
        assert "[kPa]" in axes.get_xlabel()
        assert len(lines(axes)) == 4
        assert axes.get_title() == CONTACT[i].replace("_", " ").capitalize()
        assert lines(axes)[0].get_ydata()[-1] == pytest.approx(200 * (i + 1) + 0.1)


@pytest.mark.parametrize(("error", "more"), [("pose_error_mm", 0.1), ("tip_error_mm", 0.3)])
def test_contact_figure_shows_means_of_the_error_that_is_asked_for(error: str, more: float) -> None:
    figure = contact_figure([row for name in CONTACT for row in rows_of(name)], CONTACT, error)
    for axes in figure.axes:
        for n, line in enumerate(lines(axes), start=1):
            assert line.get_label() == str(n)
            assert list(line.get_ydata()) == pytest.approx([p / n + more for p in (0.0, 100.0, 200.0)])


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


@pytest.mark.slow
def test_other_rows_make_another_file(figure: Figure, tmp_path: Path) -> None:
    save_figure(figure, tmp_path / "one")
    save_figure(free_bending_figure(rows_of("free_bending", scale=2.0)), tmp_path / "two")
    assert (tmp_path / "one.svg").read_bytes() != (tmp_path / "two.svg").read_bytes()
