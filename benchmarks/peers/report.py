"""The table and the figure of a comparison."""

from pathlib import Path

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from peers.comparison import Result, chosen
from peers.simulators import OURS
from soft_gripper.evaluation.figure_style import STYLE, estimator_style, save_figure

_COLUMNS = "task | simulator | setting | times real time | tip error [mm] | creep [mm/s] | takes, of ours | as good"


def print_table(results: dict[str, list[Result]]) -> None:
    """The chosen settings of all tasks, as a Markdown table."""
    print(f"| {_COLUMNS} |\n|---|---|---|---:|---:|---:|---:|---|")
    for task, of_task in results.items():
        ours = of_task[0]
        for result in chosen(of_task):
            print(f"| {task} | {result.simulator} | {_words(result)} | {_figures(result, ours)} |")


def _words(result: Result) -> str:
    """A setting in a few words."""
    parts = (f"{key} {value}" for key, value in _flat(result.setting).items())
    return ", ".join(parts)


def _flat(setting: dict[str, object]) -> dict[str, object]:
    """Fields, those of a nested mapping among them; steps in ms."""
    flat: dict[str, object] = {}
    for key, value in setting.items():
        if isinstance(value, dict):
            flat |= value
        elif key in ("step", "time_step"):
            flat["step"] = f"{1e3 * value:g} ms"
        else:
            flat[key] = value
    return flat


def _figures(result: Result, ours: Result) -> str:
    creep = "" if np.isnan(result.creep) else f"{1e3 * result.creep:.4f}"
    good = "yes" if result.matches(ours) else "no" if result.holds else "does not hold"
    behind = result.times_behind(ours)
    return f"{result.speed:.3g} | {1e3 * result.error:.3f} | {creep} | {behind:.2g} | {good}"


def draw(results: dict[str, list[Result]], stem: Path) -> None:
    """A panel a task: what has to be equal against the speed, a line a simulator, a point a setting that holds."""
    with mpl.rc_context(STYLE):
        figure = Figure(figsize=(10, 6), layout="constrained")
        panels = figure.subplots(2, -(-len(results) // 2)).ravel()
        simulators = list(dict.fromkeys(r.simulator for of_task in results.values() for r in of_task))
        for panel, (task, of_task) in zip(panels, results.items(), strict=False):
            _draw_panel(panel, task, of_task, simulators)
        for panel in panels[len(results) :]:
            panel.axis("off")
        panels[0].legend(frameon=False)
        save_figure(figure, stem)


def _draw_panel(axes: Axes, task: str, results: list[Result], simulators: list[str]) -> None:
    for place, simulator in enumerate(simulators):
        own = sorted((r for r in results if r.simulator == simulator and r.holds), key=lambda r: r.speed)
        if own:
            style = estimator_style(place, simulator)
            axes.plot(
                [r.speed for r in own],
                [1e3 * r.quality for r in own],
                **style | {"ls": "-" if simulator == OURS else ":"},
            )
    held = not np.isnan(results[0].creep)
    axes.axhline(1e3 * results[0].quality, color="0.6", lw=0.8, zorder=0)
    axes.set(title=task, xscale="log", yscale="log", xlabel="times faster than real time")
    axes.set_ylabel("creep [mm/s]" if held else "error of the tips [mm]")
