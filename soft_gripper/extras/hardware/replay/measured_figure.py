"""Figure of estimates beside what an instrument measured."""

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from soft_gripper.extras.hardware.measured import SI
from soft_gripper.extras.hardware.replay.measured_scores import MeasuredReplay
from soft_gripper.pictures.style import ESTIMATOR_COLORS, STYLE

_MOST_RUNS = 4  # drawn over time
_MEASURED = "0.1"
_IMPACTS = 1.0  # percent of the samples that may be beyond what is drawn


def measured_figure(replay: MeasuredReplay) -> Figure:
    """Plots the first instrument and its estimates over time, with their bands, a panel for each run."""
    kind = next(iter(replay.instruments))
    names = list(replay.runs[0].compared[kind])
    colors = dict(zip(names, ESTIMATOR_COLORS[1:], strict=False))
    runs = range(min(len(replay.runs), _MOST_RUNS))
    with mpl.rc_context(STYLE):
        figure = Figure(figsize=(1.2 + 2.6 * len(runs), 3.2), layout="constrained")
        panels = figure.subplots(1, len(runs), squeeze=False, sharey=True)[0]
        for number in runs:
            _draw_run(panels[number], replay, kind, number, colors)
        panels[0].set_ylabel(f"{kind} [{SI[kind]}]")
        handles, labels = panels[0].get_legend_handles_labels()
        figure.legend(handles, labels, loc="outside upper center", ncols=len(labels), frameon=False)
    return figure


def _draw_run(axes: Axes, replay: MeasuredReplay, kind: str, number: int, colors: dict[str, str]) -> None:
    run = replay.runs[number]
    for name, color in colors.items():
        each = run.compared[kind][name][-1]  # the contact force, if it is estimated
        with np.errstate(divide="ignore", invalid="ignore"):
            low, high, middle = (part / each.scale for part in (each.least, each.most, each.estimate))
        axes.fill_between(run.time, low, high, color=color, alpha=0.2, lw=0)
        axes.plot(run.time, middle, color=color, lw=1.0, label=f"{name}: {each.quantity}")
    axes.plot(run.time, replay.corrected[kind][number], color=_MEASURED, lw=1.2, ls=(0, (4, 2)), label="measured")
    every = np.concatenate(replay.corrected[kind])
    least, most = np.nanpercentile(every, [_IMPACTS, 100 - _IMPACTS])
    axes.set(ylim=(least - 0.3 * (most - least), most + 0.5 * (most - least)), xlabel="time [s]")
    axes.set_title(run.log.name, fontsize=9, loc="left")
