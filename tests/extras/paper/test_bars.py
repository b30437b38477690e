"""Bars: a mean that is kept in one scenario and not in another fails, and so does the tip alone, or one step."""

from dataclasses import replace
from itertools import product

import pytest

from soft_gripper.extras.paper.bars import BARS, ONE_PLACE, estimator_claims
from soft_gripper.runs.scores.poses import PoseRow

SCENARIOS = ("free_bending", *ONE_PLACE, "irregular_grasp")
ERRORS = {1: 1.4, 2: 0.28, 3: 0.14, 4: 0.14}  # mm, pose; the tip errs 1.9 times as much
ROWS = [
    PoseRow(s, "finger", name, "as simulated", n, p, 0.0, part * ERRORS[n], 1.9 * part * ERRORS[n])
    for (name, part), s, n, p in product((("arcs", 1.0), ("spline", 1.0), ("gaussian", 1.0)), SCENARIOS, ERRORS, (1, 2))
]


def changed(column: str, add: float, rows: list[PoseRow] = ROWS, **where: object) -> list[PoseRow]:
    """The rows with more in a column where all of `where` is so."""
    hit = [all(getattr(row, key) == value for key, value in where.items()) for row in rows]
    assert any(hit)
    change = [{column: getattr(row, column) + add} if it else {} for row, it in zip(rows, hit, strict=True)]
    return [replace(row, **more) for row, more in zip(rows, change, strict=True)]


def failing(rows: list[PoseRow]) -> list[int]:
    return [i for i, claim in enumerate(estimator_claims(rows)) if not claim.holds]


def test_all_hold_just_below_the_bars() -> None:
    claims = estimator_claims(ROWS)
    assert [claim.holds for claim in claims] == [True] * (len(BARS) + 1)
    assert claims[0].number == "1.40 and 1.40 mm; tip 2.66 and 2.66 mm"


@pytest.mark.parametrize(
    ("sections", "scenario", "column", "add", "fails"),
    [
        (1, "irregular_grasp", "pose_error_mm", 0.5, []),
        (1, "irregular_grasp", "pose_error_mm", 0.7, [0]),
        (1, "box_grasp", "pose_error_mm", 0.2, [1]),
        (1, "box_grasp", "tip_error_mm", 0.4, [1]),
        (2, "free_bending", "pose_error_mm", 0.25, [2]),
        (2, "obstructed_inside", "pose_error_mm", 0.05, [3]),
        (3, "free_bending", "pose_error_mm", 0.02, [4]),
        (4, "obstructed_inside", "tip_error_mm", 0.05, [4]),
    ],
)
def test_a_scenario_alone_breaks_a_mean(
    sections: int, scenario: str, column: str, add: float, fails: list[int]
) -> None:
    rows = changed(column, add, estimator="gaussian", sections=sections, scenario=scenario)
    assert [i for i in failing(rows) if i < len(BARS)] == fails


def test_none_may_be_a_tenth_of_a_millimetre_worse_than_arcs_at_a_step() -> None:
    where = {"estimator": "spline", "sections": 3, "scenario": "box_grasp", "pressure_kpa": 2}
    assert failing(changed("pose_error_mm", 0.09, **where)) == []
    worse = changed("pose_error_mm", 0.11, **where)
    assert failing(worse) == [len(BARS)]
    assert estimator_claims(worse)[-1].number == "0.110 mm worse: spline, 3 per side, box_grasp at 2 kPa"
