"""Measured pressures and lengths of a recording."""

import numpy as np

from soft_gripper.arrays import Array
from soft_gripper.diagrams.hardware.recording_schema import RecordingConfig
from soft_gripper.diagrams.hardware.table import Table
from soft_gripper.diagrams.hardware.units import LENGTH, PRESSURE, factor
from soft_gripper.diagrams.schema.ranges import require

_MOST_PRESSURE = 1e7  # Pa, that a soft body bears
_LEAST_PRESSURE = 10.0  # Pa, that anything is driven with


def pressures_of(table: Table, config: RecordingConfig) -> Array | None:
    """Measured pressures, Pa, (T, C); None if none are described.

    Raises:
        InputError: if a column is missing, or the unit cannot be right.
    """
    if config.pressures is None:
        return None
    described = config.pressures
    unit = factor(table.path, "pressures", described.unit, PRESSURE, described.scale)
    pressures = table.columns("pressures.columns", described.columns) * unit
    most = float(np.nanmax(np.abs(pressures), initial=0.0))
    fine = most == 0 or _LEAST_PRESSURE < most < _MOST_PRESSURE
    require(fine, table.path, "pressures.unit", described.unit, f"the highest is then {most:.3g} Pa: is it right?")
    return pressures


def lengths_of(table: Table, config: RecordingConfig) -> dict[str, Array]:
    """Measured lengths, m, (T,), by wire.

    Raises:
        InputError: if a column is missing, or the unit cannot be right.
    """
    if config.lengths is None:
        return {}
    described = config.lengths
    unit = factor(table.path, "lengths", described.unit, LENGTH, described.scale)
    columns = [wire.column for wire in described.wires.values()]
    lengths = table.columns("lengths.wires", columns) * unit
    most = float(np.nanmax(np.abs(lengths), initial=0.0))
    expected = f"the longest is then {most:.3g} m, and the finger {config.length:g} m: is it right?"
    require(most < 10 * config.length, table.path, "lengths.unit or scale", described.unit, expected)
    change = float(np.nanmax(np.ptp(lengths, axis=0), initial=0.0))
    expected = f"no wire then changes by more than {change:.3g} m, and the finger is {config.length:g} m: is it right?"
    fine = change == 0 or change > 1e-3 * config.length
    require(fine, table.path, "lengths.unit or scale", described.unit, expected)
    return dict(zip(described.wires, lengths.T, strict=True))
