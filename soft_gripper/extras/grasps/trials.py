"""Trials of pick and place: randomly varied scenarios, each of which can be rerun alone."""

from collections.abc import Callable, Iterator, Mapping, Sequence
from concurrent.futures import Executor
from dataclasses import asdict, replace
from pathlib import Path
from typing import Any, cast

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Circle
from matplotlib.ticker import MaxNLocator

from soft_gripper.diagrams.recording import Recording
from soft_gripper.diagrams.simulation import Progress, run_many, run_station
from soft_gripper.diagrams.station import make_private_station
from soft_gripper.diagrams.station_parts import Station
from soft_gripper.errors import InputError
from soft_gripper.extras.grasps.adds import Varied
from soft_gripper.extras.grasps.trial import KEYS, NAN, PARTS, Details, Trial, draw, random_numbers, vary
from soft_gripper.extras.sweeps.measured_runs import engine_step, engine_step_of
from soft_gripper.extras.sweeps.scenario_runs import runs_at_once
from soft_gripper.extras.sweeps.study import StudyTables, describe
from soft_gripper.files.row_table import columns
from soft_gripper.pictures.style import STYLE, save_figure
from soft_gripper.runs.scores.recorded_grasps import objects_of, recorded_grasp
from soft_gripper.runs.scores.recorded_object import RecordedObject
from soft_gripper.runs.scores.recorded_task import (
    MAX_PLACED_ANGLE,
    MAX_PLACED_ERROR,
    MAX_SLIP,
    Judged,
    TaskRun,
    judged,
    tilt,
    yaw,
)
from soft_gripper.scenario.scenario_file import changed_scenario, dump_scenario, load_scenario
from soft_gripper.scenario.schema import Scenario

GOOD, BAD = "#2166ac", "#b2182b"
RIM = 1.3  # position of values far beyond a limit, in limits
MEASURES = {  # columns of the rows
    "placed_error_mm": "placed error [mm]",
    "placed_angle_deg": "placed angle [degrees]",
    "slip_mm": "slip [mm]",
    "peak_force_n": "peak force [N]",
    "detection_delay_ms": "detection delay [ms]",
}


def trials_figure(trials: Sequence[Trial], force_limits: Mapping[str, float | None]) -> Figure:
    """Plots final object positions around the goal, and sorted measures; a row of panels per scenario.

    `force_limits` are the limits of the scenarios, N; None: no limit.
    """
    scenarios = list(dict.fromkeys(trial.scenario for trial in trials))
    with mpl.rc_context(STYLE):
        figure = Figure(figsize=(14, 2.7 * len(scenarios)), layout="constrained")
        panels = figure.subplots(len(scenarios), 1 + len(MEASURES), squeeze=False, sharex="col")
        for row, scenario in zip(panels, scenarios, strict=True):
            scenario_trials = [trial for trial in trials if trial.scenario == scenario]
            _draw_places(row[0], scenario_trials)
            limits = {
                "placed_error_mm": MAX_PLACED_ERROR,
                "placed_angle_deg": MAX_PLACED_ANGLE,
                "slip_mm": MAX_SLIP,
                "peak_force_n": force_limits[scenario] or 0.0,
            }
            for axes, measure in zip(row[1:], MEASURES, strict=True):
                _draw_measure(axes, scenario_trials, measure, limits.get(measure, 0.0))
            row[0].set_title(scenario.replace("_", " ").capitalize(), loc="left")
            row[1].set_ylabel("trials, cumulative")
        for axes, label in zip(panels[-1], ("x from the goal [mm]", *MEASURES.values()), strict=True):
            axes.set_xlabel(label)
        for axes in panels[-1][1:]:
            axes.set_xlim(0, 1.02 * axes.get_xlim()[1])
    return figure


def _draw_places(axes: Axes, trials: Sequence[Trial]) -> None:
    """Draws final object positions; those far outside the circle are drawn on the rim, in their direction."""
    axes.add_patch(Circle((0, 0), MAX_PLACED_ERROR, fill=False, ls="--", ec="0.4"))
    axes.plot(0, 0, "+", color="0.4", ms=10)
    for trial in trials:
        place = np.array([trial.details.placed_x_mm, trial.details.placed_y_mm])
        axes.plot(*place * min(1.0, RIM * MAX_PLACED_ERROR / max(np.hypot(*place), 1e-9)), **_marker_style(trial))
    end = 1.1 * RIM * MAX_PLACED_ERROR
    axes.set(xlim=(-end, end), ylim=(-end, end), aspect="equal", ylabel="y [mm]")


def _draw_measure(axes: Axes, trials: Sequence[Trial], measure: str, limit: float) -> None:
    """Draws the cumulative distribution of a measure. `limit` 0: no limit."""
    rim = RIM * limit if limit > 0 else np.inf
    known_trials = [trial for trial in trials if not np.isnan(getattr(trial.result, measure))]
    for rank, trial in enumerate(sorted(known_trials, key=lambda trial: getattr(trial.result, measure)), start=1):
        axes.plot(min(getattr(trial.result, measure), rim), rank, **_marker_style(trial))
    if limit > 0:
        axes.axvline(limit, color="0.4", ls="--")
    axes.set_ylim(0, len(trials) + 1)
    axes.yaxis.set_major_locator(MaxNLocator(integer=True))


def _marker_style(trial: Trial) -> dict[str, Any]:
    """Style of a trial's marker: a dot for a success, a cross for a failure."""
    success = trial.result.success
    return {"marker": "o" if success else "x", "ms": 4, "color": GOOD if success else BAD, "clip_on": False}


ABOUT = "trials.yaml"
TABLES = ("trials.csv", "trials_details.csv", "trials_grasps.csv")
FIGURE = "trials"
SCENARIOS = ("pick_and_place_box", "pick_and_place_irregular", "pick_and_place_delicate", "pick_and_place_apple")


def check_trial_scenario(file: str) -> None:
    """Checks a scenario before any work is done.

    Raises:
        InputError: if it cannot be built, its object cannot be varied, or there is nothing to score.
    """
    scenario = load_scenario(file)
    if scenario.task is None:
        raise InputError(file, "task", None, "give a task for the trials")
    if not any(phase.holds for phase in scenario.task.phases):
        raise InputError(file, "task.phases", "...", "give at least one that holds the object")
    if scenario.estimator.contact_threshold is None:
        raise InputError(file, "estimator.contact_threshold", None, "give a torque, so that contact is detected")
    try:
        make_private_station(scenario)
        vary(scenario, random_numbers(0, file, 0))
    except InputError as error:
        raise error.inside(file) from error.__cause__


def run_trials(
    files: Sequence[str],
    number: int,
    seed: int,
    out: Path,
    executor: Executor,
    report: Callable[[Trial], Any],
    resume: bool = False,
    engine: str | None = None,
) -> list[Trial]:
    """Runs `number` trials of each scenario.

    A row is added to the tables in `out` as each trial ends; after the last trial, the rows are sorted and a figure is
    written. The same seed gives the same tables.

    Args:
        files: names or paths of the scenarios.
        executor: makes the runs.
        report: called with each finished trial.
        resume: keep the trials in the tables, and run the others.
        engine: that simulates them; None: that of each scenario.

    Raises:
        InputError: if the trials to resume have another seed or other scenarios.
    """
    tables = StudyTables(
        out, ABOUT, {table: [*KEYS, *columns(part)] for table, part in zip(TABLES, PARTS, strict=True)}, len(KEYS)
    )
    engine_change = {} if engine is None else {"engine": engine}
    changes = {file: engine_change | engine_step_of(file, engine_change, executor) for file in files}
    tables.begin(_describe_trials(changes, seed), resume)
    for suffix in (".png", ".svg"):  # figures of fewer trials
        (out / FIGURE).with_suffix(suffix).unlink(missing_ok=True)
    trials = {key: Trial.from_rows(rows) for key, rows in tables.rows.items()}

    def keep(batch: Batch, batch_trials: Sequence[Trial]) -> None:
        for key, trial in zip(batch, batch_trials, strict=True):
            if key not in tables.rows:
                trials[key] = trial
                tables.add(*trial.rows)

    jobs = dict(_batches(changes, number, seed))

    def fail_batch(batch: Batch, cause: str) -> list[Trial]:
        file, _, numbers, _ = jobs[batch]
        return [_failed_trial(file, seed, trial_number, cause) for trial_number in numbers]

    def report_batch(batch: Batch) -> None:
        for key in batch:
            report(trials[key])

    tables.run(executor, trials_together, jobs, keep, fail_batch, report_batch, keys=lambda batch: batch)
    names = [Path(file).stem for file in files]
    order = sorted(trials, key=lambda key: (names.index(key[0]), int(key[1])))
    tables.finish(order)
    sorted_trials = [trials[key] for key in order]
    tasks = {Path(file).stem: load_scenario(file).task for file in files}
    limits = {name: None if task is None else task.force_limit for name, task in tasks.items()}
    save_figure(trials_figure(sorted_trials, limits), out / FIGURE)
    return sorted_trials


Batch = tuple[tuple[str, str], ...]  # keys of trials that are run together
Changes = Mapping[str, Any]  # of a scenario, by dotted keys


def _batches(
    changes: Mapping[str, Changes], number: int, seed: int
) -> Iterator[tuple[Batch, tuple[str, int, list[int], Changes]]]:
    """Yields batches of trials: their keys and the arguments of `trials_together`; scenarios alternate."""
    size = min(runs_at_once(changed_scenario(*change), number) for change in changes.items())
    for first_trial in range(0, number, size):
        numbers = list(range(first_trial, min(first_trial + size, number)))
        for file, file_changes in changes.items():
            yield (
                tuple((Path(file).stem, str(trial_number)) for trial_number in numbers),
                (file, seed, numbers, file_changes),
            )


def _describe_trials(changes: Mapping[str, Changes], seed: int) -> str:
    """Text that identifies a set of trials: the seed, and all scenarios."""
    scenarios = (
        f"# {Path(file).stem}\n{dump_scenario(changed_scenario(file, change))}" for file, change in changes.items()
    )
    return "\n".join([f"seed: {seed}", *scenarios])


def trials_together(file: str, seed: int, numbers: Sequence[int], changes: Changes) -> list[Trial]:
    """Runs trials of a scenario with changes, which an engine may simulate together; one that fails has its cause."""
    base = changed_scenario(file, changes)
    scenarios = [_vary_or_error(base, file, seed, number) for number in numbers]
    runs = run_many([scenario for scenario in scenarios if isinstance(scenario, Scenario)], described=False)
    trials = []
    for number, scenario in zip(numbers, scenarios, strict=True):
        run = next(runs) if isinstance(scenario, Scenario) else scenario
        if isinstance(run, Exception):
            trials.append(_failed_trial(file, seed, number, describe(run)))
        else:
            trials.append(judge(file, seed, number, run.station, run.recording))
    return trials


def record_trial(
    file: str, seed: int, trial: int, progress: Progress | None = None, engine: str | None = None
) -> tuple[Station, Recording]:
    """Runs one trial like `run_trials`, and returns its recording too; `progress` as for `simulate`.

    Raises:
        InputError: if its variation cannot be built.
        SimulationDivergedError: if its state is no longer finite.
    """
    base = changed_scenario(file, {} if engine is None else {"engine": engine})
    base.engine_step = engine_step(base)
    scenario = _vary_or_error(base, file, seed, trial)
    if isinstance(scenario, Exception):
        raise scenario
    station = make_private_station(scenario)
    return station, run_station(station, progress=progress)


def _vary_or_error(base: Scenario, file: str, seed: int, trial: int) -> Scenario | InputError:
    try:
        return vary(base, random_numbers(seed, Path(file).stem, trial))[0]
    except InputError as error:
        return error


def judge(file: str, seed: int, trial: int, station: Station, recording: Recording) -> Trial:
    """The result of a trial, from its recording."""
    run = TaskRun(station, recording)
    x, y, _ = 1e3 * run.placed_offset
    details = replace(
        _details(file, seed, trial),
        placed_x_mm=float(x),
        placed_y_mm=float(y),
        placed_yaw_deg=float(np.degrees(yaw(run.placed_rotation))),
        placed_tilt_deg=float(np.degrees(tilt(run.placed_rotation))),
    )
    grasp, _ = recorded_grasp(RecordedObject(station, recording, objects_of(station)[0]))
    return Trial(Path(file).stem, trial, judged(station, recording), details, grasp)


def _failed_trial(file: str, seed: int, trial: int, cause: str) -> Trial:
    """Makes the result of a trial that ended in an error."""
    result = Judged(False, NAN, NAN, False, NAN, NAN, NAN, NAN, NAN, NAN, cause)
    return Trial(Path(file).stem, trial, result, _details(file, seed, trial))


def _details(file: str, seed: int, trial: int) -> Details:
    """The random draw of a trial."""
    task = load_scenario(file).task
    assert task is not None
    variation = draw(random_numbers(seed, Path(file).stem, trial), cast(Varied, task).trials)
    return Details(
        **asdict(variation),
        reported_x_mm=variation.x_mm + variation.error_x_mm,
        reported_y_mm=variation.y_mm + variation.error_y_mm,
        reported_yaw_deg=variation.yaw_deg + variation.error_yaw_deg,
    )
