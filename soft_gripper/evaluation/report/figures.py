"""Figures of the report: the estimators with one to four sensors per side, and where we differ from the paper."""

from collections.abc import Sequence

import matplotlib as mpl
import numpy as np
from matplotlib.figure import Figure

from soft_gripper.arrays import Array
from soft_gripper.evaluation.paper.differences import TipErrors
from soft_gripper.pictures.style import STYLE, estimator_style, section_style
from soft_gripper.runs.scores.poses import PoseRow, mean_errors, of_estimator

PAPER = 2.0  # mm, the paper's mean pose error in contact with four sensors
LEAST, MOST = 1e-3, 10.0  # mm; errors below are drawn at LEAST


def estimators_figure(rows: Sequence[PoseRow], scenarios: Sequence[str]) -> Figure:
    """Mean pose error against the number of sensors: a line an estimator, a panel a scenario, of up to five."""
    estimators, counts = list(dict.fromkeys(row.estimator for row in rows)), sorted({row.sections for row in rows})
    with mpl.rc_context(STYLE):
        figure = Figure(figsize=(8, 5.2), layout="constrained")
        panels = figure.subplots(2, 3, sharex=True, sharey=True).flat
        for axes, scenario in zip(panels, scenarios, strict=False):
            for place, name in enumerate(estimators):
                errors = np.maximum(mean_errors(of_estimator(rows, name), scenario, "pose_error_mm"), LEAST)
                axes.plot(counts, errors, clip_on=False, zorder=3, **estimator_style(place, name))
            axes.axhline(PAPER, color="0.45", lw=1, ls=(0, (4, 3)))
            axes.set(title=scenario.replace("_", " ").capitalize(), yscale="log", ylim=(LEAST, MOST), xticks=counts)
            axes.tick_params(labelbottom=True)
        axes = figure.axes[0]
        axes.yaxis.set_major_formatter("{x:g}")
        axes.text(counts[-1], 1.15 * PAPER, "paper, four sensors", ha="right", fontsize=8, color="0.35")
        _legend(figure, len(scenarios))
    return figure


def _legend(figure: Figure, used: int) -> None:
    """What the lines are, in the panel that is left, and the labels of the axes."""
    for axes in figure.axes[used:]:
        axes.set_axis_off()
    handles, labels = figure.axes[0].get_legend_handles_labels()
    figure.axes[-1].legend(handles, labels, title="estimator", loc="center", frameon=False, fontsize=10)
    for axes in figure.axes[::3]:
        axes.set_ylabel("mean pose error [mm]")
    for axes in figure.axes[used - 3 : used]:
        axes.set_xlabel("sensors per side")


TITLES = {
    "middles": "joints in the middles\nof the segments (here)",
    "starts": "joints where\nthe segments begin",
    "noisy": "joints in the middles,\nreadings with 0.1 % noise",
}


def difference_figure(bend: Array, errors: TipErrors) -> Figure:
    """Fingertip error in free bending against the bend angle, on one scale, for three chains, 1 to 4 sensors.

    `bend` are the bend angles of the steps of `errors`, rad; of steps with equal bend the first is drawn.
    """
    degrees, first = np.unique(np.degrees(bend).round(1), return_index=True)
    with mpl.rc_context(STYLE):
        figure = Figure(figsize=(8, 3.2), layout="constrained")
        panels = figure.subplots(1, 3, sharex=True, sharey=True)
        for axes, (name, title) in zip(panels, TITLES.items(), strict=True):
            for sections, error in zip(errors.sections, 1e3 * getattr(errors, name)[:, first], strict=True):
                axes.plot(degrees, error, **section_style(sections))
            axes.set(title=title, xlabel="bend angle [degrees]")
        panels[0].set(ylabel="fingertip error [mm]", ylim=(0, None))
        panels[0].legend(title="sensors per side", frameon=False)
    return figure
