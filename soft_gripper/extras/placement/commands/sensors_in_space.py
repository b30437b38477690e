"""place-sensors for fingers that leave their plane: which kinds of sensors, how many, and along which paths."""

import argparse
from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from soft_gripper.arrays import Array
from soft_gripper.diagrams.station_parts import Station
from soft_gripper.diagrams.wiring.drive import steps_of
from soft_gripper.errors import InputError
from soft_gripper.extras.placement.catalogue import KINDS
from soft_gripper.extras.placement.commands.printing import print_designs
from soft_gripper.extras.placement.place_in_space import SpatialAssumptions, place_in_space
from soft_gripper.extras.placement.pushed_finger import PushedFinger
from soft_gripper.extras.placement.spatial_tables import design_rows, pareto_figure, scenario_part, verified_rows
from soft_gripper.extras.placement.spatial_tasks import Tasks, tasks
from soft_gripper.extras.placement.tables import check_has_held_steps
from soft_gripper.files.csv_table import write_csv
from soft_gripper.files.output import atomic_file, lock_folder
from soft_gripper.fingers.finger import Finger
from soft_gripper.fingers.plant_finger import PlantFinger
from soft_gripper.pictures.style import save_figure

TABLE, BEST, FIGURE = "designs.csv", "best.csv", "pareto"
_WHERE = "place-sensors"


def run(options: argparse.Namespace, stations: Mapping[str, Station]) -> None:
    """Places sensors on the finger of the scenarios."""
    _check(options, stations)
    assumptions = SpatialAssumptions(options.sensors, options.nominal_error, options.seed)
    out, tasks_of_finger = lock_folder(options.out), _tasks(stations)
    try:
        with options.console.counter(None, "designs") as bar:
            placed = place_in_space(options.count, tasks_of_finger, assumptions, bar.update)
    except KeyboardInterrupt:
        print("\nnothing is written until the last design")
        raise
    rows, parts = verified_rows(placed), {kind: scenario_part(placed, kind, assumptions) for kind in KINDS}
    write_csv(out / TABLE, design_rows(placed))
    write_csv(out / BEST, rows)
    save_figure(pareto_figure(placed), out / FIGURE)
    for kind, part in parts.items():
        with atomic_file(out / f"{kind}.yaml") as partial:
            partial.write_text(part, encoding="utf-8")
    print_designs(rows)
    print("\n" + parts[min(KINDS, key=lambda kind: placed.best_of(kind).predicted.score)], end="")
    options.console.table("designs", rows)
    files = TABLE, BEST, f"{FIGURE}.png", f"{FIGURE}.svg", *(f"{kind}.yaml" for kind in KINDS)
    options.console.wrote(*(out / file for file in files))


def _check(options: argparse.Namespace, stations: Mapping[str, Station]) -> None:
    """Raises an InputError for what is of the plane alone, and for fingers that statics here do not know."""
    if options.estimator != "gaussian":
        expected = "in space sensors are placed for gaussian; leave it out"
        raise InputError(_WHERE, "--estimator", options.estimator, expected)
    if options.contacts is not None:
        raise InputError(_WHERE, "--contacts", str(options.contacts), "are contacts in the plane; leave it out")
    for name, station in stations.items():
        check_has_held_steps(name, station.scenario)
        for finger in station.fingers:
            _check_finger(name, finger.finger)
    shapes = {replace(finger.finger, name="finger") for station in stations.values() for finger in station.fingers}
    if len(shapes) > 1:
        expected = "the fingers differ: sensors in space are placed on one kind of finger at a time"
        raise InputError(_WHERE, "--scenarios", ",".join(stations), expected)


def _check_finger(scenario: str, finger: Finger) -> None:
    refused = {"tendons": finger.tendons, "elastic_law": finger.elastic_law}
    for field, value in refused.items():
        if value:
            expected = "sensors in space are placed on fingers that chambers drive and linear springs hold"
            raise InputError(scenario, f"{finger.name}.{field}", "given", expected)
    if finger.chambers and not finger.chamber_paths.are_parallel:
        expected = "sensors in space are placed on fingers with straight chambers"
        raise InputError(scenario, f"{finger.name}.chambers", "slanted", expected)


def _tasks(stations: Mapping[str, Station]) -> Tasks:
    """At all pressures of the scenarios' steps, in the gravity of the first finger."""
    first = next(iter(stations.values()))
    finger = first.fingers[0]
    gravity = finger.X_WB.rotation().inverse() @ first.scenario.gravity
    levels = [_pressures(station, each) for station in stations.values() for each in station.fingers]
    return tasks(PushedFinger(finger.finger, gravity), np.unique(np.concatenate(levels), axis=0))


def _pressures(station: Station, finger: PlantFinger) -> Array:
    """Pressures of all chambers at every step, (steps, C) Pa."""
    chambers = [name for names in finger.finger.chamber_axis.values() for name in names]
    return steps_of("pressure", station.scenario.pressure.steps, finger.name, chambers)
