"""The figure of a design study: the Pareto front, sensitivities, and every variable against the first end."""

from collections.abc import Sequence
from itertools import groupby
from math import ceil, isnan, nan
from operator import attrgetter
from typing import Any

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from soft_gripper.arrays import Array
from soft_gripper.extras.design.run_design import DesignResult
from soft_gripper.extras.design.study_tables import SHARE_HELD, sensitivity_rows
from soft_gripper.extras.sweeps.axes import Range
from soft_gripper.extras.sweeps.cells import cell, numbers_in
from soft_gripper.extras.sweeps.figure import axis_positions
from soft_gripper.pictures.style import ESTIMATOR_COLORS, STYLE

ALLOWED, LOST, BEST, SHIPPED = "#2166ac", "#b9b9b9", "#b2182b", "#111111"
_PANEL_COLUMNS = 4  # panels of variables side by side
_SHORT_WORD = 5  # letters of a word that needs the word before it


def short_names(keys: Sequence[str]) -> list[str]:
    """The last words of dotted keys, or the keys themselves if these words are not unique."""
    names = []
    for key in keys:
        words = [word for word in key.split(".") if not word.isdecimal() and word != "all"]
        count = 1 if len(words[-1]) > _SHORT_WORD else 2
        names.append(" ".join(words[-count:]).replace("_", " "))
    return names if len(set(names)) == len(names) else list(keys)


def design_figure(result: DesignResult) -> Figure:
    """Plots the front and the sensitivities; below, the first end over each variable.

    Designs that lose an object or break a limit are grey; the best is a star, and the scenario as it is a square.
    """
    keys = [axis.key for axis in result.study.axes]
    lines, columns = ceil(len(keys) / _PANEL_COLUMNS), min(len(keys), _PANEL_COLUMNS)
    no_ends = [nan] * len(result.study.config.ends)
    ends = np.array([design.ends or no_ends for design in result.designs], float)
    with mpl.rc_context({**STYLE, "axes.formatter.limits": (-2, 3)}):
        figure = Figure(figsize=(10.0, 3.0 * (1.15 + lines)), layout="constrained")
        rows: Any = figure.subfigures(2, 1, height_ratios=[1.25, lines])
        front_axes, sensitivity_axes = rows[0].subplots(1, 2, width_ratios=[1.15, 1])
        _draw_front(front_axes, result, ends)
        _draw_sensitivities(sensitivity_axes, result)
        panels = rows[1].subplots(lines, columns, squeeze=False, sharey=True).ravel()
        simulated = [design for design in result.designs[1:] if design.ends]
        indices = [design.number for design in simulated]
        for number, (axes, axis, name) in enumerate(zip(panels, result.study.axes, short_names(keys), strict=False)):
            x = np.full(len(ends), np.nan)
            cells = [cell(design.values[axis.key]).rpartition("/")[2] for design in simulated]
            x[indices] = numbers_in(cells) if isinstance(axis, Range) else axis_positions(axes, "x", cells)
            _draw_designs(axes, result, x, ends[:, 0], indices)
            axes.set(xlabel=name, ylabel="" if number % columns else result.study.config.ends[0].measure)
        for axes in panels[len(keys) :]:
            axes.set_visible(False)
        handles, labels = front_axes.get_legend_handles_labels()
        figure.legend(handles, labels, loc="outside upper center", ncols=len(labels), frameon=False)
    return figure


def _draw_designs(axes: Axes, result: DesignResult, x: Array, y: Array, indices: Sequence[int]) -> None:
    """Plots some designs as dots, and the best as a star."""
    allowed_indices = [i for i in indices if result.designs[i].is_allowed]
    unallowed = [i for i in indices if i not in allowed_indices]
    axes.plot(x[unallowed], y[unallowed], "o", ms=4, color=LOST, label="object lost, or beyond a limit")
    axes.plot(x[allowed_indices], y[allowed_indices], "o", ms=5, color=ALLOWED, label="allowed")
    if result.best is not None:
        number = result.best.number
        label = f"best: design {number}"
        axes.plot(x[number], y[number], "*", ms=14, color=BEST, mec="white", zorder=3, label=label)


def _draw_front(axes: Axes, result: DesignResult, ends: Array) -> None:
    """Plots the first two ends against each other, or a single one over the number of the design."""
    names = [end.measure for end in result.study.config.ends]
    is_front = len(names) > 1
    x, y = (ends[:, 0], ends[:, 1]) if is_front else (np.arange(float(len(ends))), ends[:, 0])
    _draw_designs(axes, result, x, y, range(1, len(ends)))
    if is_front:
        front_indices = sorted(result.front, key=lambda i: float(x[i]))
        axes.plot(x[front_indices], y[front_indices], "-", lw=1.2, color=ALLOWED, label="Pareto front")
    axes.plot(x[:1], y[:1], "s", ms=7, mfc="none", mew=1.6, color=SHIPPED, label="as it is")
    axes.set(xlabel=names[0] if is_front else "design", ylabel=names[1 if is_front else 0])


def _draw_sensitivities(axes: Axes, result: DesignResult) -> None:
    """Plots the explained variance as a bar for each variable and end."""
    keys = [axis.key for axis in result.study.axes]
    rows_by_end = [list(rows) for _, rows in groupby(sensitivity_rows(result), attrgetter("end"))]
    thickness = 0.8 / max(len(rows_by_end), 1)
    for i, rows in enumerate(rows_by_end):  # in the order of the keys
        places = np.arange(len(keys)) + (i - (len(rows_by_end) - 1) / 2) * thickness
        fractions = [row.explained for row in rows]
        label = "share of runs held" if rows[0].end == SHARE_HELD else rows[0].end
        bars = axes.barh(places, fractions, 0.9 * thickness, color=ESTIMATOR_COLORS[i % 8], label=label)
        signs = ["" if isnan(row.slope_of_ranks) else "+" if row.slope_of_ranks > 0 else "−" for row in rows]
        axes.bar_label(bars, signs, padding=2, fontsize=8)
    axes.set(xlim=(0, 1), ylim=(-0.6, len(keys) - 0.4), xlabel="explained variance of ranks; + grows with it, − falls")
    axes.set_yticks(range(len(keys)), short_names(keys))
    axes.invert_yaxis()
    axes.grid(axis="y", visible=False)
    if rows_by_end:
        axes.legend(frameon=False, fontsize=8, loc="lower right")
    else:
        axes.text(0.5, 0.5, "too few designs to tell", transform=axes.transAxes, ha="center", color="0.4")
