"""Claims: each holds for errors that are small enough, and fails as soon as one step is not."""

from dataclasses import replace
from itertools import product
from typing import Any

import pytest

from soft_gripper.evaluation.paper.claims import claims
from soft_gripper.evaluation.paper.force_table import ForceRow
from soft_gripper.evaluation.paper.pose_table import PoseRow

FREE, INSIDE, GRASP = "free_bending", "obstructed_inside", "box_grasp"
ERRORS = {FREE: (2.0, 0.9, 0.7, 0.5), INSIDE: (8.0, 3.0, 1.5, 0.8), GRASP: (8.0, 3.0, 1.5, 0.8)}  # mm
STEPS = (0.0, 50.0, 100.0)  # kPa
POSES = [
    PoseRow(scenario, "finger", "arcs", "as simulated", n, pressure, 1.5 * pressure, error, 2 * error)
    for scenario, errors in ERRORS.items()
    for (n, error), pressure in product(enumerate(errors, start=1), STEPS)
]
FORCES = [
    ForceRow(scenario, "finger", "arcs", "as simulated", 4, pressure, joint, 1.05 * torque + 1e-3, torque)
    for scenario, torque in ((FREE, 0.0), (INSIDE, -0.04), (GRASP, 0.0))
    for pressure, joint in product(STEPS, (0, 1))
]
STEP = {"pressure_kpa": 50.0}

BREAKING_POSES = [
    ({"scenario": FREE, "sections": 1, **STEP, "pose_error_mm": 3.1}, ["one sensor is within 3 mm"]),
    ({"scenario": FREE, "sections": 3, **STEP, "pose_error_mm": 2.1}, ["never worse than one"]),
    ({"scenario": FREE, "sections": 4, **STEP, "pose_error_mm": 1.1}, ["free bending: four sensors are within 1 mm"]),
    ({"scenario": FREE, "bend_angle_deg": 119.0}, ["120 degrees"]),
    ({"scenario": GRASP, "sections": 1, "pose_error_mm": 2.3}, ["one sensor is not enough"]),
    ({"scenario": INSIDE, "sections": 3, **STEP, "pose_error_mm": 3.1}, ["every one gains"]),
    ({"scenario": INSIDE, "sections": 4, "pose_error_mm": 1.2}, ["contact: four sensors are within 1 mm"]),
    ({"scenario": GRASP, "sections": 4, "tip_error_mm": 2.6}, ["find the tip"]),
    (
        {"scenario": INSIDE, "sections": 4, "pose_error_mm": 2.1},
        ["four sensors are within 2 mm", "contact: four sensors are within 1 mm", "every one gains"],
    ),
    (
        {"scenario": GRASP, "sections": 4, **STEP, "pose_error_mm": 2.6},
        ["within 2.5 mm at every step", "contact: four sensors are within 1 mm", "every one gains"],
    ),
]
BREAKING_FORCES = [
    ({"scenario": INSIDE, "joint": 0, **STEP, "estimated_nm": -0.0445}, ["base torque"]),
    ({"scenario": GRASP, "joint": 0, **STEP, "estimated_nm": 0.0021}, ["base torque"]),
    ({"scenario": FREE, "joint": 1, **STEP, "estimated_nm": -0.0021}, ["nothing is touched"]),
]


def failing(poses: list[PoseRow], forces: list[ForceRow]) -> list[str]:
    return [claim.text for claim in claims(poses, forces) if not claim.holds]


def changed(rows: list[Any], change: dict[str, Any]) -> list[Any]:
    """Rows of which the last item of `change` is the new value, where all its other items are true."""
    *where, (column, value) = change.items()
    hit = [all(getattr(row, key) == wanted for key, wanted in where) for row in rows]
    assert any(hit)
    return [replace(row, **{column: value}) if it else row for row, it in zip(rows, hit, strict=True)]


def test_all_hold_for_small_errors() -> None:
    assert len(claims(POSES, FORCES)) == 12
    assert failing(POSES, FORCES) == []


@pytest.mark.parametrize(("change", "fragments"), BREAKING_POSES)
def test_fails_for_a_pose_that_breaks_it_and_no_other(change: dict[str, Any], fragments: list[str]) -> None:
    texts = failing(changed(POSES, change), FORCES)
    assert len(texts) == len(fragments)
    assert all(any(fragment in text for text in texts) for fragment in fragments)


@pytest.mark.parametrize(("change", "fragments"), BREAKING_FORCES)
def test_fails_for_a_torque_that_breaks_it_and_no_other(change: dict[str, Any], fragments: list[str]) -> None:
    texts = failing(POSES, changed(FORCES, change))
    assert len(texts) == len(fragments)
    assert all(any(fragment in text for text in texts) for fragment in fragments)


def test_rounding_makes_no_sensor_worse() -> None:
    """A straight finger has no error, whatever the number of sensors; what is left is rounding."""
    straight = changed(POSES, {"scenario": FREE, "pressure_kpa": 0.0, "pose_error_mm": 0.0})
    rounded = changed(straight, {"scenario": FREE, "sections": 4, "pressure_kpa": 0.0, "pose_error_mm": 1e-12})
    assert failing(rounded, FORCES) == []


def test_a_difference_above_rounding_does() -> None:
    straight = changed(POSES, {"scenario": FREE, "pressure_kpa": 0.0, "pose_error_mm": 0.0})
    worse = changed(straight, {"scenario": FREE, "sections": 4, "pressure_kpa": 0.0, "pose_error_mm": 1e-3})
    assert ["never worse" in text for text in failing(worse, FORCES)] == [True]


def test_says_nothing_about_scenarios_that_were_not_run() -> None:
    free = [row for row in POSES if row.scenario == FREE]
    assert all(claim.text.startswith("free bending") for claim in claims(free, []))


def test_sources_and_numbers_are_given() -> None:
    found = claims(POSES, FORCES)
    assert {claim.source for claim in found} == {"paper", "ours"}
    assert all(any(digit.isdigit() for digit in claim.number) for claim in found)
