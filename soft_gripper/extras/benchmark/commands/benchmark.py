"""soft-gripper benchmark: scores estimators on simulated contacts and grasps and on recorded hardware."""

import argparse
import json
import os
import sys
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from tempfile import TemporaryDirectory

from tqdm import tqdm

from soft_gripper.errors import InputError
from soft_gripper.extras.benchmark.baselines import Estimator, baselines
from soft_gripper.extras.benchmark.benchmark_task import (
    Task,
    missing_files,
    read_tests,
    read_training,
    unread_files,
)
from soft_gripper.extras.benchmark.contacts import FOLDER as SHIPPED
from soft_gripper.extras.benchmark.measured_force import TRIALS, force_tasks
from soft_gripper.extras.benchmark.ours import ours
from soft_gripper.extras.benchmark.published import published_beside
from soft_gripper.extras.benchmark.report import by_region, document, figure, load_scores
from soft_gripper.extras.benchmark.scores import Answers, Score, Tested, answers, scores
from soft_gripper.extras.benchmark.submission import read_submission, write_submission
from soft_gripper.extras.benchmark.tasks import TASKS
from soft_gripper.extras.hardware.recordings import DATA_FOLDER
from soft_gripper.files.output import atomic_file, check_file
from soft_gripper.pictures.style import save_figure
from soft_gripper.registry import OWN

Tests = Mapping[Task, tuple[Path, Tested]]  # folder of the files of a task, and what is tested


def run(options: argparse.Namespace) -> int:
    """Runs the command."""
    if options.compare:
        compare(options.compare)
        return 0
    given = options.data or (Path(named) if (named := os.environ.get(DATA_FOLDER)) else None)
    if given is not None and not given.is_dir():
        raise InputError("benchmark", "--data", str(given), "give a folder of recordings")
    if options.submit and options.estimator is None:
        raise InputError("benchmark", "--submit", str(options.submit), "give --estimator too: whose estimates they are")
    for file in (options.out, options.submit):
        if file is not None:
            check_file(file)
    own = (
        {}
        if options.estimator is None
        else {options.estimator: OWN.find(options.estimator, "--estimator", "benchmark")}
    )
    tests = _tests(given)
    found = _submitted(tests, options.score) if options.score else _scores(tests, own, options.submit)
    written = [options.submit] if options.submit else []
    print_scores(found)
    options.console.table("scores", found)
    with atomic_file(options.out) as partial:
        partial.write_text(json.dumps(document(found, [*tests]), indent=2) + "\n")
    save_figure(figure(found), options.out.with_suffix(""))
    options.console.wrote(options.out, *(options.out.with_suffix(suffix) for suffix in (".png", ".svg")), *written)
    return 0


def _tests(given: Path | None) -> Tests:
    """The tasks whose files are there, and a word where those of the others are."""
    found = {}
    for task in (*TASKS, *(force_tasks(given) if given else ())):
        folder = task.folder or given
        if folder is None:
            print(f"{task.name}: skipped; download {task.source}, and give the folder with --data", file=sys.stderr)
        elif missing := missing_files(task, folder):
            where = f"skipped, {folder} has no {', '.join(missing)}; they are at {task.source}"
            print(f"{task.name}: {where}", file=sys.stderr)
        else:
            whole = task.with_kept_back(folder)
            found[whole] = folder, read_tests(whole, folder)
    for folder in {folder for task, (folder, _) in found.items() if task.folder != SHIPPED}:
        _name_unread([task for task, (own, _) in found.items() if own == folder], folder)
    return found


def _name_unread(tasks: Sequence[Task], folder: Path) -> None:
    unread = [Path(file) for file in unread_files(tasks, folder)]
    patterns = [Path(task.kept_back.file) for task in tasks if task.kept_back is not None]
    for parent in dict.fromkeys(file.parent for file in unread):
        names = ", ".join(file.name for file in unread if file.parent == parent)
        called = dict.fromkeys(pattern.name for pattern in patterns if pattern.parent == parent) or TRIALS
        print(f"{folder / parent}: not read: {names}; recordings are called {', '.join(called)}", file=sys.stderr)


def _scores(tests: Tests, own: Mapping[str, Estimator], submission: Path | None) -> list[Score]:
    """Scores of all estimators, by task; a user's own are run first, so that their mistakes are reported at once."""
    runs = [(task, name, found) for task in tests for name, found in own.items()]
    runs += [(task, *each) for task in tests for each in (baselines(task.question) | ours(task)).items()]
    found: dict[str, list[Score]] = {task.name: [] for task in tests}
    stated: dict[Task, Answers] = {}
    with TemporaryDirectory() as copies, tqdm(runs, desc="benchmark", unit="estimator", disable=None) as bar:
        train = {task: read_training(task, folder, Path(copies)) for task, (folder, _) in tests.items()}
        for task, name, estimator in bar:
            bar.set_postfix_str(f"{task.name}: {name}")
            of_task = answers(task, name, estimator, train[task], tests[task][1])
            found[task.name] += scores(task, name, of_task, tests[task][1])
            if name in own:
                stated[task] = of_task
    if submission is not None:
        (name,) = own
        write_submission(submission, name, stated)
    return [score for of_task in found.values() for score in sorted(of_task, key=lambda score: score.estimator in own)]


def _submitted(tests: Tests, files: list[Path]) -> list[Score]:
    """Scores of submissions, in the tasks whose files are there."""
    found = [score for file in files for score in _of_submission(file, tests)]
    if not found:
        raise InputError("benchmark", "--score", [str(file) for file in files], "has no task whose data are there")
    return found


def _of_submission(file: Path, tests: Tests) -> Iterator[Score]:
    submission = read_submission(file)
    for task, (_, tested) in tests.items():
        if task.name in submission.tasks:
            yield from scores(task, submission.estimator, submission.answers(task, tested), tested)


def print_scores(scores: list[Score]) -> None:
    """Prints a line for every score, and then what others have published."""
    widths = [max(len(getattr(s, of)) for s in scores) for of in ("task", "region", "estimator")]
    titles = [f"{title:{width}}" for title, width in zip(("task", "region", "estimator"), widths, strict=True)]
    print(*titles, *(f"{title:>9}" for title in ("mean", "median", "95 %", "proper")), "  ", " in band     band")
    for score in scores:
        numbers = score.mean, score.median, score.percentile_95, score.proper
        errors = " ".join(f"{_number(value):>9}" for value in numbers)
        names = (score.task, score.region, score.estimator)
        print(
            *(f"{name:{width}}" for name, width in zip(names, widths, strict=True)),
            errors,
            f"{score.unit:2}",
            _band(score),
        )
    quoted = published_beside({score.task for score in scores})
    if quoted:
        print("\npublished, of other bodies and sensors:")
    for each in quoted:
        print(f"  {each.value}: {each.what} ({each.source}); see {', '.join(each.tasks)}")


def _number(value: float | None) -> str:
    return "" if value is None else f"{value:.4g}"


def _band(score: Score) -> str:
    if score.within_band_percent is None:
        return " no band"
    unknown = "" if score.unknown_percent is None else f"   {score.unknown_percent:.1f} % unknown"
    return f"{score.within_band_percent:6.1f} % {_number(score.band):>8}{unknown}"


def compare(files: list[Path]) -> None:
    """Prints the scores of several results files beside each other; the least proper score of a region has a star."""
    found = [
        replace(score, estimator=f"{file.stem}: {score.estimator}") for file in files for score in load_scores(file)
    ]
    for (task, region), of in by_region(found).items():
        least = min(score.proper for score in of.values())
        print(f"{task}, {region} [{next(iter(of.values())).unit}]; mean error, proper score")
        for name, score in of.items():
            star = "*" if score.proper == least else " "
            print(f"  {star} {name:40} {score.mean:9.4g} {score.proper:9.4g}   {_band(score).lstrip()}")
