"""The figure of the estimators: means over the steps, on the line of the estimator in the panel of the scenario."""

from itertools import product

import pytest

from soft_gripper.extras.paper.page import LEAST, PAPER, estimators_figure
from soft_gripper.runs.scores.poses import PoseRow

SCENARIOS = ("free_bending", "box_grasp", "irregular_grasp")
SCALE = {"arcs": 1.0, "gaussian": 0.1}  # mm


def error(scenario: str, estimator: str, sections: int) -> float:
    return (1 + SCENARIOS.index(scenario)) * SCALE[estimator] / sections


ROWS = [
    PoseRow(s, "finger", name, "as simulated", n, p, 0.0, error(s, name, n) * p, 99.0)
    for name, s, n, p in product(SCALE, SCENARIOS, (1, 2, 3), (0.5, 1.5))
]


def test_a_line_an_estimator_and_a_panel_a_scenario() -> None:
    figure = estimators_figure(ROWS, SCENARIOS)
    for axes, scenario in zip(figure.axes, SCENARIOS, strict=False):
        assert axes.get_title() == scenario.replace("_", " ").capitalize()
        assert axes.get_yscale() == "log"
        for name in SCALE:
            (line,) = (line for line in axes.lines if line.get_label() == name)
            assert list(line.get_xdata()) == [1, 2, 3]
            assert list(line.get_ydata()) == pytest.approx([error(scenario, name, n) for n in (1, 2, 3)])
        assert any(list(line.get_ydata()) == [PAPER, PAPER] for line in axes.lines)


def test_no_error_is_drawn_at_the_least_one() -> None:
    exact = [PoseRow("free_bending", "finger", "arcs", "as simulated", n, 0.0, 0.0, 0.0, 0.0) for n in (1, 2)]
    line = estimators_figure(exact, ["free_bending"]).axes[0].lines[0]
    assert list(line.get_ydata()) == [LEAST, LEAST]
