"""A sweep: a scenario run with many values of its fields by an executor, with a folder from which it can be resumed."""

from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import Executor
from pathlib import Path
from typing import Any

from soft_gripper.diagrams.simulation import check_closed
from soft_gripper.diagrams.station import make_station
from soft_gripper.errors import InputError
from soft_gripper.extras.sweeps.axes import SweepPoint
from soft_gripper.extras.sweeps.measured_runs import DEPENDS, ENGINE_STEP, ERROR, STEP, engine_step_of
from soft_gripper.extras.sweeps.own_measures import OPTION, column_of, columns_of
from soft_gripper.extras.sweeps.scenario_runs import ScenarioRuns
from soft_gripper.runs.measures import kind_of, names_of
from soft_gripper.scenario.scenario_file import changed_scenario
from soft_gripper.scenario.schema import DRAKE

TABLE, ABOUT = "sweep.csv", "sweep.json"
NUMBER = "run"  # the first column
_DESCRIBES = ("description",)  # keys that have no effect on a run


def check_keys(scenario: str, fixed_changes: Mapping[str, Any], points: Sequence[SweepPoint]) -> None:
    """Checks the scenario, and the first and last value of each key, before any work is done.

    Raises:
        InputError: if the scenario itself cannot be built, or a key cannot be varied.
    """
    base = changed_scenario(scenario, fixed_changes)
    try:
        check_closed(make_station(base))
    except InputError as error:
        raise error.inside(scenario) from error.__cause__
    for key in points[0]:
        if key in _DESCRIBES:
            raise InputError("sweep", "--vary", key, "cannot be varied: it has no effect on a run")
        for point in (points[0], points[-1]):
            try:
                changed = changed_scenario(scenario, {**fixed_changes, key: point[key]})
            except InputError as error:
                raise error.inside(f"sweep: --vary {key}") from error.__cause__
            if kind_of(changed) != kind_of(base):
                raise InputError("sweep", "--vary", key, "cannot be varied: other kinds of runs have other measures")


def run_sweep(
    scenario: str,
    points: Sequence[SweepPoint],
    out: Path,
    executor: Executor,
    *,
    fixed: Mapping[str, Any] | None = None,
    own: Sequence[str] = (),
    check_step: bool = False,
    resume: bool = False,
    report: Callable[[bool], Any] = lambda fine: None,
) -> list[dict[str, str]]:
    """Runs a scenario at many points, and adds a row to the table in `out` as each ends, including failed ones.

    Args:
        scenario: name of a shipped one, or path of a file.
        points: each with the same keys, see `changed_scenario`.
        out: a folder, created if needed.
        executor: makes the runs.
        fixed: changes applied to every run.
        own: user measures, each as "module:function"; see `measures`.
        check_step: repeat each run with half the time step; one more column names the measures that depend on it.
        resume: keep existing rows.
        report: called after each run, with True if it succeeded.

    Returns:
        the rows of the table, cells by column: the run number, the varied keys, the measures, and an error message,
        empty if the run succeeded.

    Raises:
        InputError: if a key cannot be varied, a measure does not exist, `out` cannot be written to, another process
            writes to it, or the sweep to resume is a different one.
    """
    fixed, keys = dict(fixed or {}), list(points[0])
    check_keys(scenario, fixed, points)
    if scenario.endswith((".yaml", ".yml")):
        scenario = str(Path(scenario).resolve())  # workers may have other working folders
    base = changed_scenario(scenario, fixed)
    names = [*names_of(kind_of(base)), *columns_of(own)]
    if check_step and base.plant_config.time_step == 0:
        raise InputError("sweep", STEP, 0.0, "give a time step above 0, which --check-step can halve")
    checked = [DEPENDS] if check_step else []
    columns = [*keys, *names, *checked]
    for name in own:
        if [NUMBER, *columns, ERROR].count(column := column_of(name)) > 1:
            raise InputError("sweep", OPTION, name, f"there is already a column '{column}'; rename the function")
    runs = ScenarioRuns(out, TABLE, ABOUT, [NUMBER], columns)
    if ENGINE_STEP not in keys:
        engine_points = [point for point in points if point.get("engine", DRAKE) != DRAKE]
        engine = {"engine": engine_points[0]["engine"]} if engine_points else {}
        fixed |= engine_step_of(scenario, fixed | engine, executor)
        base = changed_scenario(scenario, fixed)
    runs.begin_runs(base, resume, scenario=scenario, measures=[*own, *checked], runs=list(points))
    changes: dict[tuple[str, ...], Mapping[str, Any]] = {
        (str(number),): fixed | point for number, point in enumerate(points)
    }
    runs.run_changed(executor, base, (scenario, changes), (own, check_step), lambda row: report(row[ERROR] == ""))
    runs.finish(changes)
    return [runs.row(key) for key in changes]
