"""Detects pressures that were measured against vacuum: those of a finger are relative to the surroundings."""

import numpy as np

from soft_gripper.arrays import Array

_AIR_PRESSURES = 80e3, 110e3  # Pa, range where people work
_MIN_ABSOLUTE_PRESSURE = 5e3  # Pa; a lower one is relative to the surroundings


def seems_absolute(rest_pressure: float, pressure: Array) -> bool:
    """Whether a pressure, (T,) Pa, rests near that of the air, and is never near zero."""
    low, high = _AIR_PRESSURES
    return bool(low < rest_pressure < high and np.nanmin(np.abs(pressure)) > _MIN_ABSOLUTE_PRESSURE)
