"""Claims: each holds for errors like those measured, and fails as soon as one step is worse, or is no number."""

from dataclasses import replace
from itertools import product
from math import nan
from typing import Any

import pytest

from soft_gripper.extras.paper.claims import claims
from soft_gripper.runs.scores.external_torques import ForceRow
from soft_gripper.runs.scores.poses import PoseRow

FREE, INSIDE, GRASP = "free_bending", "obstructed_inside", "box_grasp"
MEANS = {FREE: (1.0, 0.3, 0.18, 0.11), INSIDE: (7.0, 1.5, 0.7, 0.39), GRASP: (3.2, 0.9, 0.43, 0.24)}  # mm
SPREAD = {FREE: (1.5, 1.4, 1.3, 1.2), INSIDE: (0.4, 0.5, 0.6, 0.7), GRASP: (0.45, 0.5, 0.55, 0.6)}  # of the steps
STEPS = (0.0, 50.0, 100.0)  # kPa
TORQUE = {FREE: (0.0, 0.0), INSIDE: (-0.4, -0.04), GRASP: (0.01, 0.0)}  # N m, of the two joints at 100 kPa


def errors_of(scenario: str, sections: int) -> list[float]:
    """Errors at the steps, their mean that of MEANS; at the first of them, none is below zero."""
    mean, spread = MEANS[scenario][sections - 1], SPREAD[scenario][sections - 1]
    return [mean * max(1 - spread, 0), mean * min(1.0, 2 - spread), mean * (1 + spread)]


POSES = [
    PoseRow(scenario, "finger", "arcs", "as simulated", n, pressure, 1.3 * pressure, error, 1.5 * error)
    for scenario, n in product(MEANS, (1, 2, 3, 4))
    for pressure, error in zip(STEPS, errors_of(scenario, n), strict=True)
]
FORCES = [
    ForceRow(scenario, "finger", "arcs", "as simulated", 4, p, joint, 1.001 * true + 5e-5, true)
    for scenario, p, joint in product(TORQUE, STEPS, (0, 1))
    for true in (TORQUE[scenario][joint] * p / 100.0,)
]
STEP = {"pressure_kpa": 50.0}
NOT_ENOUGH, ORDER, EVERY_ONE = "one sensor is not enough", "second order", "every one gains"
FREE_FOUR, CONTACT_MEAN = "125 degrees: four sensors are within 0.25 mm", "contact: four sensors are within 0.45 mm"
EVERY_STEP, TIP = "contact: four sensors are within 0.75 mm", "find the tip"
BASE, FALSE = "base torque", "nothing is touched"

BREAKING: list[tuple[dict[str, Any], list[str]]] = [
    ({"scenario": FREE, "sections": 1, **STEP, "pose_error_mm": 3.1}, ["within 3 mm", NOT_ENOUGH]),
    ({"scenario": FREE, "sections": 3, **STEP, "pose_error_mm": 1.1}, ["never worse than one"]),
    ({"scenario": FREE, "sections": 4, **STEP, "pose_error_mm": 0.26}, [FREE_FOUR]),
    ({"scenario": FREE, "bend_angle_deg": 124.0}, [FREE_FOUR]),
    ({"scenario": GRASP, "sections": 1, "pose_error_mm": 2.4}, [NOT_ENOUGH]),
    ({"scenario": INSIDE, "sections": 1, "pose_error_mm": 2.4}, [NOT_ENOUGH]),
    ({"scenario": INSIDE, "sections": 3, **STEP, "pose_error_mm": 1.8}, [EVERY_ONE]),
    ({"scenario": GRASP, "sections": 2, "pose_error_mm": 0.8}, [ORDER]),
    ({"scenario": GRASP, "sections": 4, "pressure_kpa": 100.0, "pose_error_mm": 0.2}, [ORDER]),
    ({"scenario": INSIDE, "sections": 4, "pose_error_mm": 0.46}, [CONTACT_MEAN, EVERY_ONE, ORDER]),
    ({"scenario": GRASP, "sections": 4, **STEP, "tip_error_mm": 2.0}, [TIP]),
    ({"scenario": INSIDE, "sections": 4, "pose_error_mm": 2.1}, [CONTACT_MEAN, EVERY_STEP, EVERY_ONE, ORDER]),
    ({"scenario": INSIDE, "sections": 4, "pressure_kpa": 100.0, "pose_error_mm": 0.76}, [EVERY_STEP]),
    ({"scenario": INSIDE, "joint": 0, **STEP, "estimated_nm": -0.20041}, [BASE]),
    ({"scenario": INSIDE, "joint": 0, **STEP, "estimated_nm": -0.19959}, [BASE]),
    ({"scenario": GRASP, "joint": 0, **STEP, "estimated_nm": 0.00551}, [BASE]),
    ({"scenario": FREE, "joint": 1, **STEP, "estimated_nm": -0.00041}, [FALSE]),
]
NEEDING: list[tuple[dict[str, Any], list[str]]] = [
    ({"scenario": FREE, "sections": 1, "pose_error_mm": nan}, ["within 3 mm", "never worse than one", NOT_ENOUGH]),
    ({"scenario": FREE, "sections": 3, "pose_error_mm": nan}, ["never worse than one"]),
    ({"scenario": FREE, "sections": 4, "pose_error_mm": nan}, [FREE_FOUR, "never worse than one"]),
    ({"scenario": FREE, "sections": 2, "bend_angle_deg": nan}, [FREE_FOUR]),
    ({"scenario": INSIDE, "sections": 1, "pose_error_mm": nan}, [NOT_ENOUGH, EVERY_ONE]),
    ({"scenario": GRASP, "sections": 1, "pose_error_mm": nan}, [NOT_ENOUGH, EVERY_ONE]),
    ({"scenario": INSIDE, "sections": 2, "pose_error_mm": nan}, [EVERY_ONE, ORDER]),
    ({"scenario": INSIDE, "sections": 3, "pose_error_mm": nan}, [EVERY_ONE]),
    ({"scenario": GRASP, "sections": 4, "pose_error_mm": nan}, [CONTACT_MEAN, EVERY_STEP, EVERY_ONE, ORDER]),
    ({"scenario": INSIDE, "sections": 4, "tip_error_mm": nan}, [TIP]),
    ({"scenario": GRASP, "sections": 4, "tip_error_mm": nan}, [TIP]),
    ({"scenario": FREE, "joint": 1, "estimated_nm": nan}, [FALSE]),
    ({"scenario": INSIDE, "joint": 0, "estimated_nm": nan}, [BASE]),
    ({"scenario": GRASP, "joint": 0, "estimated_nm": nan}, [BASE]),
    ({"scenario": INSIDE, "joint": 0, "true_nm": nan}, [BASE]),
]


def failing(poses: list[PoseRow], forces: list[ForceRow]) -> list[str]:
    return [claim.text for claim in claims(poses, forces) if not claim.holds]


def failing_with(change: dict[str, Any]) -> list[str]:
    """With a pose that is changed, or a torque, of which a joint is named."""
    of_torque = "joint" in change
    return failing(POSES if of_torque else changed(POSES, change), changed(FORCES, change) if of_torque else FORCES)


def changed(rows: list[Any], change: dict[str, Any]) -> list[Any]:
    """Rows of which the last item of `change` is the new value, where all its other items are true."""
    *where, (column, value) = change.items()
    hit = [all(getattr(row, key) == wanted for key, wanted in where) for row in rows]
    assert any(hit)
    return [replace(row, **{column: value}) if it else row for row, it in zip(rows, hit, strict=True)]


def require_only(texts: list[str], fragments: list[str]) -> None:
    assert len(texts) == len(fragments), texts
    assert all(any(fragment in text for text in texts) for fragment in fragments), texts


def test_all_hold_for_small_errors() -> None:
    assert {claim.source for claim in claims(POSES, FORCES)} == {"paper", "ours"}
    assert len(claims(POSES, FORCES)) == 11
    assert failing(POSES, FORCES) == []


@pytest.mark.parametrize(("change", "fragments"), BREAKING)
def test_fails_for_a_pose_or_torque_that_breaks_it_and_no_other(change: dict[str, Any], fragments: list[str]) -> None:
    require_only(failing_with(change), fragments)


@pytest.mark.parametrize("pressure", STEPS)
@pytest.mark.parametrize(("change", "fragments"), NEEDING)
def test_nan_makes_every_claim_that_needs_it_fail(
    change: dict[str, Any], fragments: list[str], pressure: float
) -> None:
    """At the first step as at the last: Python's max and min depend on where NaN stands."""
    *where, column = change.items()
    texts = failing_with(dict([*where, ("pressure_kpa", pressure), column]))
    assert all(any(fragment in text for text in texts) for fragment in fragments), texts
    if "joint" in change:
        assert len(texts) == len(fragments), texts


def test_numbers_are_means_where_means_are_claimed_and_maxima_where_every_step_is() -> None:
    numbers = {claim.text: claim.number for claim in claims(POSES, FORCES)}
    expected = {
        "within 3 mm": "2.50 mm",
        "never worse": "0.000 mm worse",
        FREE_FOUR: "0.24 mm, 130.0 degrees",
        NOT_ENOUGH: "3.2 to 7.0 times",
        CONTACT_MEAN: "0.39 mm",
        EVERY_STEP: "0.66 mm",
        TIP: "0.58 mm",
        EVERY_ONE: "largest gains 1.6 and 2.4 mm",
        ORDER: "3.75 to 3.85 times",
        BASE: "0.09 %, 0.060 mN m",
        FALSE: "0.05 mN m",
    }
    for fragment, number in expected.items():
        assert [given for text, given in numbers.items() if fragment in text and number in given], (fragment, numbers)


def test_no_torque_to_compare_proves_nothing() -> None:
    untouched = [replace(row, true_nm=0.0, estimated_nm=0.0) for row in FORCES]
    require_only(failing(POSES, untouched), [BASE])


def test_says_nothing_about_scenarios_that_were_not_run() -> None:
    free = [row for row in POSES if row.scenario == FREE]
    assert all(claim.text.startswith("free bending") for claim in claims(free, []))
    contact = [row for row in POSES if row.scenario != FREE]
    assert not any("free bending" in claim.text for claim in claims(contact, FORCES[6:]))
