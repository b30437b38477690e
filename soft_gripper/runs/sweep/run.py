"""A sweep: many variations of a scenario run by an executor, into a folder from which it goes on if it is cut short."""

import json
from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import Executor, Future
from dataclasses import asdict, fields
from importlib.metadata import version
from pathlib import Path
from typing import Any

from soft_gripper.diagrams.kept_stations import kept_station
from soft_gripper.diagrams.simulation import check_closed, run_station
from soft_gripper.diagrams.station import make_station
from soft_gripper.errors import InputError, SimulationDivergedError, WorkerDiedError
from soft_gripper.files.output import atomic_file, lock_folder
from soft_gripper.files.text import read_text
from soft_gripper.runs.executor import Call, make_calls
from soft_gripper.runs.sweep.axes import Variation
from soft_gripper.runs.sweep.measures import kind_of, measure
from soft_gripper.runs.sweep.table import SweepTable
from soft_gripper.scenario.scenario_file import changed_scenario, dump_scenario


def run_variation(scenario: str, changes: Mapping[str, Any]) -> dict[str, Any]:
    """Runs a scenario with changes, and measures what comes of it.

    Args:
        scenario: name of a shipped one, or path of a file.
        changes: values by dotted keys, see `changed_scenario`.

    Returns:
        measures by their names, see `measures`; which there are depends on the kind of the scenario.

    Raises:
        InputError: if the scenario cannot be built with the changes.
        SimulationDivergedError: if the state leaves the finite numbers.
    """
    station = kept_station(changed_scenario(scenario, changes))
    if not station.fingers:
        models = [model.file for model in station.scenario.models]
        raise InputError("sweep", "models", models, "there is no <finger> in them")
    return asdict(measure(station, run_station(station)))


TABLE, ABOUT = "sweep.csv", "sweep.json"
_DESCRIBES = ("description",)  # keys that change nothing of a run


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
            raise InputError("sweep", "--vary", key, "cannot be varied: it changes nothing of a run")
        for variation in (variations[0], variations[-1]):
            try:
                changed = changed_scenario(scenario, {**fixed, key: variation[key]})
            except InputError as error:
                raise error.inside(f"sweep: --vary {key}") from error.__cause__
            if kind_of(changed) is not kind_of(base):
                raise InputError("sweep", "--vary", key, "cannot be varied: a run of another kind has other results")


def run_sweep(
    scenario: str,
    variations: Sequence[Variation],
    out: Path,
    executor: Executor,
    *,
    fixed: Mapping[str, Any] | None = None,
    resume: bool = False,
    report: Callable[[bool], Any] = lambda fine: None,
) -> SweepTable:
    """Runs variations of a scenario, and adds a row to the table in `out` as each ends; those that fail have one too.

    Args:
        scenario: name of a shipped one, or path of a file.
        variations: each with the same keys, see `changed_scenario`.
        out: a folder, which is made.
        executor: runs them.
        fixed: changes of every run.
        resume: keep the rows that are there.
        report: called as each ends, with whether it came off.

    Raises:
        InputError: if a key cannot be varied, `out` cannot be written to, another process writes to it, or what is to
            be resumed is another sweep.
    """
    fixed = dict(fixed or {})
    check_keys(scenario, fixed, variations)
    if scenario.endswith((".yaml", ".yml")):
        scenario = str(Path(scenario).resolve())  # workers may be anywhere
    base = changed_scenario(scenario, fixed)
    names = [field.name for field in fields(kind_of(base))]
    lock_folder(out)
    table = SweepTable(out / TABLE, list(variations[0]), names)
    about = _about(scenario, dump_scenario(base), variations)
    _begin(table, out / ABOUT, about, resume)
    for number in table.rows:
        report(table.rows[number][-1] == "")

    def ended(call: Call, future: Future[dict[str, Any]]) -> None:
        number = numbers[id(call)]
        error = future.exception()
        table.add(number, variations[number], {} if error else future.result(), describe(error) if error else "")
        report(error is None)

    left = [number for number in range(len(variations)) if number not in table.rows]
    calls = [(scenario, fixed | variations[number]) for number in left]
    numbers = {id(call): number for call, number in zip(calls, left, strict=True)}
    make_calls(executor, run_variation, calls, ended)
    table.finish()
    return table


def _begin(table: SweepTable, file: Path, about: str, resume: bool) -> None:
    if resume and file.is_file():
        if read_text(file) != about:
            expected = "holds another sweep, or one of other versions; give that one, or another --out"
            raise InputError("sweep", "--resume", str(file.parent), expected)
        table.resume()
        return
    table.begin()
    with atomic_file(file) as partial:
        partial.write_text(about, encoding="utf-8")


def _about(scenario: str, base: str, variations: Sequence[Variation]) -> str:
    """What a sweep is of, as text."""
    versions = {name: version(name) for name in ("soft-gripper", "drake", "numpy")}
    parts = {"scenario": scenario, "versions": versions, "resolved": base.splitlines(), "runs": list(variations)}
    return json.dumps(parts, indent=1, default=str) + "\n"


def describe(error: BaseException) -> str:
    """An error in words, in a line."""
    known = isinstance(error, InputError | SimulationDivergedError | WorkerDiedError)
    return " ".join(f"{'' if known else type(error).__name__ + ': '}{error}".split())
