"""Figures of the evaluation, and that of its scenes."""

from itertools import pairwise, product

import pytest
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from soft_gripper.extras.paper.figures import contact_figure, contact_force_figure, force_figure, free_bending_figure
from soft_gripper.extras.paper.forces import ContactForceRow
from soft_gripper.extras.paper.scenes_figure import (
    GAP,
    HEIGHT,
    MAX_ROW_WIDTH,
    largest_pressure,
    pair_places,
)
from soft_gripper.runs.scores.external_torques import ForceRow
from soft_gripper.runs.scores.poses import PoseRow
from soft_gripper.scenario.scenario_file import load_scenario

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


SCENARIOS = {"obstructed_inside": (0.0, 60.0, 180.0), "obstructed_outside": (0.0, -30.0, -90.0)}  # kPa
JOINTS = (0, 1, 2)


def true(pressure: float, joint: int) -> float:
    """External torque, N m; it falls to zero toward the tip."""
    return -1e-3 * pressure * (2 - joint)


def error(sections: int, pressure: float, joint: int, finger: str) -> float:
    """Of the estimate, N m; joints and fingers differ."""
    return 1e-5 * abs(pressure) / sections * (1 + 3 * joint) * (-1 if finger == "left" else 2)


ROWS = [
    ForceRow(scenario, finger, "arcs", "as simulated", n, p, joint, true(p, joint) + error(n, p, joint, finger), value)
    for scenario, steps in SCENARIOS.items()
    for finger, n, p, joint in product(("left", "right"), (1, 2, 3, 4), steps, JOINTS)
    for value in (true(p, joint),)
]


def panels() -> tuple[list[Axes], list[Axes]]:
    axes = force_figure(ROWS, tuple(SCENARIOS)).axes
    return axes[: len(SCENARIOS)], axes[len(SCENARIOS) :]


def lines_by_label(axes: Axes) -> dict[str, Line2D]:
    return {str(line.get_label()): line for line in axes.lines}


def test_lines_along_the_finger_are_the_truth_and_the_estimates() -> None:
    """Of the first finger at the last step, mN m; only the truth is black."""
    for axes, (name, steps) in zip(panels()[0], SCENARIOS.items(), strict=True):
        drawn, last = lines_by_label(axes), steps[-1]
        assert axes.get_title() == name.replace("_", " ").capitalize()
        assert [label for label, line in drawn.items() if line.get_color() == "black"] == ["truth"]
        assert list(drawn["truth"].get_ydata()) == pytest.approx([1e3 * true(last, joint) for joint in JOINTS])
        for n in (1, 2, 3, 4):
            expected = [1e3 * (true(last, joint) + error(n, last, joint, "left")) for joint in JOINTS]
            assert list(drawn[str(n)].get_ydata()) == pytest.approx(expected)


def test_errors_are_means_over_joints_and_fingers() -> None:
    for axes, steps in zip(panels()[1], SCENARIOS.values(), strict=True):
        for n in (1, 2, 3, 4):
            line = lines_by_label(axes)[str(n)]
            mean = [1e-2 * abs(p) / n * (1 + 4 + 7) / 3 * (1 + 2) / 2 for p in line.get_xdata()]
            assert sorted(line.get_xdata()) == sorted(steps)
            assert list(line.get_ydata()) == pytest.approx(mean)


PRESSING = [
    ContactForceRow(
        scenario, finger, "contact", "as simulated", n, p, borders, p / n, p / 100, 9.0, 9.0, 80.0 - n, 80.0
    )
    for scenario, steps in SCENARIOS.items()
    for finger, (n, borders), p in product(("left", "right"), ((2, "60"), (2, "40"), (4, "30 60 90")), steps)
]


def test_force_and_place_are_drawn_beside_the_true_ones() -> None:
    """A line for every layout, in a look of its own, of the first finger; only the truth is black."""
    axes = contact_force_figure(PRESSING, tuple(SCENARIOS)).axes
    for force, place, steps in zip(axes[:2], axes[2:], SCENARIOS.values(), strict=True):
        for panel, truth in ((force, [p / 100 for p in steps]), (place, [80.0] * 3)):
            drawn = {label: line for label, line in lines_by_label(panel).items() if not label.startswith("_")}
            assert list(drawn) == ["2: 60 mm", "2: 40 mm", "4: 30 60 90 mm", "truth"]
            assert [label for label, line in drawn.items() if line.get_color() == "black"] == ["truth"]
            assert len({line.get_color() for line in drawn.values()}) == 4
            assert list(drawn["truth"].get_ydata()) == truth
        assert list(lines_by_label(force)["4: 30 60 90 mm"].get_ydata()) == [p / 4 for p in steps]
        assert list(lines_by_label(place)["2: 40 mm"].get_ydata()) == [78.0] * 3


def test_pairs_fill_rows_and_stand_in_their_middle() -> None:
    places = pair_places([9.0, 4.0, 5.0, 4.0])
    assert [width for *_, width in places] == [9.0, 4.0, 5.0, 4.0]
    tops = [top for _, top, _ in places]
    assert tops[0] == 0 < tops[1] == tops[2] < tops[3]
    across = 4.0 + GAP + 5.0
    assert [left for left, *_ in places] == pytest.approx([(across - 9) / 2, 0, 4 + GAP, (across - 4) / 2])


def test_a_pair_that_is_wider_than_a_row_has_one_alone() -> None:
    places = pair_places([2.0, MAX_ROW_WIDTH + 1, 2.0])
    assert all(below[1] - above[1] > HEIGHT for above, below in pairwise(places))


@pytest.mark.parametrize(
    ("steps", "expected"),
    [
        ({"all": [0.0, 20e3, 50e3, 30e3]}, (6.0, 50e3)),
        ({"all": [10e3, -40e3]}, (4.0, -40e3)),
        ({"left_finger": [10e3, 20e3, 30e3], "right_finger": [0.0, 45e3]}, (4.0, 45e3)),
    ],
    ids=str,
)
def test_the_largest_pressure_is_found_at_the_end_of_its_step(
    steps: dict[str, list[float]], expected: tuple[float, float]
) -> None:
    scenario = load_scenario("free_bending", [f"pressure.steps={steps}"])
    assert largest_pressure(scenario) == pytest.approx(expected)
