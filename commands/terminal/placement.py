"""What is printed of placements of sensors."""

import math
from collections.abc import Sequence

from soft_gripper.evaluation.placement.assumptions import Assumptions
from soft_gripper.evaluation.placement.place_sensors import PlacedSensors
from soft_gripper.evaluation.placement.placements import as_borders
from soft_gripper.evaluation.placement.tables import LeftOutRow, PlacementRow

_BEST = 5  # placements that are listed


def print_ranking(rows: Sequence[PlacementRow], equal: int) -> None:
    """The best few, equal sections and the worst."""
    shown = sorted({*range(min(_BEST, len(rows))), equal, len(rows) - 1})
    with_contacts = not math.isnan(rows[0].force_error_n)
    width = max(len(rows[i].borders) for i in shown)
    heading = "   force [N]   place [mm]   missed" if with_contacts else ""
    print(f"\n{'rank':>4}  {'borders':<{width}}   pose error [mm]{heading}")
    for i in shown:
        row = rows[i]
        contact = f"{row.force_error_n:>12.3f} {row.place_error_mm:>12.1f} {row.missed_percent:>6.1f} %"
        line = f"{row.rank:>4}  {row.borders:<{width}} {row.pose_error_mm:>17.3f}{contact if with_contacts else ''}"
        print(line + ("   equal sections" if i == equal else ""))


def print_left_out(rows: Sequence[LeftOutRow]) -> None:
    """What placed sensors gain where they were not placed."""
    if not rows:
        return
    width, name = max(len(row.borders) for row in rows), max(len(row.run) for row in rows)
    print("\nplaced without the run in which they are tried, mean pose error [mm]:")
    print(f"{'':<{name}}  {'borders':<{width}}   equal   placed   better by")
    for row in rows:
        errors = f"{row.equal_mm:>7.3f} {row.placed_mm:>8.3f} {row.gain_percent:>9.1f} %"
        print(f"{row.run:<{name}}  {row.borders:<{width}} {errors}")


def print_snippet(placed: PlacedSensors, assumptions: Assumptions) -> None:
    """The part of a scenario that has the best placement, and an estimator that believes what was assumed."""
    borders = ", ".join(map(str, as_borders(placed.placements[0], placed.finger.segments)))
    believed = assumptions.uncertainty
    print(f"\nsensor:\n  sections: {len(placed.placements[0]) + 1}")
    print(f"  borders: [{borders}]")
    print(f"estimator:\n  type: {assumptions.estimator}\n  uncertainty:")
    print(f"    reading: {believed.reading:.2g}\n    bend_per_pressure: {believed.bend_per_pressure:.2g}")
