"""Reads instruments beside a finger's sensors, such as a scale under it, from a table: (T,) N, N m or rad by kind.

Positive are a force on the inner side, and a torque and an angle that close. A kind is a field of the description, a
table of units (`UNITS`), its unit (`SI`) and its largest plausible value (`MOST`).
"""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass

import numpy as np

from soft_gripper.arrays import Array
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
from soft_gripper.quantity import Violation

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


def read_instruments(table: Table, described: object) -> dict[str, Measured]:
    """Measurements by "force", "torque" and "angle", of a description with the fields `measured_force` and so on."""
    measured = {}
    for kind, config in instruments(described).items():
        value = factor(config) * table.columns([config.column])[:, 0]
        place = np.full(len(value), config.place)
        if config.place_column is not None:
            place = table.columns([config.place_column])[:, 0] * LENGTH[config.place_unit]
        direction = config.along if isinstance(config, MeasuredForceConfig) else None
        measured[kind] = Measured(value, place, None if direction is None else (direction[0], direction[1]))
    return measured


def instrument_violations(
    measured: Mapping[str, Measured], described: object, length: float, prefix: str = ""
) -> Iterator[Violation]:
    """Yields violations in measurements along a finger of a length, m; field names begin with a prefix."""
    for kind, instrument in measured.items():
        field, config = f"{prefix}measured_{kind}", getattr(described, f"measured_{kind}")
        largest_value = float(np.nanmax(np.abs(instrument.value), initial=0.0))
        if not np.isfinite(instrument.value).any():
            yield f"{field}.column", config.column, "is empty, or NaN, everywhere"
        if not largest_value < MOST[kind]:
            yield f"{field}.unit", config.unit, f"the largest is then {largest_value:.3g} {SI[kind]}: is it right?"
        place_field = f"{field}.place" if config.place_column is None else f"{field}.place_column"
        yield from place_violations(place_field, instrument.place, length)


def factor(config: AnyInstrument) -> float:
    """Factor of an instrument's numbers, with its sign: N, N m or rad per unit."""
    return config.sign * UNITS[config.unit]


def place_violations(field: str, place: Array, length: float) -> Iterator[Violation]:
    """Yields places, m, that are not on a finger of a length, m."""
    for wrong_place in place[~((place >= 0) & (place <= length)) & np.isfinite(place)]:
        yield field, round(float(wrong_place), 6), f"must be on the finger: 0 to {length:g} m from its base"


def latest(time: Array, value: Array) -> Array:
    """Last finite value up to each sample, (T,); NaN if it is too old."""
    last_rows = np.maximum.accumulate(np.where(np.isfinite(value), np.arange(len(value)), 0))
    return np.where(time - time[last_rows] <= _MAX_AGE, value[last_rows], np.nan)
