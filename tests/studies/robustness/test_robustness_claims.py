"""Claims on robustness, and the page that prints them."""

import csv
from dataclasses import replace
from itertools import product
from math import nan
from pathlib import Path

import numpy as np
import pytest

from soft_gripper.extras.paper.bars import BARS
from soft_gripper.extras.paper.scenario_run import SCENARIOS
from studies.robustness.claims import map_figure, robustness_claims
from studies.robustness.plants import PLANTS
from studies.robustness.rows import NOMINAL_ERRORS, PlantRow, RobustnessRow, nominal_name

MEANS = {"arcs": 0.9, "gaussian": 0.8}
ROWS = [
    RobustnessRow(s, name, nominal_name(*nominal), noise, n, noise * mean, 2.4 * noise * mean, 9.0, 0.95, 20)
    for (name, mean), s, nominal, noise, n in product(
        MEANS.items(), SCENARIOS, NOMINAL_ERRORS, (1.0, 4.0), (1, 2, 3, 4)
    )
]
OF_PLANT = {1: 2.0, 2: 0.4, 3: 0.2, 4: 0.2}  # mm, within 1.5 times the bars
PLANT_ROWS = [
    PlantRow(plant.name, s, "gaussian", n, mean, mean, mean, 2 * mean, 0.95, 20)
    for plant, s, (n, mean) in product(PLANTS, SCENARIOS, OF_PLANT.items())
]


def failing(rows, plants=PLANT_ROWS):
    return [i for i, claim in enumerate(robustness_claims(rows, plants)) if not claim.holds]


def changed(rows, change, **where):
    hit = [all(getattr(row, key) == value for key, value in where.items()) for row in rows]
    assert any(hit)
    return [replace(row, **change) if it else row for row, it in zip(rows, hit, strict=True)]


def test_all_hold_within_the_bars() -> None:
    assert failing(ROWS) == []
    assert len(robustness_claims(ROWS, PLANT_ROWS)) == 3 + 2 * len(BARS)


@pytest.mark.parametrize(
    ("change", "estimator", "sections", "fails"),
    [
        ({"mean_mm": 1.1}, "gaussian", 2, [0, 1]),
        ({"p95_mm": 2.6}, "gaussian", 2, [0]),
        ({"mean_mm": 0.95}, "gaussian", 2, [1]),
        ({"mean_mm": 0.7}, "arcs", 4, [1]),
        ({"coverage": 0.89}, "gaussian", 2, [2]),
        ({"coverage": 0.995}, "gaussian", 2, [2]),
        ({"mean_mm": 9.0, "p95_mm": 9.0, "coverage": 0.1}, "gaussian", 3, []),
        ({"mean_mm": nan}, "gaussian", 2, [0, 1]),
        ({"p95_mm": nan}, "gaussian", 2, [0]),
        ({"mean_mm": nan}, "arcs", 4, [1]),
        ({"coverage": nan}, "gaussian", 2, [2]),
    ],
)
def test_a_scenario_and_nominal_model_alone_break_it(change, estimator, sections, fails) -> None:
    where = {"estimator": estimator, "sections": sections, "noise": 1.0, "scenario": "box_grasp"}
    assert failing(changed(ROWS, change, nominal="E +10 %, p -1 %", **where)) == fails


@pytest.mark.parametrize("column", ["worst_mm", "tip_mm"])
@pytest.mark.parametrize(("error", "breaks"), [(1.45, 0), (1.55, 1)])
def test_no_step_errs_by_more_than_1_5_mm_with_two_sensors_and_no_tip(column, error, breaks) -> None:
    """Half as much again as 1 mm at every step, and as twice the mean of 0.5 mm at the tip."""
    changes = changed(PLANT_ROWS, {column: error}, plant="tapered", scenario="irregular_grasp", sections=2)
    assert len(failing(ROWS, changes)) == breaks


ESTIMATORS, NOISES, MAPPED = ("arcs", "gaussian"), (0.0, 1.0, 4.0), ("free_bending", "box_grasp")


def error(scenario, estimator, nominal, noise, sections):
    scale = (1 + MAPPED.index(scenario)) * (2 - ESTIMATORS.index(estimator))
    return scale * (0.1 + noise) / sections * (2 if nominal == "wrong" else 1)


def test_every_cell_is_the_worst_scenario() -> None:
    nominals = ("as simulated", "wrong")
    rows = [
        RobustnessRow(s, name, b, noise, n, error(s, name, b, noise, n), 1.0, 1.0, 1.0, 20)
        for s, name, b, noise, n in product(MAPPED, ESTIMATORS, nominals, NOISES, (1, 2))
    ]
    figure = map_figure(rows)
    for axes, (nominal, sections) in zip(figure.axes, product(nominals, (1, 2)), strict=False):
        expected = [[error("box_grasp", e, nominal, noise, sections) for noise in NOISES] for e in ESTIMATORS]
        np.testing.assert_allclose(axes.images[0].get_array(), expected)
        assert [text.get_text() for text in axes.texts] == [f"{value:.2f}" for value in np.ravel(expected)]
    assert [label.get_text() for label in figure.axes[0].get_yticklabels()] == list(ESTIMATORS)


PAGE = Path(__file__).parents[3] / "docs/studies/robustness.md"
FIGURES = "sensors_1", "sensors_2", "sensors_4", "covered_percent_2"


def printed_rows() -> list[tuple[str, ...]]:
    """Scenario, estimator and numbers of every row of a table that names an estimator."""
    rows, scenario = [], ""
    for line in PAGE.read_text(encoding="utf-8").splitlines():
        cells = [cell.strip(" `").replace("–", "-") for cell in line.strip("|").split("|")]
        if len(cells) > 4 and cells[1] in ("arcs", "gaussian", "recursive"):
            scenario = cells[0] or scenario
            rows.append((scenario, *cells[1:]))
    return rows


def test_every_row_of_the_page_is_one_of_the_table():
    with PAGE.with_suffix(".csv").open(encoding="utf-8", newline="") as file:
        table = [
            (row["scenario"], row["estimator"], *(row[name] for name in FIGURES if row[name]))
            for row in csv.DictReader(file)
        ]
    printed = printed_rows()
    assert len(printed) == 10
    assert set(printed) <= set(table)
