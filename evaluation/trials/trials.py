"""Trials of pick and place: scenarios varied at random, many in processes, each of which can be run again alone."""

from collections.abc import Callable, Sequence
from concurrent.futures import Future
from concurrent.futures.process import BrokenProcessPool
from dataclasses import asdict, replace
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from soft_gripper.diagrams.recording.recording import Recording
from soft_gripper.diagrams.schema.scenario_file import load_scenario
from soft_gripper.diagrams.simulation import Progress, run_station
from soft_gripper.diagrams.station import make_station
from soft_gripper.diagrams.station_parts import Station
from soft_gripper.errors import InputError, SimulationDivergedError
from soft_gripper.evaluation.csv_table import write_csv
from soft_gripper.evaluation.figure_style import save_figure
from soft_gripper.evaluation.processes import Call, call_in_processes
from soft_gripper.evaluation.trials.trial import DetailRow, Trial, failed_row, trial_row
from soft_gripper.evaluation.trials.trial_run import TrialRun
from soft_gripper.evaluation.trials.trials_figure import trials_figure
from soft_gripper.evaluation.trials.turning import tilt, yaw
from soft_gripper.evaluation.trials.variation import draw, random_numbers, vary

SCENARIOS = ("pick_and_place_box", "pick_and_place_irregular", "pick_and_place_delicate", "pick_and_place_apple")
TABLES = ("trials.csv", "trials_details.csv")
FIGURE = "trials"
OF_A_WORKER = 25  # trials, after which a process makes way for another: systems written in Python are not freed


def check_scenario_for_trials(file: str) -> None:
    """Looks at a scenario before any work is done.

    Raises:
        InputError: if it cannot be built, its object not be varied, or there is nothing to judge.
    """
    scenario = load_scenario(file)
    if scenario.task is None:
        raise InputError(file, "task", None, "give a task to be tried")
    if not any(phase.holds for phase in scenario.task.phases):
        raise InputError(file, "task.phases", "...", "give at least one that holds the object")
    if scenario.estimator.contact_threshold is None:
        raise InputError(file, "estimator.contact_threshold", None, "give a torque, so that contact is looked for")
    try:
        make_station(scenario)
        vary(scenario, random_numbers(0, file, 0))
    except InputError as error:
        raise error.inside(file) from None


def run_trials(
    files: Sequence[str], number: int, seed: int, out: Path, jobs: int, report: Callable[[Trial], Any]
) -> list[Trial]:
    """Runs `number` trials of every scenario in `jobs` processes.

    The tables in `out` are written anew after every trial, the figure after the last. The same seed leads to the
    same tables.

    Args:
        files: names or paths of scenarios.
        report: called with every trial that has ended.
    """
    for stale in (*TABLES, f"{FIGURE}.png", f"{FIGURE}.svg"):
        (out / stale).unlink(missing_ok=True)
    calls = [(file, seed, trial) for trial in range(number) for file in files]
    trials: dict[Call, Trial] = {}
    deserted: list[Call] = []  # by a process that died, over one of them

    def ended(call: Call, future: Future[Trial], alone: bool = False) -> None:
        error = future.exception()
        if isinstance(error, BrokenProcessPool) and not alone:
            deserted.append(call)
            return
        trials[call] = _failed(call, error) if error else future.result()
        _write_tables(out, _in_order(trials, files))
        report(trials[call])

    batch = jobs * OF_A_WORKER
    for begin in range(0, len(calls), batch):
        call_in_processes(run_trial, calls[begin : begin + batch], jobs, ended)
    for call in deserted:
        call_in_processes(run_trial, [call], 1, partial(ended, alone=True))
    force_limits = {Path(file).stem: _force_limit(file) for file in files}
    save_figure(trials_figure(_in_order(trials, files), force_limits), out / FIGURE)
    return _in_order(trials, files)


def _force_limit(file: str) -> float | None:
    task = load_scenario(file).task
    return None if task is None else task.force_limit


def _in_order(trials: dict[Call, Trial], files: Sequence[str]) -> list[Trial]:
    """Scenario after scenario, by the numbers of the trials."""
    return [trials[call] for call in sorted(trials, key=lambda call: (files.index(call[0]), call[2]))]


def _write_tables(out: Path, trials: Sequence[Trial]) -> None:
    write_csv(out / TABLES[0], [trial.row for trial in trials])
    write_csv(out / TABLES[1], [trial.details for trial in trials])


def run_trial(file: str, seed: int, trial: int) -> Trial:
    """Runs one trial.

    Raises:
        InputError: if its variation cannot be built.
        SimulationDivergedError: if its state leaves the finite numbers.
    """
    return judge(file, seed, trial, *record_trial(file, seed, trial))


def record_trial(file: str, seed: int, trial: int, progress: Progress | None = None) -> tuple[Station, Recording]:
    """Runs one trial and keeps its recording; `progress` as for `simulate`. Raises what `run_trial` does."""
    scenario, _ = vary(load_scenario(file), random_numbers(seed, Path(file).stem, trial))
    station = make_station(scenario)
    return station, run_station(station, progress=progress)


def judge(file: str, seed: int, trial: int, station: Station, recording: Recording) -> Trial:
    """What came of a trial, from its recording."""
    name, run = Path(file).stem, TrialRun(station, recording)
    x, y, _ = 1e3 * run.placed
    details = replace(
        _details(name, seed, trial),
        placed_x_mm=float(x),
        placed_y_mm=float(y),
        placed_yaw_deg=float(np.degrees(yaw(run.turned))),
        placed_tilt_deg=float(np.degrees(tilt(run.turned))),
    )
    return Trial(trial_row(name, trial, station, recording), details)


def _failed(call: Call, error: BaseException) -> Trial:
    """A trial that ended in an error."""
    file, seed, trial = call
    name = Path(file).stem
    kind = "" if isinstance(error, (InputError, SimulationDivergedError)) else f"{type(error).__name__}: "
    cause = kind + " ".join(str(error).split())
    return Trial(failed_row(name, trial, cause), _details(name, seed, trial))


def _details(name: str, seed: int, trial: int) -> DetailRow:
    """What was drawn for a trial."""
    drawn = draw(random_numbers(seed, name, trial))
    return DetailRow(
        name,
        trial,
        **asdict(drawn),
        reported_x_mm=drawn.x_mm + drawn.error_x_mm,
        reported_y_mm=drawn.y_mm + drawn.error_y_mm,
        reported_yaw_deg=drawn.yaw_deg + drawn.error_yaw_deg,
    )
