"""The figures of the paper, from the rows of the evaluation."""

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import matplotlib as mpl
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from soft_gripper.evaluation.pose_table import PoseRow, mean

from soft_gripper.files import whole_file

STYLE: dict[Any, Any] = {
    "font.size": 9,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "svg.hashsalt": "soft-gripper",
}
COLORS = {1: "#b2182b", 2: "#ef8a62", 3: "#67a9cf", 4: "#2166ac"}
MARKERS = {1: "o", 2: "s", 3: "^", 4: "D"}


def free_bending_figure(rows: Sequence[PoseRow]) -> Figure:
    """Fig. 5: pose error (left) and fingertip error (right) against the bend angle, 1 to 4 sensors."""
    with mpl.rc_context(STYLE):
        figure = Figure(figsize=(8, 3.4), layout="constrained")
        pose, tip = figure.subplots(1, 2, sharex=True)
        _errors_against_bend(pose, rows, "pose_error_mm")
        _errors_against_bend(tip, rows, "tip_error_mm")
        pose.set(title="Mean pose error", ylabel="error [mm]", xlabel="bend angle [degrees]")
        tip.set(title="Fingertip error", xlabel="bend angle [degrees]")
        pose.legend(title="sensors a side", frameon=False)
    return figure


def _errors_against_bend(axes: Axes, rows: Sequence[PoseRow], error: str) -> None:
    """One line a number of sections; steps of equal pressure, on the way up and down, are averaged."""
    for sections in sorted({row.sections for row in rows}):
        of_step: dict[float, list[PoseRow]] = {}
        for row in rows:
            if row.sections == sections:
                of_step.setdefault(row.pressure_kpa, []).append(row)
        bends = [mean(row.bend_angle_deg for row in step) for _, step in sorted(of_step.items())]
        errors = [mean(getattr(row, error) for row in step) for _, step in sorted(of_step.items())]
        axes.plot(
            bends, errors, marker=MARKERS[sections], ms=4, lw=1.3, color=COLORS[sections], label=str(sections)
        )
    axes.axvline(0, color="0.8", lw=0.8, zorder=0)
    axes.grid(alpha=0.25)
    axes.set_ylim(bottom=0)


def save_figure(figure: Figure, stem: Path) -> None:
    """Writes a figure as PNG and SVG, the same bytes for the same figure."""
    for suffix, metadata in ((".png", None), (".svg", {"Date": None})):
        with whole_file(stem.with_suffix(suffix)) as partial, mpl.rc_context(STYLE):
            figure.savefig(partial, dpi=200, metadata=metadata)
