"""A sweep: many variations of a scenario run by an executor, into a folder from which it goes on if it is cut short."""

import json
from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import Executor
from importlib.metadata import version
from pathlib import Path
from typing import Any

from soft_gripper.diagrams.kept_stations import kept_station
from soft_gripper.diagrams.simulation import check_closed, run_station
from soft_gripper.diagrams.station import make_station
from soft_gripper.errors import InputError
from soft_gripper.files.output import lock_folder
from soft_gripper.runs.study import StudyTables, describe, run_study
from soft_gripper.runs.sweep.axes import Variation
from soft_gripper.runs.sweep.measures import OPTION, column_of, kind_of, measure, names_of
from soft_gripper.scenario.scenario_file import changed_scenario, dump_scenario


def run_variation(scenario: str, changes: Mapping[str, Any], own: Sequence[str] = ()) -> dict[str, Any]:
    """Runs a scenario with changes, and measures what comes of it.

    Args:
        scenario: name of a shipped one, or path of a file.
        changes: values by dotted keys, see `changed_scenario`.
        own: measures of the user's, each as "module:function".

    Returns:
        measures by their names, see `measures`; which there are depends on the kind of the scenario.

    Raises:
        InputError: if the scenario cannot be built with the changes, or a measure of the user's fails.
        SimulationDivergedError: if the state leaves the finite numbers.
    """
    station = kept_station(changed_scenario(scenario, changes))
    if not station.fingers:
        models = [model.file for model in station.scenario.models]
        raise InputError("sweep", "models", models, "there is no <finger> in them")
    return measure(station, run_station(station), own)


TABLE, ABOUT = "sweep.csv", "sweep.json"
NUMBER, ERROR = "run", "error"  # the first and the last column
_DESCRIBES = ("description",)  # keys that have no effect on a run


def check_keys(scenario: str, fixed: Mapping[str, Any], variations: Sequence[Variation]) -> None:
    """Looks at the scenario, and at every key by its first and its last value, before any work is done.

    Raises:
        InputError: if the scenario cannot be built as it is, or a key cannot be varied.
    """
    base = changed_scenario(scenario, fixed)
    try:
        check_closed(make_station(base))
    except InputError as error:
        raise error.inside(scenario) from error.__cause__
    for key in variations[0]:
        if key in _DESCRIBES:
            raise InputError("sweep", "--vary", key, "cannot be varied: it has no effect on a run")
        for variation in (variations[0], variations[-1]):
            try:
                changed = changed_scenario(scenario, {**fixed, key: variation[key]})
            except InputError as error:
                raise error.inside(f"sweep: --vary {key}") from error.__cause__
            if kind_of(changed) != kind_of(base):
                raise InputError("sweep", "--vary", key, "cannot be varied: a run of another kind has other results")


def run_sweep(
    scenario: str,
    variations: Sequence[Variation],
    out: Path,
    executor: Executor,
    *,
    fixed: Mapping[str, Any] | None = None,
    own: Sequence[str] = (),
    resume: bool = False,
    report: Callable[[bool], Any] = lambda fine: None,
) -> list[dict[str, str]]:
    """Runs variations of a scenario, and adds a row to the table in `out` as each ends; those that fail have one too.

    Args:
        scenario: name of a shipped one, or path of a file.
        variations: each with the same keys, see `changed_scenario`.
        out: a folder, which is made.
        executor: runs them.
        fixed: changes of every run.
        own: measures of the user's, each as "module:function"; see `measures`.
        resume: keep the rows that are there.
        report: called as each ends, with True if it succeeded.

    Returns:
        the rows of the table, cells by columns: the number of a run, what was varied, what was measured, and an error
        in words, empty without one.

    Raises:
        InputError: if a key cannot be varied, there is no such measure, `out` cannot be written to, another process
            writes to it, or what is to be resumed is another sweep.
    """
    fixed, keys = dict(fixed or {}), list(variations[0])
    check_keys(scenario, fixed, variations)
    if scenario.endswith((".yaml", ".yml")):
        scenario = str(Path(scenario).resolve())  # workers may be anywhere
    base = changed_scenario(scenario, fixed)
    names = names_of(kind_of(base), own)
    columns = [NUMBER, *keys, *names, ERROR]
    for name in own:
        if columns.count(column := column_of(name)) > 1:
            raise InputError("sweep", OPTION, name, f"there is a column '{column}' already; rename the function")
    table = StudyTables(lock_folder(out), ABOUT, {TABLE: columns}, 1)
    table.begin(_about(scenario, dump_scenario(base), variations, own), resume)
    for (row,) in table.rows.values():
        report(row[-1] == "")

    def keep(number: int, measured: dict[str, Any]) -> None:
        given = {NUMBER: number, **variations[number], **measured}
        row = [cell(given.get(column)) for column in columns]
        table.add(row)
        report(row[-1] == "")

    wanted = [(str(number),) for number in range(len(variations))]
    jobs = {
        number: (scenario, fixed | variations[number], own)
        for number, key in enumerate(wanted)
        if key not in table.rows
    }
    run_study(executor, run_variation, jobs, keep, lambda number, error: {ERROR: describe(error)})
    table.finish(wanted)
    return [dict(zip(columns, row, strict=True)) for (row,) in table.rows.values()]


def _about(scenario: str, base: str, variations: Sequence[Variation], own: Sequence[str]) -> str:
    """What a sweep is of, as text."""
    versions = {name: version(name) for name in ("soft-gripper", "drake", "numpy")}
    parts = {"scenario": scenario, "versions": versions, "measures": list(own), "resolved": base.splitlines()}
    return json.dumps(parts | {"runs": list(variations)}, indent=1, default=str) + "\n"


def cell(value: Any) -> str:
    """A value as text; numbers with nine digits."""
    if isinstance(value, float):
        return f"{value + 0.0:.9g}"
    return "" if value is None else str(value)
