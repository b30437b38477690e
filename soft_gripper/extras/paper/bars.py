"""Accuracy targets for the best built-in estimator: largest errors by number of sensors."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from soft_gripper.extras.paper.claims import Claim
from soft_gripper.extras.paper.pose_rows import errors_of, estimator_rows
from soft_gripper.runs.scores.poses import PoseRow

BEST = "gaussian"
ONE_PLACE = ("obstructed_inside", "obstructed_outside", "box_grasp")  # with one contact location per finger
ARCS = "arcs"
SAME = 0.1  # mm, by which an estimator may be worse than arcs at a step
POSE, TIP = "pose_error_mm", "tip_error_mm"


@dataclass(frozen=True)
class Bar:
    """Largest allowed pose errors, mm, for numbers of sensors per side; the fingertip's may be twice as large."""

    sections: tuple[int, ...]
    mean: float  # mm, over the steps of any scenario
    worst: float | None = None  # mm, at any step; None: no bar
    scenarios: tuple[str, ...] | None = None  # None: all

    def times(self, factor: float) -> "Bar":
        """The bar multiplied by a factor."""
        bound = None if self.worst is None else factor * self.worst
        return Bar(self.sections, factor * self.mean, bound, self.scenarios)

    @property
    def text(self) -> str:
        """The text of the claim."""
        sensors = " or ".join(map(str, self.sections)) + (" sensor" if self.sections == (1,) else " sensors")
        place = "" if self.scenarios is None else ", one place touched"
        bound_text = "" if self.worst is None else f", {self.worst:.3g} mm at every step"
        return f"{sensors} per side{place}: within {self.mean:.3g} mm (mean){bound_text}; the tip twice that"


BARS = (
    Bar((1,), 2.0, 3.5),
    Bar((1,), 1.5, 2.5, ONE_PLACE),
    Bar((2,), 0.5, 1.0),
    Bar((2,), 0.3, 0.7, ONE_PLACE),
    Bar((3, 4), 0.15),
)


def estimator_claims(rows: Sequence[PoseRow]) -> list[Claim]:
    """The claims about the built-in estimators, on the recordings of the paper's scenarios."""
    return [*(bar_claim(rows, bar, f"{BEST}, ") for bar in BARS), _none_is_worse(rows)]


def bar_claim(rows: Sequence[PoseRow], bar: Bar, subject: str) -> Claim:
    """Claim that the best estimator keeps a bar in all scenarios of the rows; `subject` begins the text."""
    means, maxima = zip(*(_errors(rows, bar, column) for column in (POSE, TIP)), strict=True)
    is_kept = all(m <= bar.mean * factor for m, factor in zip(means, (1, 2), strict=True))
    if bar.worst is not None:
        is_kept = is_kept and all(error <= bar.worst * factor for error, factor in zip(maxima, (1, 2), strict=True))
    result = f"{means[0]:.2f} and {maxima[0]:.2f} mm; tip {means[1]:.2f} and {maxima[1]:.2f} mm"
    return Claim("ours", subject + bar.text, bool(is_kept), result)


def _errors(rows: Sequence[PoseRow], bar: Bar, column: str) -> tuple[float, float]:
    """The largest mean of any scenario and number of sensors, and the largest of any step, mm; NaN passes through."""
    best_rows = estimator_rows(rows, BEST)
    names = [name for name in dict.fromkeys(row.scenario for row in best_rows) if name in (bar.scenarios or (name,))]
    errors = [errors_of(best_rows, name, sections, column) for name in names for sections in bar.sections]
    return float(np.max([error.mean() for error in errors])), float(np.max([error.max() for error in errors]))


def _none_is_worse(rows: Sequence[PoseRow]) -> Claim:
    arcs = np.array([row.pose_error_mm for row in estimator_rows(rows, ARCS)])
    other_rows = [estimator_rows(rows, name) for name in dict.fromkeys(row.estimator for row in rows) if name != ARCS]
    excess = np.array([[row.pose_error_mm for row in group] for group in other_rows]) - arcs
    estimator, step = np.unravel_index(np.argmax(excess), excess.shape)
    worst_row = other_rows[estimator][step]
    run = f"{worst_row.scenario} at {worst_row.pressure_kpa:.0f} kPa"
    text = f"no estimator is more than {SAME:g} mm worse than {ARCS} at any step"
    result = f"{excess[estimator, step]:.3f} mm worse: {worst_row.estimator}, {worst_row.sections} per side, {run}"
    return Claim("ours", text, bool(np.max(excess) <= SAME), result)
