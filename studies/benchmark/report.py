"""Writes and reads results of the benchmark: scores -> a document that can be compared, and a figure."""

from collections.abc import Mapping, Sequence
from dataclasses import asdict
from importlib.metadata import version
from pathlib import Path
from typing import Any

import matplotlib.pyplot as plt
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.ticker import FormatStrFormatter, LogLocator, NullFormatter

from soft_gripper.errors import InputError
from soft_gripper.files.document import check_config
from soft_gripper.files.json_text import read_json
from soft_gripper.pictures.style import ESTIMATOR_COLORS, STYLE, estimator_style
from studies.benchmark.benchmark_task import VERSION, BenchmarkTask
from studies.benchmark.published import comparable_numbers
from studies.benchmark.scores import Score
from studies.benchmark.tasks import TASKS

SHOWN_UNITS = {"m": (1e3, "mm")}  # factor and unit in figures and tables


def document(scores: Sequence[Score], tasks: Sequence[BenchmarkTask]) -> dict[str, Any]:
    """Contents of a results file: versions, checksums of tasks, scores, and published numbers."""
    scored_tasks = {score.task for score in scores}
    return {
        "benchmark": VERSION,
        "soft_gripper": version("soft-gripper"),
        "sha256": {task.name: dict(task.sha256) for task in tasks if task.name in scored_tasks},
        "scores": [asdict(score) for score in scores],
        "published": [asdict(n) | {"tasks": n.tasks.split()} for n in comparable_numbers(scored_tasks)],
    }


def load_scores(file: Path) -> list[Score]:
    """Reads the scores of a results file.

    Raises:
        InputError: if it is not a results file, or scores other data.
    """
    content = read_json(file)
    try:
        found_version, rows, checksums = (content.get("benchmark"), list(content["scores"]), dict(content["sha256"]))
    except (ValueError, KeyError, TypeError, AttributeError):
        raise InputError(file, "file", file.name, "was not written by python -m studies benchmark") from None
    if found_version != VERSION:
        raise InputError(file, "benchmark", found_version, f"must be {VERSION}: score again with this version")
    for task in TASKS:
        sums = checksums.get(task.name, task.sha256)
        if not isinstance(sums, dict) or any(sums.get(name) != value for name, value in task.sha256.items()):
            raise InputError(file, "sha256", task.name, "was scored on other data, and cannot be compared")
    return [_score(file, row) for row in rows]


def _score(file: Path, row: Any) -> Score:
    try:
        score = Score(**row)
    except TypeError:
        raise InputError(file, "scores", row, "must have the fields of a score, and no others") from None
    check_config(f"{file}: scores", score)
    return score


def region_scores(scores: Sequence[Score]) -> Mapping[tuple[str, str], Mapping[str, Score]]:
    """Scores by task and region, and by estimator, in their order."""
    grouped: dict[tuple[str, str], dict[str, Score]] = {}
    for score in scores:
        grouped.setdefault((score.task, score.region), {})[score.estimator] = score
    return grouped


def figure(scores: Sequence[Score]) -> Figure:
    """Plots the mean error of every estimator in every region, a panel for each task."""
    names, tasks = list(dict.fromkeys(s.estimator for s in scores)), list(dict.fromkeys(s.task for s in scores))
    styles = {name: _marker_style(place, name) for place, name in enumerate(names)}
    columns = min(3, len(tasks))
    rows = -(-len(tasks) // columns)
    with plt.rc_context(STYLE):
        figure_, panels = plt.subplots(
            rows, columns, figsize=(3.6 * columns, 2.5 * rows + 0.6), squeeze=False, constrained_layout=True
        )
        for panel, task in zip(panels.flat, tasks, strict=False):
            _draw(panel, [score for score in scores if score.task == task], styles)
        for panel in panels.flat[len(tasks) :]:
            panel.set_axis_off()
        handles = [Line2D([], [], **look) for look in styles.values()]
        figure_.legend(handles, names, loc="outside upper center", ncols=min(len(names), 5), frameon=False)
    plt.close(figure_)
    return figure_


def _marker_style(place: int, name: str) -> dict[str, Any]:
    """Marker of an estimator; it is hollow where the colours repeat."""
    hollow = {"mfc": "none", "mew": 1.5} if place >= len(ESTIMATOR_COLORS) else {}
    return estimator_style(place, name) | {"ls": "", "ms": 6} | hollow


def _draw(panel: Axes, scores: Sequence[Score], styles: Mapping[str, dict[str, Any]]) -> None:
    """Draws errors on a logarithmic scale, or the percentage of wrong answers."""
    regions, names = (list(dict.fromkeys(getattr(s, field) for s in scores)) for field in ("region", "estimator"))
    factor, unit = SHOWN_UNITS.get(scores[0].unit, (1.0, scores[0].unit))
    spacing = 0.7 / len(names)
    for i, name in enumerate(names):
        estimator_scores = [score for score in scores if score.estimator == name]
        positions = [regions.index(score.region) + (i - (len(names) - 1) / 2) * spacing for score in estimator_scores]
        panel.plot(positions, [factor * score.mean for score in estimator_scores], **styles[name])
    is_share = unit == "%"
    panel.set(title=scores[0].task, ylabel="wrong [%]" if is_share else f"mean error [{unit}]")
    panel.set(xlim=(-0.5, len(regions) - 0.5), yscale="linear" if is_share else "log")
    panel.set_xticks(range(len(regions)), regions)
    panel.grid(axis="x", visible=False)
    for border in range(1, len(regions)):
        panel.axvline(border - 0.5, color="0.8", lw=0.8)
    if is_share:
        panel.set_ylim(-5, 105)
        panel.tick_params(axis="x", labelsize=7)
    else:
        panel.yaxis.set_major_locator(LogLocator(subs=(1, 2, 5)))
        panel.yaxis.set_major_formatter(FormatStrFormatter("%g"))
        panel.yaxis.set_minor_formatter(NullFormatter())
