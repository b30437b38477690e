"""soft-gripper benchmark: scores estimators on recorded hardware with fixed splits."""

import argparse
import json
import os
import sys
from dataclasses import replace
from pathlib import Path

from soft_gripper.benchmark.baselines import BASELINES, Estimator
from soft_gripper.benchmark.ours import OURS
from soft_gripper.benchmark.report import by_region, document, figure, load_scores
from soft_gripper.benchmark.scores import Score, score_task
from soft_gripper.benchmark.tasks import TASKS, Task, missing_files, read_task
from soft_gripper.errors import InputError
from soft_gripper.files.output import atomic_file
from soft_gripper.hardware.recordings import DATA_FOLDER
from soft_gripper.pictures.style import save_figure
from soft_gripper.scenario.own_functions import find_function


def run(options: argparse.Namespace) -> int:
    """Runs the command."""
    if options.compare:
        compare(options.compare)
        return 0
    given = options.data or (Path(named) if (named := os.environ.get(DATA_FOLDER)) else None)
    if given is not None and not given.is_dir():
        raise InputError("benchmark", "--data", str(given), "give a folder of recordings")
    own: dict[str, Estimator] = {}
    if options.estimator is not None:
        own[options.estimator] = find_function("--estimator", options.estimator)
    scores: list[Score] = []
    for task in TASKS:
        scores += _scored(task, task.folder or given, BASELINES | OURS.get(task.name, {}) | own)
    print_scores(scores)
    options.console.table("scores", scores)
    with atomic_file(options.out) as partial:
        partial.write_text(json.dumps(document(scores), indent=2) + "\n")
    save_figure(figure(scores), options.out.with_suffix(""))
    options.console.wrote(options.out, *(options.out.with_suffix(suffix) for suffix in (".png", ".svg")))
    return 0


def _scored(task: Task, folder: Path | None, estimators: dict[str, Estimator]) -> list[Score]:
    if folder is None:
        print(f"{task.name}: skipped; download {task.source}, and give the folder with --data", file=sys.stderr)
        return []
    if missing := missing_files(task, folder):
        where = f"skipped, {folder} has no {', '.join(missing)}; they are at {task.source}"
        print(f"{task.name}: {where}", file=sys.stderr)
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


def compare(files: list[Path]) -> None:
    """Prints the mean errors of several results files beside each other; the least of a region has a star."""
    scores = [
        replace(score, estimator=f"{file.stem}: {score.estimator}") for file in files for score in load_scores(file)
    ]
    for (task, region), found in by_region(scores).items():
        least = min(score.mean for score in found.values())
        print(f"{task}, {region} [{next(iter(found.values())).unit}]")
        for name, score in found.items():
            band = "no band" if score.within_band_percent is None else f"{score.within_band_percent:.1f} % in band"
            print(f"  {'*' if score.mean == least else ' '} {name:40} {score.mean:9.4g}   {band}")
