"""Reads instruments beside a finger's sensors, such as a scale under it, from a table: (T,) N, N m or rad by kind.

Positive are a force on the inner side, and a torque and an angle that close. A kind is a field of the description, a
table of units (`UNITS`), its unit (`SI`) and its largest plausible value (`MOST`).
"""

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from soft_gripper.arrays import Array
from soft_gripper.errors import InputError
from soft_gripper.extras.hardware.recording_schema import (
    ANGLE,
    FORCE,
    LENGTH,
    TORQUE,
    AnyInstrument,
    MeasuredForceConfig,
    instruments,
)
from soft_gripper.extras.hardware.table import Table
from soft_gripper.files.document import require

UNITS = FORCE | TORQUE | ANGLE
SI = {"force": "N", "torque": "N m", "angle": "rad"}
_MAX_AGE = 1.0  # s, of the last reading of an instrument
MOST = {"force": 1e2, "torque": 1e1, "angle": 50.0}  # largest plausible values of a soft finger


@dataclass(frozen=True)
class Measured:
    """Measurements of an instrument at T samples; NaN where it did not."""

    value: Array  # (T,) N, N m or rad
    place: Array  # (T,) m along the finger, from its base
    along: tuple[float, float] | None = None  # direction of a force, x and z in B; None: across the finger


def read_instruments(table: Table, described: object, length: float, prefix: str = "") -> dict[str, Measured]:
    """Measurements of the instruments of a description, by "force", "torque" and "angle".

    Args:
        table: with their columns.
        described: has the fields `measured_force` and so on; messages put `prefix` before these.
        length: of the finger, m.

    Raises:
        InputError: if a column has no numbers or implausible ones, or a place is not on the finger.
    """
    return {
        kind: _read_instrument(table, kind, config, length, f"{prefix}measured_{kind}")
        for kind, config in instruments(described).items()
    }


def _read_instrument(table: Table, kind: str, config: AnyInstrument, length: float, field: str) -> Measured:
    value = factor(config) * table.columns([config.column])[:, 0]
    largest = float(np.nanmax(np.abs(value), initial=0.0))
    require(
        bool(np.isfinite(value).any()), table.path, f"{field}.column", config.column, "is empty, or NaN, everywhere"
    )
    expected = f"the largest is then {largest:.3g} {SI[kind]}: is it right?"
    require(largest < MOST[kind], table.path, f"{field}.unit", config.unit, expected)
    place = np.full(len(value), config.place)
    if config.place_column is not None:
        place = table.columns([config.place_column])[:, 0] * LENGTH[config.place_unit]
    check_places(table.path, f"{field}.place" + ("" if config.place_column is None else "_column"), place, length)
    direction = config.along if isinstance(config, MeasuredForceConfig) else None
    return Measured(value, place, None if direction is None else (direction[0], direction[1]))


def factor(config: AnyInstrument) -> float:
    """Factor of an instrument's numbers, with its sign: N, N m or rad per unit."""
    return config.sign * UNITS[config.unit]


def check_places(path: Path, field: str, place: Array, length: float) -> None:
    """Checks places along a finger, m.

    Raises:
        InputError: if one is not on it.
    """
    outside = ~((place >= 0) & (place <= length)) & np.isfinite(place)
    if outside.any():
        worst = float(place[outside][0])
        raise InputError(path, field, round(worst, 6), f"must be on the finger: 0 to {length:g} m from its base")


def latest(time: Array, value: Array) -> Array:
    """The last finite value up to each sample, unless it is too old, (T,)."""
    last = np.maximum.accumulate(np.where(np.isfinite(value), np.arange(len(value)), 0))
    return np.where(time - time[last] <= _MAX_AGE, value[last], np.nan)
