"""Whether pressures were measured against vacuum, although those of a finger are relative to the surroundings."""

import numpy as np

from soft_gripper.arrays import Array

_ATMOSPHERE = 80e3, 110e3  # Pa, of the air where people work
_OPEN = 5e3  # Pa, below which a pressure is relative to the surroundings


def seems_absolute(rest: float, pressure: Array) -> bool:
    """Whether a pressure, (T,) Pa, rests near that of the air, and is never near zero."""
    low, high = _ATMOSPHERE
    return bool(low < rest < high and np.nanmin(np.abs(pressure)) > _OPEN)
