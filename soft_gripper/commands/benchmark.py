"""soft-gripper benchmark: scores estimators on recorded hardware with fixed splits."""

import argparse
import json
import os
from importlib.metadata import version
from pathlib import Path
from typing import Any

from soft_gripper.benchmark.baselines import BASELINES, Estimator
from soft_gripper.benchmark.scores import Score, score_task
from soft_gripper.benchmark.tasks import TASKS, Task, missing_files, read_task
from soft_gripper.errors import InputError
from soft_gripper.files.output import atomic_file
from soft_gripper.hardware.recordings import DATA_FOLDER
from soft_gripper.scenario.own_functions import find_function

SCHEMA = 1


def run(options: argparse.Namespace) -> int:
    """Runs the command."""
    folder = options.data or Path(os.environ.get(DATA_FOLDER) or "not given")
    if not folder.is_dir():
        raise InputError("benchmark", "--data", str(folder), f"give a folder of recordings, or set ${DATA_FOLDER}")
    estimators = dict(BASELINES)
    if options.estimator is not None:
        estimators[options.estimator] = find_function("--estimator", options.estimator)
    scores: list[Score] = []
    for task in TASKS:
        scores += _scored(task, folder, estimators)
    if not scores:
        raise InputError("benchmark", "--data", str(folder), "has the files of no task")
    print_scores(scores)
    options.console.table("scores", scores)
    with atomic_file(options.out) as partial:
        partial.write_text(json.dumps(document(scores), indent=2) + "\n")
    options.console.wrote(options.out)
    return 0


def _scored(task: Task, folder: Path, estimators: dict[str, Estimator]) -> list[Score]:
    if missing := missing_files(task, folder):
        print(f"{task.name}: skipped, {folder} has no {', '.join(missing)}; they are at {task.source}")
        return []
    train, tested = read_task(task, folder)
    return [score for name, found in estimators.items() for score in score_task(task, name, found, train, tested)]


def print_scores(scores: list[Score]) -> None:
    """Prints a line for every row."""
    print(f"{'task':12} {'region':10} {'estimator':20} {'mean':>9} {'median':>9} {'95 %':>9}      in band")
    for score in scores:
        band = "no band" if score.within_band_percent is None else f"{score.within_band_percent:.1f} %"
        errors = " ".join(f"{value:9.4g}" for value in (score.mean, score.median, score.percentile_95))
        print(f"{score.task:12} {score.region:10} {score.estimator:20} {errors} {score.unit:3} {band:>8}")


def document(scores: list[Score]) -> dict[str, Any]:
    """What the JSON file holds: versions, checksums and scores."""
    scored = {score.task for score in scores}
    return {
        "schema": SCHEMA,
        "soft_gripper": version("soft-gripper"),
        "sha256": {task.name: task.sha256 for task in TASKS if task.name in scored},
        "scores": [vars(score) for score in scores],
    }
