"""A finger that hangs free at several pressures, as a run would record it; and one in space, free and pushed."""

from dataclasses import replace

import numpy as np
import pytest

from soft_gripper.extras.placement.pushed_finger import PushedFinger
from soft_gripper.extras.placement.samples import HeldFinger
from soft_gripper.extras.placement.spatial_tasks import Tasks, tasks
from soft_gripper.fingers.finger import Finger
from soft_gripper.fingers.statics import resting_angles
from soft_gripper.sensors.sensor_layout import SensorLayout


@pytest.fixture(scope="session")
def free_finger(shipped_finger) -> HeldFinger:
    """Ten samples at rest at each of four pressures; the last two of each count."""
    pressures, gravity = np.repeat([0.0, 40e3, 80e3, 120e3], 10), 9.81 + 0j
    q = np.array([resting_angles(shipped_finger, pressure, gravity) for pressure in pressures])
    held = np.array([8, 9, 18, 19, 28, 29, 38, 39])
    layout = SensorLayout(shipped_finger, 4)
    return HeldFinger(layout, 0.01, q, held, pressures, np.full(8, gravity))


@pytest.fixture(scope="session")
def spatial_finger(shipped_finger) -> Finger:
    return replace(shipped_finger, yields=("bending", "sideways", "twist"))


@pytest.fixture(scope="session")
def hanging(spatial_finger) -> PushedFinger:
    return PushedFinger(spatial_finger, np.array([0.0, 0.0, 9.81]))


@pytest.fixture(scope="session")
def spatial_tasks(hanging) -> Tasks:
    """Free and pushed, at two pressures."""
    return tasks(hanging, np.array([[0.0], [80e3]]))
