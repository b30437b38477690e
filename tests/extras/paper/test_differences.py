"""The box on the paper: its numbers are those of the tables and of the computation, and change with them."""

from dataclasses import replace
from itertools import product

import numpy as np
import pytest

from soft_gripper.extras.paper.differences import TipErrors, differences
from soft_gripper.runs.scores.poses import PoseRow

FREE, CONTACT = "free_bending", ("obstructed_inside", "box_grasp")
POSE = {FREE: (1.0, 0.3, 0.2, 0.1), CONTACT[0]: (7.0, 1.75, 0.8, 0.5), CONTACT[1]: (4.0, 1.0, 0.45, 0.25)}  # mm
POSES = [
    PoseRow(name, "finger", "arcs", "as simulated", n + 1, kpa, 0.0, share * pose[n], 2 * share * pose[n])
    for (name, pose), n, (kpa, share) in product(POSE.items(), range(4), ((50.0, 0.5), (100.0, 1.5)))
]
STARTS = np.array([[3e-3, 5e-3], [4e-3, 5.5e-3], [4e-3, 5e-3], [3e-3, 4.5e-3]])  # m, means 4, 4.75, 4.5, 3.75 mm
ERRORS = TipErrors((1, 2, 3, 4), np.zeros((4, 2)), STARTS, np.zeros((4, 2)))


def box(rows: list[PoseRow], errors: TipErrors = ERRORS) -> list[str]:
    """What is said of every subject, here and why."""
    return [f"{row.here} {row.reason}" for row in differences(rows, FREE, CONTACT, errors)]


def mutated(scenario: str, sections: int, error: str, change: float) -> list[PoseRow]:
    """The rows with one error changed, at the larger pressure."""
    where = (scenario, sections, 100.0)
    return [
        replace(row, **{error: getattr(row, error) + change})
        if (row.scenario, row.sections, row.pressure_kpa) == where
        else row
        for row in POSES
    ]


def test_says_the_means_of_free_bending_and_of_the_other_chain() -> None:
    fingertip, _, _ = box(POSES)
    assert "2.00, 0.60, 0.40 and 0.20 mm with 1 to 4 sensors" in fingertip
    assert "give 4.00, 4.75, 4.50 and 3.75 mm" in fingertip


def test_says_the_largest_gains_of_any_step_beside_the_papers() -> None:
    _, gain, _ = differences(POSES, FREE, CONTACT, ERRORS)
    assert gain.paper == "4 mm (pose) and 6 mm (fingertip)."
    assert "Up to 1.9 mm (pose) and 3.8 mm (fingertip)" in gain.here  # 1.5 (1.75 - 0.5), and twice that
    assert "1.75 mm at most" in gain.reason


def test_says_what_every_further_sensor_gains_at_most() -> None:
    *_, flattening = box(POSES)
    assert "5.25, 0.95 and 0.30 mm" in flattening


@pytest.mark.parametrize(
    ("change", "subjects"),
    [
        ((FREE, 3, "tip_error_mm", 1.0), [0]),
        ((CONTACT[0], 2, "pose_error_mm", 0.5), [1, 2]),
        ((CONTACT[0], 4, "tip_error_mm", -0.5), [1]),
        ((CONTACT[1], 4, "tip_error_mm", -0.1), []),
        ((CONTACT[0], 3, "pose_error_mm", 0.5), [2]),
        ((CONTACT[1], 1, "pose_error_mm", 9.0), [2]),
    ],
    ids=str,
)
def test_another_number_changes_what_is_said_of_it_and_nothing_else(
    change: tuple[str, int, str, float], subjects: list[int]
) -> None:
    before, after = box(POSES), box(mutated(*change))
    assert [i for i in range(3) if before[i] != after[i]] == subjects


def test_another_computation_changes_the_reason() -> None:
    other = replace(ERRORS, starts=STARTS + 1e-4)
    assert [i for i in range(3) if box(POSES)[i] != box(POSES, other)[i]] == [0]
    assert "give 4.10, 4.85, 4.60 and 3.85 mm" in box(POSES, other)[0]
