"""The map: the error in a cell is that of the scenario where it is largest."""

from itertools import product

import numpy as np

from studies.robustness.claims import map_figure
from studies.robustness.rows import RobustnessRow

ESTIMATORS, NOISES, SCENARIOS = ("arcs", "gaussian"), (0.0, 1.0, 4.0), ("free_bending", "box_grasp")


def error(scenario, estimator, nominal, noise, sections):
    scale = (1 + SCENARIOS.index(scenario)) * (2 - ESTIMATORS.index(estimator))
    return scale * (0.1 + noise) / sections * (2 if nominal == "wrong" else 1)


def test_every_cell_is_the_worst_scenario() -> None:
    nominals = ("as simulated", "wrong")
    rows = [
        RobustnessRow(s, name, b, noise, n, error(s, name, b, noise, n), 1.0, 1.0, 1.0, 20)
        for s, name, b, noise, n in product(SCENARIOS, ESTIMATORS, nominals, NOISES, (1, 2))
    ]
    figure = map_figure(rows)
    for axes, (nominal, sections) in zip(figure.axes, product(nominals, (1, 2)), strict=False):
        expected = [[error("box_grasp", e, nominal, noise, sections) for noise in NOISES] for e in ESTIMATORS]
        np.testing.assert_allclose(axes.images[0].get_array(), expected)
        assert [text.get_text() for text in axes.texts] == [f"{value:.2f}" for value in np.ravel(expected)]
    assert [label.get_text() for label in figure.axes[0].get_yticklabels()] == list(ESTIMATORS)
