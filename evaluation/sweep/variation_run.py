"""One run of a sweep: a dict of changes -> a dict of results."""

from collections.abc import Mapping
from dataclasses import asdict, replace
from typing import Any

from soft_gripper.diagrams.schema.scenario_file import changed_scenario
from soft_gripper.diagrams.simulation import run_station
from soft_gripper.diagrams.station import make_station
from soft_gripper.diagrams.station_parts import Station
from soft_gripper.errors import InputError
from soft_gripper.evaluation.sweep.measures import measure

_OF_A_RUN = ("sensor.seed", "simulator_config.")  # keys of what a Simulator and its context are given
_last: tuple[object, Station] | None = None  # station of this process, and what it was built of


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
    return _measured(make_station(changed_scenario(scenario, changes)))


def run_again(scenario: str, changes: Mapping[str, Any]) -> dict[str, Any]:
    """The same for a process that makes many runs: the last station is kept, and used if nothing in it is changed."""
    global _last
    changed = changed_scenario(scenario, changes)
    built_of = scenario, {key: value for key, value in changes.items() if not key.startswith(_OF_A_RUN)}
    if _last is None or _last[0] != built_of:
        _last = built_of, make_station(changed)
    station = _last[1]
    return _measured(replace(station, parts=replace(station.parts, scenario=changed)))


def _measured(station: Station) -> dict[str, Any]:
    if not station.fingers:
        models = [model.file for model in station.scenario.models]
        raise InputError("sweep", "models", models, "there is no <finger> in them")
    return asdict(measure(station, run_station(station)))
