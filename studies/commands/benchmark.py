"""python -m studies benchmark: scores estimators on simulated contacts and grasps and on recorded hardware."""

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
from soft_gripper.extras.hardware.recordings import DATA_FOLDER
from soft_gripper.files.output import atomic_file, check_file
from soft_gripper.pictures.style import save_figure
from studies.benchmark.baselines import baselines
from studies.benchmark.benchmark_task import (
    Task,
    Tested,
    inputs_of,
    missing_files,
    read_tests,
    read_training,
    recorded_folders,
    unread_files,
)
from studies.benchmark.contacts import FOLDER as SHIPPED
from studies.benchmark.estimates import Answers, answers
from studies.benchmark.measured_force import TRIALS, force_tasks
from studies.benchmark.ours import ours
from studies.benchmark.published import published_beside
from studies.benchmark.report import by_region, document, figure, load_scores
from studies.benchmark.scores import Score, scores
from studies.benchmark.submission import read_submission, write_submission
from studies.benchmark.tasks import TASKS
from studies.benchmark.user_estimator import user_estimator

Tasks = Mapping[Task, Path]  # and the folders of their files


def run(options: argparse.Namespace) -> int:
    """Runs the command."""
    if options.compare:
        compare(options.compare)
        return 0
    given = options.data or (Path(named) if (named := os.environ.get(DATA_FOLDER)) else None)
    if given is not None and not given.is_dir():
        raise InputError("benchmark", "--data", str(given), "give a folder of recordings")
    if options.submit and options.estimator is None:
        raise InputError(
            "benchmark", "--submit", str(options.submit), "name an estimator too: whose estimates they are"
        )
    for file in (options.out, options.submit):
        if file is not None:
            check_file(file)
    tasks = _tasks(given)
    found = _submitted(tasks, options.score) if options.score else _scores(tasks, options.estimator, options.submit)
    written = [options.submit] if options.submit else []
    print_scores(found)
    options.console.table("scores", found)
    with atomic_file(options.out) as partial:
        partial.write_text(json.dumps(document(found, [*tasks]), indent=2) + "\n")
    save_figure(figure(found), options.out.with_suffix(""))
    options.console.wrote(options.out, *(options.out.with_suffix(suffix) for suffix in (".png", ".svg")), *written)
    return 0


def _tasks(given: Path | None) -> Tasks:
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
            found[task.with_kept_back(folder)] = folder
    for folder in {folder for task, folder in found.items() if task.folder != SHIPPED}:
        _name_unread([task for task, own in found.items() if own == folder], folder)
    return found


def _name_unread(tasks: Sequence[Task], folder: Path) -> None:
    unread = [Path(file) for file in unread_files(tasks, folder)]
    patterns = [Path(task.kept_back.file) for task in tasks if task.kept_back is not None]
    for parent in dict.fromkeys(file.parent for file in unread):
        names = ", ".join(file.name for file in unread if file.parent == parent)
        called = dict.fromkeys(pattern.name for pattern in patterns if pattern.parent == parent) or TRIALS
        print(f"{folder / parent}: not read: {names}; recordings are called {', '.join(called)}", file=sys.stderr)


def _scores(tasks: Tasks, own: str | None, submission: Path | None) -> list[Score]:
    """Scores of all estimators, by task; a user's own is run first, so that its mistakes are reported at once.

    Until it has answered everything, the inputs are all that is kept of what is tested.
    """
    runs = [(task, *each) for task in tasks for each in (baselines(task.question) | ours(task)).items()]
    found: dict[str, list[Score]] = {task.name: [] for task in tasks}
    stated: dict[Task, Answers] = {}
    count = len(runs) + (0 if own is None else len(tasks))
    with TemporaryDirectory() as copies, tqdm(total=count, desc="benchmark", unit="estimator", disable=None) as bar:
        if own is not None:
            for task in tasks:
                bar.set_postfix_str(f"{task.name}: {own}")
                stated[task] = _answers_apart(tasks, task, own, Path(copies))
                bar.update()
        train = {task: read_training(task, folder, Path(copies)) for task, folder in tasks.items()}
        tests = {task: read_tests(task, folder) for task, folder in tasks.items()}
        for task, name, estimator in runs:
            bar.set_postfix_str(f"{task.name}: {name}")
            answered = answers(task.question, name, estimator, train[task], inputs_of(tests[task]))
            found[task.name] += scores(task, name, answered, tests[task])
            bar.update()
    if own is not None:
        for task, answered in stated.items():
            found[task.name] += scores(task, own, answered, tests[task])
        if submission is not None:
            write_submission(submission, own, stated)
    return [score for of_task in found.values() for score in of_task]


def _answers_apart(tasks: Tasks, task: Task, name: str, copies: Path) -> Answers:
    """What a user's estimator states of a task, in a process that knows no other: their inputs may be answers here."""
    train, inputs = read_training(task, tasks[task], copies), inputs_of(read_tests(task, tasks[task]))
    with user_estimator(name, recorded_folders(tasks)) as (estimator, is_hidden):
        if not is_hidden and task is next(iter(tasks)):
            tqdm.write(f"{name} could read the tests: this system has no Landlock", file=sys.stderr)
        return answers(task.question, name, estimator, train, inputs)


def _submitted(tasks: Tasks, files: list[Path]) -> list[Score]:
    """Scores of submissions, in the tasks whose files are there."""
    tests = {task: read_tests(task, folder) for task, folder in tasks.items()}
    found = [score for file in files for score in _of_submission(file, tests)]
    if not found:
        raise InputError("benchmark", "--score", [str(file) for file in files], "has no task whose data are there")
    return found


def _of_submission(file: Path, tests: Mapping[Task, Tested]) -> Iterator[Score]:
    submission = read_submission(file)
    for task, tested in tests.items():
        if task.name in submission.tasks:
            yield from scores(task, submission.estimator, submission.answers(task, tested), tested)


def print_scores(scores: list[Score]) -> None:
    """Prints a line for every score, and then what others have published."""
    widths = [max(len(getattr(s, of)) for s in scores) for of in ("task", "region", "estimator")]
    titles = [f"{title:{width}}" for title, width in zip(("task", "region", "estimator"), widths, strict=True)]
    print(
        *titles, *(f"{title:>9}" for title in ("mean", "median", "95 %", "proper")), "  ", " in band     band    score"
    )
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
    return f"{score.within_band_percent:6.1f} % {_number(score.band):>8} {_number(score.interval_score):>8}{unknown}"


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
