"""One run of a sweep: a dict of changes -> a dict of results."""

from collections.abc import Mapping
from dataclasses import asdict
from typing import Any

from soft_gripper.diagrams.kept_stations import kept_station
from soft_gripper.diagrams.schema.scenario_file import changed_scenario
from soft_gripper.diagrams.simulation import run_station
from soft_gripper.errors import InputError
from soft_gripper.evaluation.sweep.measures import measure


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
