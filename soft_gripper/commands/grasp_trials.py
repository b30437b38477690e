"""soft-gripper grasp-trials: pick and place over random objects."""

import argparse
from collections.abc import Callable, Sequence
from concurrent.futures import Executor
from contextlib import AbstractContextManager
from dataclasses import asdict
from pathlib import Path

import numpy as np
from scipy.stats import binomtest

from soft_gripper.commands.terminal.console import Console, add_console_options
from soft_gripper.commands.terminal.options import (
    MOST_SEED,
    Subparsers,
    add_command,
    add_executor_options,
    add_out_folder,
    chosen_executor,
    whole_number,
)
from soft_gripper.errors import InputError
from soft_gripper.files.output import atomic_file, claim_folder, keep_inputs, writable_folder
from soft_gripper.runs.trials.run import (
    ABOUT,
    FIGURE,
    SCENARIOS,
    TABLES,
    check_scenario_for_trials,
    judge,
    record_trial,
    run_trials,
)
from soft_gripper.runs.trials.trial import TrialRow
from soft_gripper.scenario.scenario_file import dump_scenario, load_scenario


def add_parser(subparsers: Subparsers) -> None:
    """Declares the command."""
    parser = add_command(
        subparsers,
        "grasp-trials",
        "pick and place over random poses, masses, frictions and sizes",
        "--trials 200 --seed 1                                        of every scenario",
        "--scenario pick_and_place_delicate --trials 20 --json",
        "--scenario pick_and_place_box --seed 1 --trial 7             one again, with its recording",
    )
    add_console_options(parser)
    parser.add_argument("--trials", metavar="N", default="20", help="of every scenario (default: %(default)s)")
    parser.add_argument("--seed", metavar="S", default="1", help="of what is random (default: %(default)s)")
    parser.add_argument(
        "--scenario", metavar="NAME", action="append", help=f"may be repeated (default: {', '.join(SCENARIOS)})"
    )
    parser.add_argument("--trial", metavar="K", help="run this trial alone, and keep its scenario and recording")
    parser.add_argument("--resume", action="store_true", help="run only the trials that are not in the tables")
    add_executor_options(parser)
    add_out_folder(parser, Path("results/grasp_trials"))
    parser.set_defaults(command=_run)


def _run(options: argparse.Namespace) -> None:
    seed = whole_number("grasp-trials", "--seed", options.seed, 0, MOST_SEED)
    files = _different(options.scenario or SCENARIOS)
    number = whole_number("grasp-trials", "--trials", options.trials, 1)
    executor = chosen_executor("grasp-trials", options)
    trial = whole_number("grasp-trials", "--trial", options.trial, 0) if options.trial is not None else None
    for file in files:
        check_scenario_for_trials(file)
    keep_inputs(files, [options.out / ABOUT])
    out = claim_folder(options.out)
    if trial is not None:
        for file in files:
            _run_alone(file, seed, trial, out, options.console)
    else:
        _run_all(files, number, seed, out, executor, options.resume, options.console)


def _run_all(
    files: Sequence[str],
    number: int,
    seed: int,
    out: Path,
    executor: AbstractContextManager[Executor],
    resume: bool,
    console: Console,
) -> None:
    kept = f"they are in {out / TABLES[0]}, --resume runs the others"
    with console.jobs(number * len(files), "trials", kept) as ended, executor as opened:
        trials = run_trials(files, number, seed, out, opened, lambda trial: ended(trial.row.success), resume)
    for file in files:
        _print_summary(file, seed, [trial.row for trial in trials if trial.row.scenario == Path(file).stem])
    console.table("trials", [trial.row for trial in trials])
    console.wrote(*(out / file for file in (*TABLES, f"{FIGURE}.png", f"{FIGURE}.svg")))


def _run_alone(file: str, seed: int, trial: int, out: Path, console: Console) -> None:
    """Runs one trial here, and keeps what it takes to look into it."""
    name = Path(file).stem
    with console.progress(f"{name} {trial}", load_scenario(file).duration) as progress:
        station, recording = record_trial(file, seed, trial, progress)
    folder = writable_folder(out / f"{name}_{trial}")
    recording.save(folder / "recording.nc")
    with atomic_file(folder / "scenario.yaml") as partial:
        partial.write_text(dump_scenario(station.scenario, folder), encoding="utf-8")
    found = judge(file, seed, trial, station, recording)
    for column, value in (asdict(found.row) | asdict(found.details)).items():
        print(f"{column:<20} {value:.3f}" if isinstance(value, float) else f"{column:<20} {value}")
    console.table("trials", [found.row])
    console.wrote(folder / "recording.nc", folder / "scenario.yaml")
    print(f"To watch it: soft-gripper run {folder / 'scenario.yaml'} --meshcat")


def _print_summary(file: str, seed: int, rows: Sequence[TrialRow]) -> None:
    """How the trials of a scenario went, and every failure with its cause."""
    placed, angles = [row.placed_error_mm for row in rows], [row.placed_angle_deg for row in rows]
    successes = sum(row.success for row in rows)
    low, high = binomtest(successes, len(rows)).proportion_ci(0.95, "wilson")
    likely = f"95 % confidence (Wilson): {100 * low:.1f} to {100 * high:.1f} %"
    print(f"\n{rows[0].scenario}: {successes} of {len(rows)} succeeded; {likely}")
    print(f"  placed error     mean {_over(np.mean, placed):.2f} mm, at most {_over(np.max, placed):.2f} mm")
    print(f"  placed angle     mean {_over(np.mean, angles):.1f} degrees, at most {_over(np.max, angles):.1f} degrees")
    for label, column, unit in (
        ("slip", "slip_mm", "mm"),
        ("peak force", "peak_force_n", "N"),
        ("detection delay", "detection_delay_ms", "ms"),
        ("size error", "size_error_mm", "mm"),
    ):
        print(f"  {label:<16} at most {_over(np.max, [getattr(row, column) for row in rows]):.2f} {unit}")
    for row in rows:
        if not row.success:
            print(f"  trial {row.trial}: {row.cause}")
            print(f"    again: soft-gripper grasp-trials --scenario {file} --seed {seed} --trial {row.trial}")


def _over(average: Callable[[Sequence[float]], float], values: Sequence[float]) -> float:
    """An average or an extreme of what was measured; NaN if nothing was."""
    measured = [value for value in values if not np.isnan(value)]
    return average(measured) if measured else float("nan")


def _different(files: Sequence[str]) -> Sequence[str]:
    """The scenarios, which the tables distinguish by their names alone."""
    names = [Path(file).stem for file in files]
    for file, name in zip(files, names, strict=True):
        if names.count(name) > 1:
            raise InputError("grasp-trials", "--scenario", file, "give scenarios of different names")
    return files
