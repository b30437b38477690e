"""Compares the findings of the paper and the claims of this project with our results. A claim is a `Claim` of `claims`.

Our bars are close to the measured numbers, so that a change for the worse shows.
NaN in what a claim needs makes it fail: NumPy's reductions propagate NaN, and no comparison with NaN is true.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from soft_gripper.arrays import Array
from soft_gripper.extras.paper.pose_rows import errors_of, largest_gain, mean_errors
from soft_gripper.runs.scores.external_torques import ForceRow
from soft_gripper.runs.scores.poses import PoseRow

FREE = "free_bending"
SAME = 5e-3  # mm; smaller differences between errors, as before a grasp touches anything, are no reason to prefer one
PAPER_MEAN = 2  # mm, with four sensors in contact
PAPER_POSE_GAIN, PAPER_TIP_GAIN = 4, 6  # mm, from two to four sensors
LARGE = 0.1  # N m; of torques above it the relative error is of interest
FAR = 125  # degrees of bend, that free bending must reach to prove anything
SECOND_ORDER = 3.5, 4.2  # times, by which arcs of half the length err less; 4 where they are short


@dataclass(frozen=True)
class Claim:
    """A claim: its text, its source, whether it holds here, and our number."""

    source: str
    text: str
    holds: bool
    number: str


def claims(poses: Sequence[PoseRow], forces: Sequence[ForceRow]) -> list[Claim]:
    """Collects all claims about the scenarios in the rows."""
    scenarios = list(dict.fromkeys(row.scenario for row in poses))
    contact = [scenario for scenario in scenarios if scenario != FREE]
    all_claims: list[Claim] = []
    if FREE in scenarios:
        all_claims += _free_bending(poses)
    if FREE in scenarios and contact:
        all_claims.append(_single_sensor_claim(poses, contact))
    if contact:
        all_claims += _contact(poses, contact) + _more_sensors(poses, contact) + _base_torque(forces, contact)
    if any(row.scenario == FREE for row in forces):
        all_claims.append(_free_load_claim(forces))
    return all_claims


def verdict(all_claims: Sequence[Claim]) -> str:
    """The number of failed claims, as text."""
    failed = sum(not claim.holds for claim in all_claims)
    return f"{failed} of {len(all_claims)} claims failed" if failed else f"all {len(all_claims)} claims hold"


def _free_bending(rows: Sequence[PoseRow]) -> list[Claim]:
    error_1, error_4 = (_pose(rows, FREE, sections).max() for sections in (1, 4))
    bend = np.max([row.bend_angle_deg for row in rows if row.scenario == FREE])
    excess = np.max([_excess(rows, FREE, count, 1) for count in (2, 3, 4)])
    return [
        _claim("paper", "free bending: one sensor is within 3 mm at every step", error_1 < 3, f"{error_1:.2f} mm"),
        _claim(
            "paper",
            "free bending: more sensors are never worse than one",
            excess <= 0,
            f"{np.maximum(excess, 0):.3f} mm worse",
        ),
        _claim(
            "ours",
            f"free bending up to {FAR} degrees: four sensors are within 0.25 mm at every step",
            error_4 < 0.25 and bend >= FAR,
            f"{error_4:.2f} mm, {bend:.1f} degrees",
        ),
    ]


def _single_sensor_claim(rows: Sequence[PoseRow], scenarios: Sequence[str]) -> Claim:
    """Checks that one sensor errs 2.5 times as much in contact as in free bending."""
    ratios = np.array([_pose(rows, s, 1).mean() for s in scenarios]) / _pose(rows, FREE, 1).mean()
    text = "contact: one sensor is not enough, its mean error is at least 2.5 times that of free bending"
    return _claim("paper", text, ratios.min() >= 2.5, f"{ratios.min():.1f} to {ratios.max():.1f} times")


def _contact(rows: Sequence[PoseRow], scenarios: Sequence[str]) -> list[Claim]:
    mean_error, tip = (
        np.max([errors_of(rows, s, 4, error).mean() for s in scenarios]) for error in ("pose_error_mm", "tip_error_mm")
    )
    largest = np.max([_pose(rows, s, 4).max() for s in scenarios])
    return [
        _claim(
            "ours",
            f"contact: four sensors are within 0.45 mm in the mean (paper: {PAPER_MEAN} mm)",
            mean_error <= 0.45,
            f"{mean_error:.2f} mm",
        ),
        _claim("ours", "contact: four sensors are within 0.75 mm at every step", largest <= 0.75, f"{largest:.2f} mm"),
        _claim("ours", "contact: four sensors find the tip within 0.6 mm (mean)", tip <= 0.6, f"{tip:.2f} mm"),
    ]


def _more_sensors(rows: Sequence[PoseRow], scenarios: Sequence[str]) -> list[Claim]:
    excess = np.max([_excess(rows, s, count + 1, count) for s in scenarios for count in (2, 3)])
    pose_gain, tip_gain = (largest_gain(rows, scenarios, 2, 4, error) for error in ("pose_error_mm", "tip_error_mm"))
    gains = np.array([-np.diff(mean_errors(rows, s, "pose_error_mm")) for s in scenarios])
    ratios = np.array([_pose(rows, s, 2).mean() / _pose(rows, s, 4).mean() for s in scenarios])
    low, high = SECOND_ORDER
    return [
        _claim(
            "paper",
            "contact: from two to four sensors every one gains",
            excess <= 0 and gains.min() > 0,
            f"largest gains {pose_gain:.1f} and {tip_gain:.1f} mm (paper: {PAPER_POSE_GAIN} and {PAPER_TIP_GAIN})",
        ),
        _claim(
            "ours",
            f"contact: an error of second order, with two sensors {low:g} to {high:g} times that with four",
            ratios.min() >= low and ratios.max() <= high,
            f"{ratios.min():.2f} to {ratios.max():.2f} times",
        ),
    ]


def _base_torque(rows: Sequence[ForceRow], scenarios: Sequence[str]) -> list[Claim]:
    base_rows = [row for row in rows if row.sections == 4 and row.joint == 0 and row.scenario in scenarios]
    torque = np.abs([row.true_nm for row in base_rows])
    error = np.abs([row.estimated_nm - row.true_nm for row in base_rows])
    is_large = torque > LARGE
    relative, small_error = np.max(error[is_large] / torque[is_large], initial=0), np.max(error[~is_large], initial=0)
    return [
        _claim(
            "ours",
            "force: base torque within 0.2 % above 100 mN m, within 0.5 mN m below",
            is_large.any() and relative <= 0.002 and small_error <= 5e-4,
            f"{100 * relative:.2f} %, {1e3 * small_error:.3f} mN m",
        )
    ]


def _free_load_claim(rows: Sequence[ForceRow]) -> Claim:
    free_torque = np.max(np.abs([row.estimated_nm for row in rows if row.sections == 4 and row.scenario == FREE]))
    text = "force: below 0.4 mN m at every joint where nothing is touched"
    return _claim("ours", text, free_torque < 4e-4, f"{1e3 * free_torque:.2f} mN m")


def _claim(source: str, text: str, holds: bool | np.bool_, number: str) -> Claim:
    return Claim(source, text, bool(holds), number)


def _pose(rows: Sequence[PoseRow], scenario: str, sections: int) -> Array:
    return errors_of(rows, scenario, sections, "pose_error_mm")


def _excess(rows: Sequence[PoseRow], scenario: str, count: int, reference_count: int) -> float:
    """Largest excess of the error with `count` sensors over that with `reference_count` at one step, mm."""
    excess = _pose(rows, scenario, count) - _pose(rows, scenario, reference_count)
    return float(np.max(np.where(np.abs(excess) < SAME, 0, excess)))
