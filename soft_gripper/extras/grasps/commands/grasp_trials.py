"""soft-gripper study grasp-trials: pick and place over random objects."""

import argparse
from collections.abc import Sequence
from concurrent.futures import Executor
from dataclasses import asdict
from pathlib import Path
from typing import Any

import numpy as np
from scipy.stats import binomtest

from soft_gripper.extras.grasps.trial import Trial
from soft_gripper.extras.grasps.trials import (
    ABOUT,
    FIGURE,
    SCENARIOS,
    TABLES,
    check_trial_scenario,
    judge,
    record_trial,
    run_trials,
    trials_together,
)
from soft_gripper.extras.sweeps.agreement import AGREEMENT, Agreement, agreement, draw_indices, print_agreement
from soft_gripper.extras.sweeps.executor import open_executor
from soft_gripper.extras.sweeps.job_progress import count_jobs
from soft_gripper.extras.sweeps.study import results
from soft_gripper.files.output import atomic_file, lock_folder, writable_folder
from soft_gripper.scenario.scenario_file import dump_scenario, load_scenario
from soft_gripper.scenario.schema import DRAKE


def run(options: argparse.Namespace) -> None:
    """Runs the command."""
    files = options.scenario or SCENARIOS
    for file in files:
        check_trial_scenario(file)
    out = lock_folder(options.out, [ABOUT], files)
    if options.trial is not None:
        for file in files:
            _run_alone(file, options, out)
    else:
        _run_all(files, out, options)


def _run_all(files: Sequence[str], out: Path, options: argparse.Namespace) -> None:
    trial_count = options.trials
    seed = options.seed
    console = options.console
    executor = open_executor(options.jobs, options.scheduler)
    warning = f"their results are in {out / TABLES[0]}; --resume runs the others"
    with count_jobs(console, trial_count * len(files), "trials", warning) as report_trial, executor as processes:
        trials = run_trials(
            *(files, trial_count, seed, out, processes, lambda trial: report_trial(trial.result.success)),
            resume=options.resume,
            engine=options.engine,
        )
        agreements = _compare_with_drake(files, trials, seed, options.check, processes)
    for file in files:
        _print_summary(file, seed, [trial for trial in trials if trial.scenario == Path(file).stem])
    if agreements:
        print_agreement(agreements, console, out)
    console.document["trials"] = [_row(trial) for trial in trials]
    files_of_check = [AGREEMENT] if agreements else []
    console.wrote(*(out / file for file in (*TABLES, f"{FIGURE}.png", f"{FIGURE}.svg", *files_of_check)))


def _compare_with_drake(
    files: Sequence[str], trials: Sequence[Trial], seed: int, checked: int, executor: Executor
) -> list[Agreement]:
    """Repeats `checked` trials of another engine in Drake and compares them."""
    sample = [trials[i] for i in draw_indices(len(trials), checked, seed)]
    files_by_name = {Path(file).stem: file for file in files}
    jobs = {
        i: (files_by_name[trial.scenario], seed, [trial.trial], {"engine": DRAKE}) for i, trial in enumerate(sample)
    }
    drake_trials = results(executor, trials_together, jobs)
    return agreement([*map(_cells, sample)], [_cells(drake_trials[i][0]) for i in jobs])


def _cells(trial: Trial) -> dict[str, str]:
    """The measures of a trial, as text."""
    values = asdict(trial.result) | asdict(trial.grasp)
    return {name: str(value) for name, value in values.items() if name != "cause"}


def _run_alone(file: str, options: argparse.Namespace, out: Path) -> None:
    """Runs one trial in this process, and keeps its scenario and recording for inspection."""
    seed = options.seed
    trial = options.trial
    console = options.console
    name = Path(file).stem
    with console.progress(f"{name} {trial}", load_scenario(file).duration) as progress:
        station, recording = record_trial(file, seed, trial, progress, options.engine)
    folder = writable_folder(out / f"{name}_{trial}")
    recording.save(folder / "recording.nc")
    with atomic_file(folder / "scenario.yaml") as partial:
        partial.write_text(dump_scenario(station.scenario, folder), encoding="utf-8")
    judged_trial = judge(file, seed, trial, station, recording)
    for column, value in (_row(judged_trial) | asdict(judged_trial.details) | asdict(judged_trial.grasp)).items():
        text = f"{value:.3f}".replace("nan", "-") if isinstance(value, float) else value
        print(f"{column:<20} {text}")
    console.document["trials"] = [_row(judged_trial)]
    console.wrote(folder / "recording.nc", folder / "scenario.yaml")
    print(f"To watch it: soft-gripper run {folder / 'scenario.yaml'} --meshcat")


def _row(trial: Trial) -> dict[str, Any]:
    """The result of a trial by column."""
    return {"scenario": trial.scenario, "trial": trial.trial, **asdict(trial.result)}


def _print_summary(file: str, seed: int, trials: Sequence[Trial]) -> None:
    """Prints the results of the trials of a scenario, and each failure with its cause."""
    rows = [trial.result for trial in trials]
    successes = sum(row.success for row in rows)
    low, high = binomtest(successes, len(rows)).proportion_ci(0.95, "wilson")
    confidence_text = f"95 % confidence (Wilson): {100 * low:.1f} to {100 * high:.1f} %"
    print(f"\n{trials[0].scenario}: {successes} of {len(rows)} succeeded; {confidence_text}")
    for label, column, form, unit in (
        ("placed error", "placed_error_mm", ".2f", "mm"),
        ("placed angle", "placed_angle_deg", ".1f", "degrees"),
        ("slip", "slip_mm", ".2f", "mm"),
        ("peak force", "peak_force_n", ".2f", "N"),
        ("squeeze", "squeeze_mm", ".2f", "mm"),
        ("detection delay", "detection_delay_ms", ".2f", "ms"),
        ("size error", "size_error_mm", ".2f", "mm"),
    ):
        values = [value for row in rows if np.isfinite(value := getattr(row, column))]
        if values:
            mean = f"mean {np.mean(values):{form}} {unit}, " if column.startswith("placed") else ""
            print(f"  {label:<16} {mean}at most {max(values):{form}} {unit}")
    for trial in trials:
        if not trial.result.success:
            print(f"  trial {trial.trial}: {trial.result.cause}")
            print(f"    rerun: soft-gripper study grasp-trials --scenario {file} --seed {seed} --trial {trial.trial}")
