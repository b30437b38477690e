"""What the paper found, and what this project promises, each compared with our numbers."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from soft_gripper.evaluation.paper.force_table import ForceRow
from soft_gripper.evaluation.paper.pose_table import PoseRow

FREE = "free_bending"
ROUNDING = 1e-6  # mm; smaller differences between errors are no ground to prefer one sensor to another


@dataclass(frozen=True)
class Claim:
    """What is claimed, by whom, whether it holds here, and our number."""

    source: str
    text: str
    holds: bool
    number: str


def claims(poses: Sequence[PoseRow], forces: Sequence[ForceRow]) -> list[Claim]:
    """All claims about the scenarios that the rows speak of."""
    scenarios = list(dict.fromkeys(row.scenario for row in poses))
    found = _free_bending(poses) if FREE in scenarios else []
    contact = [scenario for scenario in scenarios if scenario != FREE]
    if contact:
        found += _contact(poses, contact) + _force(forces, contact)
    return found


def _free_bending(rows: Sequence[PoseRow]) -> list[Claim]:
    one, four = (_largest(_pose(rows, FREE, sections)) for sections in (1, 4))
    bend = max(row.bend_angle_deg for row in rows if row.scenario == FREE)
    worse = _excess(rows, FREE, 1)
    return [
        Claim("paper", "free bending: one sensor is within 3 mm at every step", one < 3, f"{one:.2f} mm"),
        Claim(
            "paper",
            "free bending: more sensors are never worse than one",
            worse <= 0,
            f"{max(worse, 0):.3f} mm worse",
        ),
        Claim("ours", "free bending: four sensors are within 1 mm at every step", four < 1, f"{four:.2f} mm"),
        Claim("ours", "free bending: up to 120 degrees of bend", bend >= 120, f"{bend:.1f} degrees"),
    ]


def _contact(rows: Sequence[PoseRow], scenarios: Sequence[str]) -> list[Claim]:
    one, four = ({s: _mean(_pose(rows, s, n)) for s in scenarios} for n in (1, 4))
    ratio = min(one[s] / four[s] for s in scenarios)
    mean = _largest(list(four.values()))
    largest = _largest([_largest(_pose(rows, s, 4)) for s in scenarios])
    tip = _largest([_mean(_of(rows, s, 4, "tip_error_mm")) for s in scenarios])
    worse = max(_excess(rows, s, n) for s in scenarios for n in (2, 3))
    pose_gain, tip_gain = (_gain(rows, scenarios, error) for error in ("pose_error_mm", "tip_error_mm"))
    gains = f"largest gains {pose_gain:.1f} and {tip_gain:.1f} mm (paper: 4 and 6)"
    return [
        Claim(
            "paper",
            "contact: one sensor is not enough, 3 times worse than four",
            ratio > 3,
            f"{ratio:.0f} times",
        ),
        Claim("paper", "contact: four sensors are within 2 mm in the mean", mean <= 2, f"{mean:.2f} mm"),
        Claim("paper", "contact: from two to four sensors every one gains", worse <= 0, gains),
        Claim("ours", "contact: four sensors are within 1 mm in the mean", mean <= 1, f"{mean:.2f} mm"),
        Claim(
            "ours",
            "contact: four sensors are within 2.5 mm at every step",
            largest <= 2.5,
            f"{largest:.2f} mm",
        ),
        Claim("ours", "contact: four sensors find the tip within 2.5 mm (mean)", tip <= 2.5, f"{tip:.2f} mm"),
    ]


def _force(rows: Sequence[ForceRow], scenarios: Sequence[str]) -> list[Claim]:
    base = [row for row in rows if row.sections == 4 and row.joint == 0 and row.scenario in scenarios]
    free = [row for row in rows if row.sections == 4 and row.scenario == FREE]
    allowed = _largest([abs(r.estimated_nm - r.true_nm) / max(0.1 * abs(r.true_nm), 2e-3) for r in base])
    large = [row for row in base if abs(row.true_nm) > 0.02]
    relative = max((abs(r.estimated_nm / r.true_nm - 1) for r in large), default=0.0)
    text = "force: base torque within 10 %, or 2 mN m where small"
    found = [Claim("ours", text, allowed <= 1, f"{100 * relative:.1f} % above 20 mN m")]
    if free:
        false = _largest([abs(row.estimated_nm) for row in free])
        text = "force: below 2 mN m a joint where nothing is touched"
        found.append(Claim("ours", text, false < 2e-3, f"{1e3 * false:.2f} mN m"))
    return found


def _of(rows: Sequence[PoseRow], scenario: str, sections: int, error: str) -> list[float]:
    return [getattr(row, error) for row in rows if row.scenario == scenario and row.sections == sections]


def _pose(rows: Sequence[PoseRow], scenario: str, sections: int) -> list[float]:
    return _of(rows, scenario, sections, "pose_error_mm")


def _largest(values: Sequence[float]) -> float:
    """The maximum; NaN if any is NaN, so that no claim holds by default."""
    return float(np.max(values))


def _mean(values: Sequence[float]) -> float:
    return sum(values) / len(values)


def _excess(rows: Sequence[PoseRow], scenario: str, few: int) -> float:
    """By how much more sensors err beyond `few` at one step: few + 1, or any number above 1; mm."""
    more = (2, 3, 4) if few == 1 else (few + 1,)
    fewer = _pose(rows, scenario, few)
    excess = [m - f for n in more for m, f in zip(_pose(rows, scenario, n), fewer, strict=True)]
    return max(0.0 if abs(value) < ROUNDING else value for value in excess)


def _gain(rows: Sequence[PoseRow], scenarios: Sequence[str], error: str) -> float:
    """Largest gain from two to four sensors at one step, mm."""
    return max(
        two - four for s in scenarios for two, four in zip(_of(rows, s, 2, error), _of(rows, s, 4, error), strict=True)
    )
