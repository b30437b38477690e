"""python -m studies benchmark: scores estimators on simulated contacts and grasps and on recorded hardware."""

import argparse
import json
import math
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
from soft_gripper.files.row_table import columns, print_table
from soft_gripper.pictures.style import save_figure
from studies.benchmark.baselines import baselines
from studies.benchmark.benchmark_task import (
    BenchmarkTask,
    Tested,
    missing_files,
    read_tests,
    read_training,
    recorded_folders,
    region_inputs,
    unread_files,
)
from studies.benchmark.contacts import FOLDER as SHIPPED
from studies.benchmark.estimates import Answers, answers
from studies.benchmark.measured_force import LOG_PATTERNS, force_tasks
from studies.benchmark.ours import ours
from studies.benchmark.published import comparable_numbers
from studies.benchmark.report import document, figure, load_scores, region_scores
from studies.benchmark.scores import Score, scores
from studies.benchmark.submission import read_submission, write_submission
from studies.benchmark.tasks import TASKS
from studies.benchmark.user_estimator import user_estimator

Tasks = Mapping[BenchmarkTask, Path]  # and the folders of their files


def run(options: argparse.Namespace) -> int:
    """Runs the command."""
    if options.compare:
        compare(options.compare)
        return 0
    folder = options.data or (Path(variable) if (variable := os.environ.get(DATA_FOLDER)) else None)
    if folder is not None and not folder.is_dir():
        raise InputError("benchmark", "--data", str(folder), "give a folder of recordings")
    if options.submit and options.estimator is None:
        raise InputError(
            "benchmark", "--submit", str(options.submit), "name an estimator too: whose estimates they are"
        )
    for file in (options.out, options.submit):
        if file is not None:
            check_file(file)
    tasks = _tasks(folder)
    results = (
        _score_submissions(tasks, options.score)
        if options.score
        else _score_all(tasks, options.estimator, options.submit)
    )
    files = [options.submit] if options.submit else []
    print_scores(results)
    options.console.table("scores", results)
    with atomic_file(options.out) as partial:
        partial.write_text(json.dumps(document(results, [*tasks]), indent=2) + "\n")
    save_figure(figure(results), options.out.with_suffix(""))
    options.console.wrote(options.out, *(options.out.with_suffix(suffix) for suffix in (".png", ".svg")), *files)
    return 0


def _tasks(data_folder: Path | None) -> Tasks:
    """Tasks with all files, and their folders; prints the sources of the others."""
    folders = {}
    for task in (*TASKS, *(force_tasks(data_folder) if data_folder else ())):
        folder = task.folder or data_folder
        if folder is None:
            print(f"{task.name}: skipped; download {task.source}, and give the folder with --data", file=sys.stderr)
        elif missing := missing_files(task, folder):
            remark = f"skipped, {folder} has no {', '.join(missing)}; they are at {task.source}"
            print(f"{task.name}: {remark}", file=sys.stderr)
        else:
            folders[task.add_kept_back(folder)] = folder
    for folder in {folder for task, folder in folders.items() if task.folder != SHIPPED}:
        _name_unread([task for task, task_folder in folders.items() if task_folder == folder], folder)
    return folders


def _name_unread(tasks: Sequence[BenchmarkTask], folder: Path) -> None:
    files = [Path(file) for file in unread_files(tasks, folder)]
    patterns = [Path(task.kept_back.file) for task in tasks if task.kept_back is not None]
    for parent in dict.fromkeys(file.parent for file in files):
        names = ", ".join(file.name for file in files if file.parent == parent)
        expected = dict.fromkeys(pattern.name for pattern in patterns if pattern.parent == parent) or LOG_PATTERNS
        print(f"{folder / parent}: not read: {names}; recordings are called {', '.join(expected)}", file=sys.stderr)


def _score_all(tasks: Tasks, user_name: str | None, submission: Path | None) -> list[Score]:
    """Scores of all estimators, by task; a user's own is run first, so that its mistakes are reported at once.

    Until it has answered everything, only the inputs of the tests are in memory.
    """
    runs = [(task, *item) for task in tasks for item in (baselines(task.question) | ours(task)).items()]
    scores_by_task: dict[str, list[Score]] = {task.name: [] for task in tasks}
    user_answers: dict[BenchmarkTask, Answers] = {}
    count = len(runs) + (0 if user_name is None else len(tasks))
    with TemporaryDirectory() as copies, tqdm(total=count, desc="benchmark", unit="estimator", disable=None) as bar:
        if user_name is not None:
            for task in tasks:
                bar.set_postfix_str(f"{task.name}: {user_name}")
                user_answers[task] = _isolated_answers(tasks, task, user_name, Path(copies))
                bar.update()
        train = {task: read_training(task, folder, Path(copies)) for task, folder in tasks.items()}
        tests = {task: read_tests(task, folder) for task, folder in tasks.items()}
        for task, name, estimator in runs:
            bar.set_postfix_str(f"{task.name}: {name}")
            task_answers = answers(task.question, name, estimator, train[task], region_inputs(tests[task]))
            scores_by_task[task.name] += scores(task, name, task_answers, tests[task])
            bar.update()
    if user_name is not None:
        for task, task_answers in user_answers.items():
            scores_by_task[task.name] += scores(task, user_name, task_answers, tests[task])
        if submission is not None:
            write_submission(submission, user_name, user_answers)
    return [score for of_task in scores_by_task.values() for score in of_task]


def _isolated_answers(tasks: Tasks, task: BenchmarkTask, name: str, copies: Path) -> Answers:
    """Answers of a user's estimator to a task, in a separate process: inputs of other tasks may be answers here."""
    train = read_training(task, tasks[task], copies)
    inputs = region_inputs(read_tests(task, tasks[task]))
    with user_estimator(name, recorded_folders(tasks)) as (estimator, is_hidden):
        if not is_hidden and task is next(iter(tasks)):
            tqdm.write(f"{name} could read the tests: this system has no Landlock", file=sys.stderr)
        return answers(task.question, name, estimator, train, inputs)


def _score_submissions(tasks: Tasks, files: list[Path]) -> list[Score]:
    """Scores submissions in all tasks whose data are present."""
    tests = {task: read_tests(task, folder) for task, folder in tasks.items()}
    all_scores = [score for file in files for score in _submission_scores(file, tests)]
    if not all_scores:
        raise InputError("benchmark", "--score", [str(file) for file in files], "has no task whose data are there")
    return all_scores


def _submission_scores(file: Path, tests: Mapping[BenchmarkTask, Tested]) -> Iterator[Score]:
    submission = read_submission(file)
    for task, tested in tests.items():
        if task.name in submission.tasks:
            yield from scores(task, submission.estimator, submission.answers(task, tested), tested)


def print_scores(scores: list[Score]) -> None:
    """Prints a line for every score, and then published numbers."""
    _print_fields(scores, [name for name in columns(Score) if name != "samples"])
    published = comparable_numbers({score.task for score in scores})
    if published:
        print("\npublished, of other bodies and sensors:")
    for number in published:
        print(f"  {number.value}: {number.what} ({number.source}); see {number.tasks.replace(' ', ', ')}")


def _print_fields(scores: Sequence[Score], names: Sequence[str], title: str = "") -> None:
    """Prints a table of fields of scores; what a score lacks is a dash."""
    forms = {name: "" if name in ("task", "region", "estimator", "unit") else ".4g" for name in names}
    values = ([getattr(score, name) for name in names] for score in scores)
    rows = [[math.nan if value is None else value for value in row] for row in values]
    print_table({name.replace("_percent", " [%]").replace("_", " "): form for name, form in forms.items()}, rows, title)


def compare(files: list[Path]) -> None:
    """Prints the scores of several results files beside each other; the least proper score of a region has a star."""
    all_scores = [
        replace(score, estimator=f"{file.stem}: {score.estimator}") for file in files for score in load_scores(file)
    ]
    names = [name for name in columns(Score) if name not in ("task", "region", "samples", "unit")]
    for (task, region), estimator_scores in region_scores(all_scores).items():
        region_rows = list(estimator_scores.values())
        lowest = min(score.proper for score in region_rows)
        starred = [replace(s, estimator=f"* {s.estimator}") if s.proper == lowest else s for s in region_rows]
        _print_fields(starred, names, f"{task}, {region} [{region_rows[0].unit}]")
