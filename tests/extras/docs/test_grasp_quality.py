"""Numbers of docs/grasp_quality.md are those that a run gives, to the last digit."""

from pathlib import Path

import pytest
from printed_numbers import printed

from soft_gripper.runs.sweep.measured_runs import run_and_measure
from soft_gripper.truth.contact import combined_friction

PAGE = (Path(__file__).parents[3] / "docs" / "grasp_quality.md").read_text(encoding="utf-8")
LENGTH, MODULUS = "models.gripper.fingers.all.length", "models.gripper.fingers.all.youngs_modulus"

WEIGHT = 0.06 * 9.81  # N, carried by two fingers
FRICTION = combined_friction(0.8, 0.9)  # of the bottle and the fingers


@pytest.mark.published
def test_the_corners_of_the_sweep():
    """Least and most force; what lies between is in the figure."""
    first = printed(PAGE, r"\| 100 \| (.*) N, (.*) % \|.*\|.*\|")
    last = printed(PAGE, r"\| 140 \|.*\|.*\| (.*) N, (.*) % \|")
    for length, modulus, numbers in ((0.10, "-30 %", first), (0.14, "+30 %", last)):
        found = run_and_measure("bottle_grasp", {LENGTH: length, MODULUS: modulus})
        assert found["grasp"] == "held"
        assert f"{found['normal_force_n']:.2f}" == numbers[0]
        assert f"{100 * found['slip_ratio']:.0f}" == numbers[1]
        assert f"takes {found['least_force_n']:.2f} N per finger" in PAGE
        assert found["friction_force_n"] == pytest.approx(WEIGHT / 2, rel=1e-3)
        assert found["least_force_n"] == pytest.approx(WEIGHT / 2 / FRICTION, rel=1e-3)
