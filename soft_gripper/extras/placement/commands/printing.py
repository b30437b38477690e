"""Tables of sensor placements, printed."""

import math
from collections.abc import Sequence
from dataclasses import astuple

from soft_gripper.commands.tables import print_table
from soft_gripper.extras.placement.place_sensors import PlacedSensors
from soft_gripper.extras.placement.placements import as_borders
from soft_gripper.extras.placement.samples import Assumptions
from soft_gripper.extras.placement.spatial_tables import VerifiedRow
from soft_gripper.extras.placement.tables import LeftOutRow, PlacementRow

_BEST = 5  # placements to list


def print_ranking(rows: Sequence[PlacementRow], equal: int) -> None:
    """Prints the best placements, equal sections and the worst placement."""
    shown = sorted({*range(min(_BEST, len(rows))), equal, len(rows) - 1})
    columns = {"rank": "d", "borders": "", "pose error [mm]": ".3f"}
    if with_contacts := not math.isnan(rows[0].force_error_n):
        columns |= {"force [N]": ".3f", "place [mm]": ".1f", "missed [%]": ".1f"}
    cells = [astuple(rows[i])[: 6 if with_contacts else 3] for i in shown]
    marks = ["equal sections" if i == equal else "" for i in shown]
    print_table(columns | {"": ""}, [(*row, mark) for row, mark in zip(cells, marks, strict=True)])


def print_designs(rows: Sequence[VerifiedRow]) -> None:
    """Prints the best sensors in space of every number, with the errors predicted and, after a slash, made."""
    names = ("tip", "twist", "force", "place")
    columns = {"sensors": "d", "kind": "", "borders": ""} | dict.fromkeys(names, ">") | {"paths": ""}
    cells = []
    for row in rows:
        predicted = row.tip_mm, row.twist_deg, row.force_n, row.place_mm
        made = row.made_tip_mm, row.made_twist_deg, row.made_force_n, row.made_place_mm
        errors = [f"{p:.2g} / {m:.2g}" for p, m in zip(predicted, made, strict=True)]
        cells.append((row.sensors, row.kind, row.borders, *errors, row.paths))
    title = "errors predicted / made in statics: tip [mm], twist [degrees], force [N] and its place [mm]"
    print_table(columns, cells, title)


def print_left_out(rows: Sequence[LeftOutRow]) -> None:
    """Prints the gain of placed sensors on runs that were held out of the placement."""
    if rows:
        columns = {"": "", "borders": "", "equal": ".3f", "placed": ".3f", "better by [%]": ".1f"}
        title = "held-out runs (placed without the run that is scored), mean pose error [mm]:"
        print_table(columns, map(astuple, rows), title)


def print_snippet(placed: PlacedSensors, assumptions: Assumptions) -> None:
    """The part of a scenario that has the best placement, and an estimator with these assumptions."""
    borders = ", ".join(map(str, as_borders(placed.placements[0], placed.finger.segments)))
    assumed = assumptions.uncertainty
    print(f"\nsensor:\n  sections: {len(placed.placements[0]) + 1}")
    print(f"  borders: [{borders}]")
    print(f"estimator:\n  type: {assumptions.estimator}\n  uncertainty:")
    print(f"    reading: {assumed.reading:.2g}\n    bend_per_pressure: {assumed.bend_per_pressure:.2g}")
