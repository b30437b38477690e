"""The figure of a design study: the Pareto front, what matters, and every variable against the first end."""

import math
from collections.abc import Sequence
from typing import Any

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from soft_gripper.arrays import Array
from soft_gripper.extras.design.run_design import Design, Designed
from soft_gripper.extras.design.sensitivity import Sensitivity
from soft_gripper.extras.design.study_tables import SHARE_HELD, sensitivity_rows, short_names
from soft_gripper.pictures.style import ESTIMATOR_COLORS, STYLE
from soft_gripper.runs.sweep.run_sweep import Range

ALLOWED, LOST, BEST, SHIPPED = "#2166ac", "#b9b9b9", "#b2182b", "#111111"
_WIDTH, _ROW, _COLUMNS = 10.0, 3.0, 4  # inches, and panels of variables side by side


def design_figure(found: Designed) -> Figure:
    """Two rows and more: the front and what matters; below, the first end over each variable.

    Designs that lose an object or break a limit are grey; the best is a star, and the scenario as it is a square.
    """
    axes_count = len(found.study.axes)
    lines = math.ceil(axes_count / _COLUMNS)
    columns = min(axes_count, _COLUMNS)
    with mpl.rc_context(STYLE):
        figure = Figure(figsize=(_WIDTH, _ROW * (1.15 + lines)), layout="constrained")
        rows: Any = figure.subfigures(2, 1, height_ratios=[1.25, lines])
        left, right = rows[0].subplots(1, 2, width_ratios=[1.15, 1])
        _draw_front(left, found)
        _draw_sensitivities(right, found, sensitivity_rows(found))
        panels = rows[1].subplots(lines, columns, squeeze=False, sharey=True).ravel()
        names = short_names([axis.key for axis in found.study.axes])
        for number, (axes, axis, name) in enumerate(zip(panels, found.study.axes, names, strict=False)):
            _draw_variable(axes, found, axis.key, is_number=isinstance(axis, Range))
            axes.set_xlabel(name)
            if number % columns == 0:
                axes.set_ylabel(found.study.config.ends[0].measure)
        for axes in panels[axes_count:]:
            axes.set_visible(False)
        handles, labels = left.get_legend_handles_labels()
        figure.legend(handles, labels, loc="outside upper center", ncols=len(labels), frameon=False)
    return figure


def _values(designs: Sequence[Design], end: int) -> Array:
    """An end of designs; NaN where nothing holds."""
    return np.array([design.score.ends[end] if design.score.ends else np.nan for design in designs], float)


def _draw_front(axes: Axes, found: Designed) -> None:
    """The first two ends against each other or, if there is one, over the number of the design."""
    ends, tried = found.study.config.ends, found.designs[1:]
    is_front = len(ends) > 1
    y = 1 if is_front else 0

    def place(designs: Sequence[Design]) -> tuple[Array, Array]:
        x = _values(designs, 0) if is_front else np.array([design.number for design in designs], float)
        return x, _values(designs, y)

    lost = [design for design in tried if not design.score.is_allowed]
    axes.plot(*place(lost), "o", ms=4, color=LOST, label="object lost, or beyond a limit")
    axes.plot(*place([d for d in tried if d.score.is_allowed]), "o", ms=5, color=ALLOWED, label="allowed")
    if is_front:
        front = sorted((found.designs[i] for i in found.front), key=lambda design: design.score.ends[0])
        axes.plot(*place(front), "-", lw=1.2, color=ALLOWED, label="Pareto front")
    axes.plot(*place(found.designs[:1]), "s", ms=7, mfc="none", mew=1.6, color=SHIPPED, label="as it is")
    if found.best is not None:
        best = [found.designs[found.best]]
        axes.plot(*place(best), "*", ms=14, color=BEST, mec="white", label=f"best: design {best[0].number}")
    axes.set(xlabel=ends[0].measure if is_front else "design", ylabel=ends[y].measure)


def _draw_sensitivities(axes: Axes, found: Designed, rows: Sequence[Sensitivity]) -> None:
    """Bars of the explained variance, for each variable and end."""
    names = [end.measure for end in found.study.config.ends] + [SHARE_HELD]
    shown = [name for name in names if any(row.end == name for row in rows)]
    keys = [axis.key for axis in found.study.axes]
    thickness = 0.8 / max(len(shown), 1)
    for i, name in enumerate(shown):
        of_end = {row.variable: row for row in rows if row.end == name}
        places = np.arange(len(keys)) + (i - (len(shown) - 1) / 2) * thickness
        shares = [of_end[key].explained for key in keys]
        label = "share of runs held" if name == SHARE_HELD else name
        bars = axes.barh(places, shares, 0.9 * thickness, color=ESTIMATOR_COLORS[i % 8], label=label)
        signs = ["" if math.isnan(of_end[key].slope) else "+" if of_end[key].slope > 0 else "−" for key in keys]
        axes.bar_label(bars, signs, padding=2, fontsize=8)
    axes.set(xlim=(0, 1), ylim=(-0.6, len(keys) - 0.4), yticks=range(len(keys)))
    axes.set_xlabel("explained variance of ranks; + grows with it, − falls")
    axes.set_yticklabels(short_names(keys))
    axes.invert_yaxis()
    axes.grid(axis="y", visible=False)
    if shown:
        axes.legend(frameon=False, fontsize=8, loc="lower right")
    else:
        axes.text(0.5, 0.5, "too few designs to tell", transform=axes.transAxes, ha="center", color="0.4")


def _draw_variable(axes: Axes, found: Designed, key: str, is_number: bool) -> None:
    """The first end over a variable."""
    tried = [design for design in found.designs[1:] if design.score.ends]
    given = [design.values[key] for design in tried]
    is_number = is_number and not any(isinstance(value, str) for value in given)
    labels = [str(value).rpartition("/")[2] for value in given]
    choices = list(dict.fromkeys(labels))
    x = np.array(given, float) if is_number else np.array([choices.index(label) for label in labels], float)
    y = _values(tried, 0)
    allowed = np.array([design.score.is_allowed for design in tried], bool)
    axes.plot(x[~allowed], y[~allowed], "o", ms=4, color=LOST)
    axes.plot(x[allowed], y[allowed], "o", ms=5, color=ALLOWED)
    for i in (i for i, design in enumerate(tried) if found.best is not None and design is found.designs[found.best]):
        axes.plot(x[i], y[i], "*", ms=14, color=BEST, mec="white")
    if is_number:
        axes.ticklabel_format(axis="x", style="sci", scilimits=(-2, 3))
    else:
        axes.set_xticks(range(len(choices)), choices)
