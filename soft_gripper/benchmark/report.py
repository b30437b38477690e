"""Results of the benchmark: a document that can be compared, and a figure."""

import json
from collections.abc import Mapping, Sequence
from importlib.metadata import version
from itertools import cycle
from pathlib import Path
from typing import Any

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.figure import Figure
from matplotlib.patches import Rectangle

from soft_gripper.benchmark.scores import Score
from soft_gripper.benchmark.tasks import TASKS
from soft_gripper.errors import InputError
from soft_gripper.pictures.style import ESTIMATOR_COLORS, STYLE

SCHEMA = 1
_SHOWN = {"m": (1e3, "mm")}  # factor and unit in figures


def document(scores: Sequence[Score]) -> dict[str, Any]:
    """What a results file holds: versions, checksums and scores."""
    scored = {score.task for score in scores}
    return {
        "schema": SCHEMA,
        "soft_gripper": version("soft-gripper"),
        "sha256": {task.name: task.sha256 for task in TASKS if task.name in scored},
        "scores": [vars(score) for score in scores],
    }


def load_scores(file: Path) -> list[Score]:
    """The scores of a results file.

    Raises:
        InputError: if it is none, or of other data.
    """
    try:
        found = json.loads(file.read_text(encoding="utf-8"))
        scores = [Score(**row) for row in found["scores"]]
        schema, checksums = found["schema"], found["sha256"]
    except OSError as error:
        raise InputError(file, "file", file.name, f"cannot be read: {error.strerror}") from None
    except (ValueError, KeyError, TypeError):
        raise InputError(file, "file", file.name, "was not written by soft-gripper benchmark") from None
    if schema != SCHEMA:
        raise InputError(file, "schema", schema, f"must be {SCHEMA}")
    for task in TASKS:
        if checksums.get(task.name, task.sha256) != task.sha256:
            raise InputError(file, "sha256", task.name, "was scored on other data, and cannot be compared")
    return scores


def by_region(scores: Sequence[Score]) -> Mapping[tuple[str, str], Mapping[str, Score]]:
    """Scores by task and region, and by estimator, in their order."""
    found: dict[tuple[str, str], dict[str, Score]] = {}
    for score in scores:
        found.setdefault((score.task, score.region), {})[score.estimator] = score
    return found


def figure(scores: Sequence[Score]) -> Figure:
    """The mean error of every estimator in every region, a panel for each task."""
    names, tasks = list(dict.fromkeys(s.estimator for s in scores)), list(dict.fromkeys(s.task for s in scores))
    colors = dict(zip(names, cycle(ESTIMATOR_COLORS), strict=False))
    columns = min(3, len(tasks))
    rows = -(-len(tasks) // columns)
    with plt.rc_context(STYLE):
        made, panels = plt.subplots(
            rows, columns, figsize=(3.6 * columns, 2.6 * rows + 0.4), squeeze=False, constrained_layout=True
        )
        for panel, task in zip(panels.flat, tasks, strict=False):
            _draw(panel, task, [score for score in scores if score.task == task], colors)
        for panel in panels.flat[len(tasks) :]:
            panel.set_axis_off()
        handles = [Rectangle((0, 0), 1, 1, color=color) for color in colors.values()]
        made.legend(handles, names, loc="outside upper center", ncols=len(names), frameon=False)
    plt.close(made)
    return made


def _draw(panel: Any, task: str, scores: Sequence[Score], colors: Mapping[str, Any]) -> None:
    regions, names = (list(dict.fromkeys(getattr(s, of) for s in scores)) for of in ("region", "estimator"))
    factor, unit = _SHOWN.get(scores[0].unit, (1.0, scores[0].unit))
    width = 0.8 / len(names)
    for i, name in enumerate(names):
        means = {score.region: factor * score.mean for score in scores if score.estimator == name}
        places = np.arange(len(regions)) + (i - (len(names) - 1) / 2) * width
        panel.bar(places, [means.get(region, np.nan) for region in regions], 0.9 * width, color=colors[name])
    panel.set_axisbelow(True)
    panel.set(title=task, ylabel=f"mean error [{unit}]")
    panel.set_xticks(range(len(regions)), regions)
