"""Placements as rows of tables."""

from dataclasses import dataclass

import numpy as np

from soft_gripper.fingers.finger import Finger
from soft_gripper.placement.place_sensors import PlacedSensors
from soft_gripper.placement.placements import Placement, as_borders


@dataclass(frozen=True)
class PlacementRow:
    """One placement; NaN where no contacts were given."""

    rank: int
    borders: str  # shares of the length
    pose_error_mm: float  # the mean over all runs, by which it is ranked
    force_error_n: float
    place_error_mm: float
    missed_percent: float


@dataclass(frozen=True)
class RunRow:
    """One placement in one run."""

    rank: int
    borders: str
    run: str
    pose_error_mm: float


@dataclass(frozen=True)
class LeftOutRow:
    """A run, with equal sections and with a placement that was found without it."""

    run: str
    borders: str
    equal_mm: float
    placed_mm: float
    gain_percent: float  # positive where the placement is better


def placement_rows(placed: PlacedSensors) -> list[PlacementRow]:
    """A row for every placement, the best first."""
    rows = []
    for i, (placement, error) in enumerate(zip(placed.placements, placed.mean_pose_errors, strict=True)):
        contact = (np.nan,) * 3
        if placed.contacts is not None:
            found = placed.contacts[i]
            contact = found.force, 1e3 * found.place, 100 * found.missed
        rows.append(PlacementRow(i + 1, describe(placement, placed.finger), 1e3 * float(error), *contact))
    return rows


def run_rows(placed: PlacedSensors) -> list[RunRow]:
    """A row for every placement and run, in this order."""
    return [
        RunRow(i + 1, describe(placement, placed.finger), run, 1e3 * float(error))
        for i, (placement, errors) in enumerate(zip(placed.placements, placed.pose_errors, strict=True))
        for run, error in zip(placed.runs, errors, strict=True)
    ]


def left_out_rows(placed: PlacedSensors) -> list[LeftOutRow]:
    """A row for every run that was left out."""
    return [
        LeftOutRow(
            row.run,
            describe(row.placement, placed.finger),
            1e3 * row.equal,
            1e3 * row.placed,
            100 * (1 - row.placed / row.equal),
        )
        for row in placed.left_out
    ]


def describe(placement: Placement, finger: Finger) -> str:
    """Borders as shares of the length, in words of a table."""
    return " ".join(f"{border:.4g}" for border in as_borders(placement, finger.segments)) or "none"
