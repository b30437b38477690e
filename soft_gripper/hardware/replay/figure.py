"""Replays as a figure: the tip over time, its error, and the arm at its largest bend."""

from collections.abc import Sequence

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from soft_gripper.hardware.replay.recordings import Replayed, Rows
from soft_gripper.pictures.style import ESTIMATOR_COLORS, STYLE

_PREFERRED = ("arcs", "gaussian")
_MEASURED = "0.1"
_SMOOTHED = 50  # samples, over which errors are averaged
_MOST = 4  # estimators in a figure, so that each can be seen


def drawn_rows(rows: Rows) -> dict[str, str]:
    """Which rows are drawn, and in which colours."""
    drawn = [row for row, (name, _) in rows.items() if name in _PREFERRED] or list(rows)
    return dict(zip(drawn[:_MOST], ESTIMATOR_COLORS[1:], strict=False))


def replay_figure(replayed: Sequence[Replayed], rows: Rows) -> Figure:
    """A column for every recording: tip across the arm, error of the tip, shape."""
    colors = drawn_rows(rows)
    with mpl.rc_context(STYLE):
        figure = Figure(figsize=(1.2 + 2.5 * len(replayed), 8.2), layout="constrained")
        heights = {"height_ratios": [1, 0.8, 1.9]}
        panels = figure.subplots(3, len(replayed), sharex="row", sharey="row", squeeze=False, gridspec_kw=heights)
        for column, one in zip(panels.T, replayed, strict=True):
            column[0].set_title(one.name.replace("_", " "), fontsize=10, loc="left")
            _draw_tip(column[0], one, colors)
            _draw_errors(column[1], one, colors)
            _draw_shape(column[2], one, colors)
        panels[0, 0].set_ylabel("tip, across the arm [mm]")
        panels[1, 0].set_ylabel("error of the tip,\n1 s means [mm]")
        panels[2, 0].set_ylabel("down [mm]")
        handles, labels = panels[0, 0].get_legend_handles_labels()
        figure.legend(handles, labels, loc="outside upper center", ncols=len(labels), frameon=False)
    return figure


def _draw_tip(axes: Axes, one: Replayed, colors: dict[str, str]) -> None:
    tip = 1e3 * one.signals["measured_bodies"][1:, -1, 0]
    for row, color in colors.items():
        estimated = 1e3 * one.signals[f"{row}.body_positions"][1:, -1, 0]
        axes.plot(tip["time"], estimated, color=color, lw=1.0, label=_label(row))
    axes.plot(tip["time"], tip, color=_MEASURED, lw=1.4, ls=(0, (4, 2)), label="motion capture")


def _draw_errors(axes: Axes, one: Replayed, colors: dict[str, str]) -> None:
    for row, color in colors.items():
        error = 1e3 * one.signals[f"{row}.body_error"][1:, -1]
        axes.plot(error["time"], error.rolling(time=_SMOOTHED, center=True, min_periods=1).mean(), color=color, lw=1.2)
    axes.set(yscale="log", ylim=(1, 100), xlabel="time [s]")
    axes.set_yticks([1, 2, 5, 10, 20, 50, 100], ["1", "2", "5", "10", "20", "50", "100"])
    axes.minorticks_off()


def _draw_shape(axes: Axes, one: Replayed, colors: dict[str, str]) -> None:
    """At the sample where the bodies are furthest apart across the arm."""
    bodies = one.signals["measured_bodies"].values[1:]
    place = 1 + int(np.argmax(np.abs(np.diff(bodies[:, :, 0], axis=1, prepend=0.0)).sum(axis=1)))
    for row, color in colors.items():
        joints = one.signals[f"{row}.joint_positions"].values[place]
        ends = one.signals[f"{row}.body_positions"].values[place]
        line = 1e3 * np.concatenate([[[0.0, 0.0]], joints, ends[-1:]])
        axes.plot(*line.T, color=color, lw=1.6, marker="o", ms=2)
    axes.plot(*(1e3 * bodies[place - 1].T), color=_MEASURED, ls="", marker="s", mfc="none", ms=8, mew=1.5)
    time = float(one.signals.data["time"][place])
    axes.set_title(f"at {time:.1f} s; squares: motion capture", fontsize=8, loc="left")
    axes.set(aspect="equal", xlabel="across [mm]")
    axes.margins(0.15)
    if not axes.yaxis_inverted():
        axes.invert_yaxis()


def _label(row: str) -> str:
    name, count = row.split()
    return f"{name}, {count} per side"
