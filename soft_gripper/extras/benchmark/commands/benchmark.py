"""soft-gripper benchmark: scores estimators on simulated contacts and grasps and on recorded hardware."""

import argparse
import json
import os
import sys
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from tempfile import TemporaryDirectory

from tqdm import tqdm

from soft_gripper.errors import InputError
from soft_gripper.extras.benchmark.baselines import Estimator, baselines
from soft_gripper.extras.benchmark.benchmark_task import Task, missing_files, read_task
from soft_gripper.extras.benchmark.ours import OURS
from soft_gripper.extras.benchmark.published import published_beside
from soft_gripper.extras.benchmark.report import by_region, document, figure, load_scores
from soft_gripper.extras.benchmark.scores import Score, score_task
from soft_gripper.extras.benchmark.tasks import TASKS
from soft_gripper.extras.hardware.recordings import DATA_FOLDER
from soft_gripper.files.output import atomic_file, check_file
from soft_gripper.pictures.style import save_figure
from soft_gripper.registry import OWN


def run(options: argparse.Namespace) -> int:
    """Runs the command."""
    if options.compare:
        compare(options.compare)
        return 0
    given = options.data or (Path(named) if (named := os.environ.get(DATA_FOLDER)) else None)
    if given is not None and not given.is_dir():
        raise InputError("benchmark", "--data", str(given), "give a folder of recordings")
    check_file(options.out)
    chosen = [] if options.estimator is None else [options.estimator]
    own = {name: OWN.find(name, "--estimator", "benchmark") for name in chosen}
    folders = {task: folder for task in TASKS if (folder := _folder(task, given)) is not None}
    with TemporaryDirectory() as copies:
        scores = _scores(folders, own, Path(copies))
    print_scores(scores)
    options.console.table("scores", scores)
    with atomic_file(options.out) as partial:
        partial.write_text(json.dumps(document(scores), indent=2) + "\n")
    save_figure(figure(scores), options.out.with_suffix(""))
    options.console.wrote(options.out, *(options.out.with_suffix(suffix) for suffix in (".png", ".svg")))
    return 0


def _folder(task: Task, given: Path | None) -> Path | None:
    """The folder of a task's files; None, and a word where they are, if they are missing."""
    folder = task.folder or given
    if folder is None:
        print(f"{task.name}: skipped; download {task.source}, and give the folder with --data", file=sys.stderr)
    elif missing := missing_files(task, folder):
        where = f"skipped, {folder} has no {', '.join(missing)}; they are at {task.source}"
        print(f"{task.name}: {where}", file=sys.stderr)
        return None
    return folder


def _scores(folders: Mapping[Task, Path], own: Mapping[str, Estimator], copies: Path) -> list[Score]:
    """Scores of all estimators, by task; a user's own are run first, so that their mistakes are reported at once."""
    recorded = {task: read_task(task, folder, copies) for task, folder in folders.items()}
    runs = [(task, name, found) for task in recorded for name, found in own.items()]
    runs += [(task, *each) for task in recorded for each in (baselines(task) | OURS[task.name]).items()]
    scores: dict[str, list[Score]] = {task.name: [] for task in recorded}
    with tqdm(runs, desc="benchmark", unit="estimator", disable=None) as bar:
        for task, name, estimator in bar:
            bar.set_postfix_str(f"{task.name}: {name}")
            scores[task.name] += score_task(task, name, estimator, *recorded[task])
    return [score for of_task in scores.values() for score in sorted(of_task, key=lambda score: score.estimator in own)]


def print_scores(scores: list[Score]) -> None:
    """Prints a line for every score, and then what others have published."""
    widths = [max(len(getattr(s, of)) for s in scores) for of in ("task", "region", "estimator")]
    titles = [f"{title:{width}}" for title, width in zip(("task", "region", "estimator"), widths, strict=True)]
    print(*titles, *(f"{title:>9}" for title in ("mean", "median", "95 %")), "  ", " in band     band")
    for score in scores:
        errors = " ".join(f"{_number(value):>9}" for value in (score.mean, score.median, score.percentile_95))
        names = (score.task, score.region, score.estimator)
        print(
            *(f"{name:{width}}" for name, width in zip(names, widths, strict=True)),
            errors,
            f"{score.unit:2}",
            _band(score),
        )
    print("\npublished, of other bodies and sensors:")
    for each in published_beside({score.task for score in scores}):
        print(f"  {each.value}: {each.what} ({each.source}); see {', '.join(each.tasks)}")


def _number(value: float | None) -> str:
    return "" if value is None else f"{value:.4g}"


def _band(score: Score) -> str:
    if score.within_band_percent is None:
        return " no band"
    unknown = "" if score.unknown_percent is None else f"   {score.unknown_percent:.1f} % unknown"
    return f"{score.within_band_percent:6.1f} % {_number(score.band):>8}{unknown}"


def compare(files: list[Path]) -> None:
    """Prints the mean errors of several results files beside each other; the least of a region has a star."""
    scores = [
        replace(score, estimator=f"{file.stem}: {score.estimator}") for file in files for score in load_scores(file)
    ]
    for (task, region), found in by_region(scores).items():
        least = min(score.mean for score in found.values())
        print(f"{task}, {region} [{next(iter(found.values())).unit}]")
        for name, score in found.items():
            print(f"  {'*' if score.mean == least else ' '} {name:40} {score.mean:9.4g}   {_band(score).lstrip()}")
