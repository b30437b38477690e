"""A finger that hangs free at several pressures, as a run would record it."""

import numpy as np
import pytest

from soft_gripper.fingers.statics import resting_angles
from soft_gripper.placement.samples import HeldFinger
from soft_gripper.sensors.sensor_layout import SensorLayout


@pytest.fixture(scope="session")
def free_finger(shipped_finger) -> HeldFinger:
    """Ten samples at rest at each of four pressures; the last two of each count."""
    pressures, gravity = np.repeat([0.0, 40e3, 80e3, 120e3], 10), 9.81 + 0j
    q = np.array([resting_angles(shipped_finger, pressure, gravity) for pressure in pressures])
    held = np.array([8, 9, 18, 19, 28, 29, 38, 39])
    layout = SensorLayout(shipped_finger, 4)
    return HeldFinger(layout, 0.01, q, held, pressures, np.full(8, gravity))
