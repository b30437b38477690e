"""Placements as a figure: the finger with its sections to scale, and the errors of all placements."""

from itertools import pairwise

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Polygon

from soft_gripper.fingers.finger import Finger
from soft_gripper.pictures.style import STYLE
from soft_gripper.placement.place_sensors import PlacedSensors
from soft_gripper.placement.placements import Placement

_SHADES = "#9ecae1", "#deebf7"
_MEAN, _EQUAL = "#b2182b", "0.35"


def placement_figure(placed: PlacedSensors) -> Figure:
    """Best, equal and worst sections along the finger, its base to the left; below, errors against the rank."""
    with mpl.rc_context(STYLE):
        figure = Figure(figsize=(7.5, 5.8), layout="constrained")
        *fingers, errors = figure.subplots(4, 1, gridspec_kw={"height_ratios": [1, 1, 1, 4.5]})
        drawn = {"best": 0, "equal": placed.equal, "worst": len(placed.placements) - 1}
        for axes, (name, i) in zip(fingers, drawn.items(), strict=True):
            error = 1e3 * placed.mean_pose_errors[i]
            axes.set_title(f"{name}: {error:.3f} mm, rank {i + 1}", loc="left", fontsize=9)
            _draw_finger(axes, placed.finger, placed.placements[i])
        fingers[-1].set_xlabel("from the base [mm]")
        _draw_errors(errors, placed)
    return figure


def _draw_finger(axes: Axes, finger: Finger, placement: Placement) -> None:
    """A side view, with a shade for every section and a line for every segment."""
    ends = np.array([0, *placement, finger.segments]) * 1e3 * finger.segment_length
    for i, (begin, end) in enumerate(pairwise(ends)):
        low, high = (_half_thickness(finger, s) for s in (begin, end))
        corners = [(begin, -low), (end, -high), (end, high), (begin, low)]
        axes.add_patch(Polygon(corners, fc=_SHADES[i % 2], ec="0.2", lw=1.2))
    for s in np.arange(1, finger.segments) * 1e3 * finger.segment_length:
        axes.plot([s, s], [-2, 2], color="0.5", lw=0.6)
    most = 1.05 * max(_half_thickness(finger, s) for s in (0.0, 1e3 * finger.length))
    axes.set(xlim=(-2, 1e3 * finger.length + 2), ylim=(-most, most), aspect="equal", yticks=[])
    axes.set_xticks(ends, [f"{end:.0f}" for end in ends], fontsize=7)
    axes.grid(visible=False)
    axes.spines["left"].set_visible(False)


def _half_thickness(finger: Finger, s: float) -> float:
    """At s mm from the base, mm."""
    return float(500 * finger.section(1e-3 * s).thickness)


def _draw_errors(axes: Axes, placed: PlacedSensors) -> None:
    ranks = np.arange(1, len(placed.placements) + 1)
    marker = "o" if len(ranks) < 30 else None
    for run, errors in zip(placed.runs, placed.pose_errors.T, strict=True):
        axes.plot(ranks, 1e3 * errors, lw=0.9, marker=marker, ms=2.5, label=run.replace("_", " "))
    axes.plot(ranks, 1e3 * placed.mean_pose_errors, color=_MEAN, lw=2.2, marker=marker, ms=4, label="mean")
    axes.axvline(placed.equal + 1, color=_EQUAL, ls="--", lw=1, label="equal sections")
    axes.set(xlabel="rank of the placement", ylabel="mean pose error [mm]", ylim=(0, None))
    axes.legend(fontsize=8, loc="center left", bbox_to_anchor=(1, 0.5), frameon=False)
