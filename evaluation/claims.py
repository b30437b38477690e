"""The claims about free bending, each held against our numbers."""

from collections.abc import Sequence
from dataclasses import dataclass

from soft_gripper.evaluation.pose_table import PoseRow


@dataclass(frozen=True)
class Claim:
    """What is claimed, by whom, whether it holds here, and our number."""

    source: str
    text: str
    holds: bool
    number: str


def free_bending_claims(rows: Sequence[PoseRow]) -> list[Claim]:
    """Claims about scenario `free_bending`, from the rows of all numbers of sections."""
    one, four = (max(_pose(rows, sections)) for sections in (1, 4))
    bends = [row.bend_angle_deg for row in rows]
    worse = _largest_excess(rows)
    return [
        Claim(
            "paper", "one sensor finds the pose within 3 mm at every step", one < 3.0, f"largest {one:.2f} mm"
        ),
        Claim("paper", "more sensors are never worse than one", worse <= 0, f"largest excess {worse:.4f} mm"),
        Claim(
            "ours",
            "four sensors find the pose within 1 mm at every step",
            four < 1.0,
            f"largest {four:.2f} mm",
        ),
        Claim("ours", "the steps reach 120 degrees of bend", max(bends) >= 120, f"{max(bends):.1f} degrees"),
    ]


def _pose(rows: Sequence[PoseRow], sections: int) -> list[float]:
    return [row.pose_error_mm for row in rows if row.sections == sections]


def _largest_excess(rows: Sequence[PoseRow]) -> float:
    """By how much any number of sections above one errs more than one does at the same step, mm.

    Errors below a nanometre are rounding and no ground to tell sensors apart.
    """
    counts = sorted({row.sections for row in rows} - {1})
    single = _pose(rows, 1)
    excess = [more - one for n in counts for more, one in zip(_pose(rows, n), single, strict=True)]
    return max(0.0 if abs(value) < 1e-6 else value for value in excess)
