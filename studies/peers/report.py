"""The table and the figure of a comparison."""

from collections.abc import Iterable
from pathlib import Path

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import LogLocator, NullFormatter

from soft_gripper.pictures.style import STYLE, estimator_style, save_figure
from studies.peers.comparison import Result, chosen_results, equal_setting
from studies.peers.simulators import OURS
from studies.peers.task import Setting

_WIDE_RATIO = (
    1e4  # ratio of the ends of an axis with a label at each decade alone: others may be less than a decade long
)
_TABLE_HEADING = (
    "| task | simulator | setting | times real time | tip error [mm] | creep [mm/s] | time ÷ ours | as good"
    " | time ÷ ours, if ours must be as good |",
    "|---|---|---|---:|---:|---:|---:|---|---:|",
)


def table(results: Iterable[list[Result]]) -> list[str]:
    """The chosen_results settings of all tasks, as lines of Markdown."""
    return [*_TABLE_HEADING, *(line for task_results in results for line in rows(task_results))]


def rows(results: list[Result]) -> list[str]:
    """The lines of a task: its chosen_results settings."""
    lines = []
    for result in chosen_results(results):
        name = f"**{OURS}**" if result.simulator == OURS else result.simulator
        words = ", ".join(f"{key} {value}" for key, value in _flatten(result.setting).items())
        lines.append(f"| {result.task} | {name} | {words} | {_cells(result, results)} |")
    return lines


def _flatten(setting: Setting) -> Setting:
    """Fields, those of a nested mapping among them; steps in ms."""
    flat_setting: Setting = {}
    for key, value in setting.items():
        if isinstance(value, dict):
            flat_setting |= value
        elif key in ("step", "time_step"):
            flat_setting["step"] = f"{1e3 * value:g} ms"
        else:
            flat_setting[key] = value
    return flat_setting


def _cells(result: Result, results: list[Result]) -> str:
    own_result, match = results[0], equal_setting(results, result)
    creep = "" if np.isnan(result.creep) else f"{1e3 * result.creep:.4f}"
    verdict = "yes" if result.matches(own_result) else "no" if result.holds else "does not hold"
    slowdown = "none of ours" if match is None else f"{result.times_behind(match):.2g}"
    times = f"{result.times_behind(own_result):.2g}"
    return f"{result.speed:.3g} | {1e3 * result.error:.3f} | {creep} | {times} | {verdict} | {slowdown}"


def draw(results: dict[str, list[Result]], stem: Path) -> None:
    """Draws a panel per task: the matched quantity against speed, a point per setting that holds."""
    with mpl.rc_context(STYLE):
        figure = Figure(figsize=(10, 6), layout="constrained")
        panels = figure.subplots(2, -(-len(results) // 2), squeeze=False).ravel()
        simulators = list(dict.fromkeys(r.simulator for task_results in results.values() for r in task_results))
        for panel, (task, task_results) in zip(panels, results.items(), strict=False):
            _draw_panel(panel, task, task_results, simulators)
        for panel in panels[len(results) :]:
            panel.axis("off")
        figure.legend(*panels[0].get_legend_handles_labels(), loc="outside lower center", ncols=5, frameon=False)
        save_figure(figure, stem)


def _draw_panel(axes: Axes, task: str, results: list[Result], simulators: list[str]) -> None:
    for place, simulator in enumerate(simulators):
        points = [result for result in results if result.simulator == simulator and result.holds]
        style = estimator_style(place, simulator) | {"lw": 1.5 if simulator == OURS else 0}
        axes.plot([result.speed for result in points], [1e3 * result.quality for result in points], **style)
    axes.axhline(1e3 * results[0].quality, color="0.6", lw=0.8, zorder=0)
    has_object = not np.isnan(results[0].creep)
    axes.set(title=task, xscale="log", yscale="log", xlabel="times faster than real time")
    axes.set_ylabel("creep [mm/s]" if has_object else "error of the tips [mm]")
    for axis in (axes.xaxis, axes.yaxis):
        low, high = axis.get_view_interval()
        axis.set_major_locator(LogLocator(subs=(1, 3) if high < _WIDE_RATIO * low else (1,)))
        axis.set_major_formatter("{x:g}")
        axis.set_minor_formatter(NullFormatter())
