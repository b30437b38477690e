"""soft-gripper place-sensors: finds the best sensors of a finger, or the best boundaries between its sections."""

import argparse
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from soft_gripper.commands.console import Console
from soft_gripper.diagrams.simulation import run_station
from soft_gripper.diagrams.station import make_private_station
from soft_gripper.diagrams.station_parts import Station
from soft_gripper.errors import InputError
from soft_gripper.evaluation.paper.scenario_run import SCENARIOS
from soft_gripper.extras.hardware.recorded_run import RecordedRun, load_run
from soft_gripper.extras.placement.commands import sensors_in_space
from soft_gripper.extras.placement.commands.printing import print_left_out, print_ranking, print_snippet
from soft_gripper.extras.placement.place_sensors import PlacedSensors, place_sensors
from soft_gripper.extras.placement.samples import Assumptions, HeldFinger, held_fingers
from soft_gripper.extras.placement.spatial_tasks import leaves_its_plane
from soft_gripper.extras.placement.tables import (
    check_contacts,
    check_runs,
    left_out_rows,
    placement_figure,
    placement_rows,
    run_rows,
)
from soft_gripper.extras.studies.contacts.contacts import load_contacts
from soft_gripper.files.csv_table import write_csv
from soft_gripper.files.output import lock_folder
from soft_gripper.fingers.finger import Finger
from soft_gripper.pictures.style import save_figure
from soft_gripper.scenario.scenario_file import load_scenario
from soft_gripper.scenario.schema import SensorConfig, StrainErrorsConfig
from soft_gripper.scenario.sensor_presets import strain_errors

TABLE, RUN_TABLE, LEFT_OUT_TABLE, FIGURE = "placements.csv", "runs.csv", "left_out.csv", "placement"


def run(options: argparse.Namespace) -> None:
    """Runs the command, in the plane or, for fingers that leave it, in space."""
    stations = {name: _station(name) for name in options.scenarios or ()}
    if any(leaves_its_plane(finger.finger) for station in stations.values() for finger in station.fingers):
        sensors_in_space.run(options, stations)
    else:
        _run_in_plane(options, stations)


def _run_in_plane(options: argparse.Namespace, stations: Mapping[str, Station]) -> None:
    assumptions = _assumptions(options)
    contacts = None if options.contacts is None else load_contacts(options.contacts)
    if contacts is not None:
        check_contacts(contacts, assumptions)
    out = lock_folder(options.out)
    try:
        runs = _runs(options, stations, [] if contacts is None else [contacts.finger])
        with options.console.counter(None, "placements") as bar:
            placed = place_sensors(options.count, runs, assumptions, contacts, bar.update)
    except KeyboardInterrupt:
        print("\nnothing is written until the last placement")
        raise
    files = _write(placed, out)
    ranking = placement_rows(placed)
    print_ranking(ranking, placed.equal)
    print_left_out(left_out_rows(placed))
    print_snippet(placed, assumptions)
    options.console.table("placements", ranking)
    options.console.wrote(*(out / file for file in files))


def _assumptions(options: argparse.Namespace) -> Assumptions:
    errors = None if options.sensors is None else StrainErrorsConfig(preset=options.sensors)
    return Assumptions(
        options.estimator, strain_errors(SensorConfig(errors=errors)), options.nominal_error, options.seed
    )


def _runs(
    options: argparse.Namespace, stations: Mapping[str, Station], others: Sequence[Finger]
) -> dict[str, list[HeldFinger]]:
    """The fingers of every run, loaded or simulated; all must have as many segments as `others`."""
    if options.recordings is not None:
        runs = {name: load_run(file) for name, file in _named(options.recordings).items()}
        check_runs(options.count, runs, others)
    else:
        stations = stations or {name: _station(name) for name in SCENARIOS}
        check_runs(options.count, stations, others)
        runs = {name: _simulate(name, station, options.console) for name, station in stations.items()}
    return {name: held_fingers(name, run) for name, run in runs.items()}


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


def _write(placed: PlacedSensors, out: Path) -> list[str]:
    """Writes tables and figure; returns the files. A single run has no cross-validation, as none can be left out."""
    tables: dict[str, Sequence[Any]] = {
        TABLE: placement_rows(placed),
        RUN_TABLE: run_rows(placed),
        LEFT_OUT_TABLE: left_out_rows(placed),
    }
    written = {file: rows for file, rows in tables.items() if rows}
    for file, rows in written.items():
        write_csv(out / file, rows)
    save_figure(placement_figure(placed), out / FIGURE)
    return [*written, f"{FIGURE}.png", f"{FIGURE}.svg"]
