"""Measurements of instruments beside a finger's sensors, such as a scale that it presses on: read from a table.

Positive numbers are those of the model: a force that presses on the inner side, a torque and a turn that close.
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
_LONGEST_HELD = 1.0  # s up to which what an instrument read last is used
MOST = {"force": 1e2, "torque": 1e1, "angle": 50.0}  # largest plausible values of a soft finger


@dataclass(frozen=True)
class Measured:
    """Measurements of an instrument at T samples; NaN where it did not."""

    value: Array  # (T,) N, N m or rad
    place: Array  # (T,) m along the finger, from its base
    along: tuple[float, float] | None = None  # direction of a force, x and z in B; None: across the finger


def measured_by(table: Table, described: object, length: float, prefix: str = "") -> dict[str, Measured]:
    """Measurements of the instruments of a description, by "force", "torque" and "angle".

    Args:
        table: with their columns.
        described: has the fields `measured_force` and so on; `prefix` is what comes before these in messages.
        length: of the finger, m.

    Raises:
        InputError: if a column has no numbers or implausible ones, or a place is not on the finger.
    """
    return {
        kind: _measured(table, kind, config, length, f"{prefix}measured_{kind}")
        for kind, config in instruments(described).items()
    }


def _measured(table: Table, kind: str, config: AnyInstrument, length: float, field: str) -> Measured:
    value = factor(config) * table.columns([config.column])[:, 0]
    most = float(np.nanmax(np.abs(value), initial=0.0))
    require(
        bool(np.isfinite(value).any()), table.path, f"{field}.column", config.column, "is empty, or NaN, everywhere"
    )
    expected = f"the largest is then {most:.3g} {SI[kind]}: is it right?"
    require(most < MOST[kind], table.path, f"{field}.unit", config.unit, expected)
    place = np.full(len(value), config.place)
    if config.place_column is not None:
        place = table.columns([config.place_column])[:, 0] * LENGTH[config.place_unit]
    check_places(table.path, f"{field}.place" + ("" if config.place_column is None else "_column"), place, length)
    along = config.along if isinstance(config, MeasuredForceConfig) else None
    return Measured(value, place, None if along is None else (along[0], along[1]))


def factor(config: AnyInstrument) -> float:
    """A number of an instrument as a quantity, with its sign, in N, N m or rad."""
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
    return np.where(time - time[last] <= _LONGEST_HELD, value[last], np.nan)
