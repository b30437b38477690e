"""soft-gripper place-sensors: finds the best sensors of a finger, and boundaries between their sections."""

import argparse
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path

from soft_gripper.commands.console import Console
from soft_gripper.diagrams.simulation import run_station
from soft_gripper.diagrams.station import make_private_station
from soft_gripper.diagrams.station_parts import Station
from soft_gripper.errors import InputError
from soft_gripper.estimators.named_estimators import find_estimator
from soft_gripper.evaluation.paper.scenario_run import SCENARIOS
from soft_gripper.extras.hardware.recorded_run import RecordedRun, load_run
from soft_gripper.extras.placement.catalogue import leaves_its_plane
from soft_gripper.extras.placement.errors import Assumptions
from soft_gripper.extras.placement.place_sensors import place_sensors
from soft_gripper.extras.placement.placed_report import (
    MEAN,
    design_row,
    design_rows,
    made_rows,
    placement_figure,
    scenario_part,
)
from soft_gripper.extras.placement.samples import Samples, held_fingers, single_contacts
from soft_gripper.files.output import atomic_file, lock_folder
from soft_gripper.files.row_table import print_rows, write_csv
from soft_gripper.pictures.style import save_figure
from soft_gripper.scenario.scenario_file import load_scenario
from soft_gripper.scenario.schema import Scenario

TABLE, MADE_TABLE, FIGURE = "designs.csv", "made.csv", "placement"
_WHERE = "place-sensors"


def run(options: argparse.Namespace) -> None:
    """Runs the command."""
    find_estimator(options.estimator, field="--estimator")
    assumptions, out = Assumptions(options.sensors, options.nominal_error, options.seed), lock_folder(options.out)
    try:
        samples = list(_samples(options))
        with options.console.counter(None, "designs") as bar:
            placed = place_sensors(options.count, samples, assumptions, options.estimator, bar.update)
    except KeyboardInterrupt:
        print("\nnothing is written until the last design")
        raise
    made = made_rows(placed)
    write_csv(out / TABLE, design_rows(placed))
    save_figure(placement_figure(placed), out / FIGURE)
    parts = {kind: scenario_part(placed, kind, samples[0].sensor, assumptions) for kind in placed.kinds}
    for kind, part in parts.items():
        with atomic_file(out / f"{kind}.yaml") as partial:
            partial.write_text(part, encoding="utf-8")
    best = [design_row(one.design, one.predicted) for one in placed.best]
    print_rows(best, "the best designs, as predicted; pose: joints and tip", leave=("score",))
    title = f"errors of {options.estimator} in the runs (root mean squares), of the best designs and of equal sections"
    print_rows([row for row in made if row.run == MEAN], title, leave=("run",))
    print("\n" + parts[min(best, key=lambda row: row.score).kind], end="")
    options.console.table("designs", best)
    options.console.table("made", made, out / MADE_TABLE)
    files = TABLE, MADE_TABLE, f"{FIGURE}.png", f"{FIGURE}.svg", *(f"{kind}.yaml" for kind in placed.kinds)
    options.console.wrote(*(out / file for file in files))


def _samples(options: argparse.Namespace) -> Iterator[Samples]:
    """Fingers of every run, loaded or simulated, and single contacts."""
    runs: Mapping[str, Station | RecordedRun]
    if options.recordings is not None:
        runs = {name: load_run(file) for name, file in _named(options.recordings).items()}
    else:
        runs = {name: _station(name) for name in options.scenarios or SCENARIOS}
    sensor = next(iter(runs.values())).scenario.sensor
    contacts = [] if options.contacts is None else [single_contacts(options.contacts, sensor)]
    check_runs(options.count, runs, contacts)
    for name, found in runs.items():
        yield from held_fingers(name, _simulate(name, found, options.console) if isinstance(found, Station) else found)
    yield from contacts


def check_runs(count: int, runs: Mapping[str, Station | RecordedRun], contacts: Sequence[Samples] = ()) -> None:
    """Checks the runs by which sensors are placed, before they are simulated.

    Raises:
        InputError: unless all runs, by name, have pressure steps, and all their fingers, and those of contacts, have
            equally many segments, at least `count` of them in the plane, and yield alike.
    """
    for name, each in runs.items():
        _check_has_held_steps(name, each.scenario)
    fingers = [*(one.finger for one in contacts), *(each.finger for one in runs.values() for each in one.fingers)]
    for field in ("segments", "yields"):
        found = sorted({getattr(finger, field) for finger in fingers})
        if len(found) > 1:
            raise InputError(_WHERE, field, found, "choose runs and contacts whose fingers are alike in this")
    if count > fingers[0].segments and not leaves_its_plane(fingers[0]):
        expected = f"give 1 to {fingers[0].segments}, the number of segments of a finger"
        raise InputError(_WHERE, "count", count, expected)


def _check_has_held_steps(name: str, scenario: Scenario) -> None:
    others = {"task": scenario.task, "control.set_points": scenario.control.set_points, "external": scenario.external}
    for field, value in others.items():
        if value:
            raise InputError(name, field, "given", "sensors are placed by scenarios with steps of pressure alone")


def _named(files: Sequence[Path]) -> dict[str, Path]:
    """Recordings by short names, taken from their folders as `soft-gripper run` names them; by paths if names clash."""
    short = {file.resolve().parent.name if file.name == "recording.nc" else file.stem: file for file in files}
    return short if len(short) == len(files) else {str(file): file for file in files}


def _station(name: str) -> Station:
    try:
        station = make_private_station(load_scenario(name))
    except InputError as error:
        raise error.inside(name) from error.__cause__
    if not station.fingers:
        raise InputError(name, "models", [m.file for m in station.scenario.models], "there is no <finger> in them")
    return station


def _simulate(name: str, station: Station, console: Console) -> RecordedRun:
    with console.progress(name, station.scenario.duration) as progress:
        return RecordedRun(run_station(station, progress=progress), station.scenario, station.fingers)
