"""Self-calibration in free motion: what a wrong stiffness or chamber is compensated by."""

from collections.abc import Callable

import numpy as np
import pytest

from soft_gripper.fingers.finger import Finger
from soft_gripper.fingers.statics import resting_angles, softened
from soft_gripper.sensors.sensor_layout import SensorLayout, extension_ratios
from studies.contacts.self_calibration import (
    FreeMeasurements,
    Scale,
    calibrate_gain,
    calibrate_stiffness,
)

PRESSURES, GRAVITY = np.array([30e3, 90e3]), 6 + 7j
IN_BASE = np.array([7.0, 0.0, 6.0])


def free_motion(layout: SensorLayout) -> FreeMeasurements:
    q = resting_angles(layout.finger, PRESSURES, np.full(2, GRAVITY))
    return FreeMeasurements(layout.response.reading(extension_ratios(layout, q)), PRESSURES, IN_BASE)


def calibrated(calibrate: Callable[[SensorLayout, FreeMeasurements], Scale], true: Finger, nominal: Finger) -> Scale:
    return calibrate(SensorLayout(nominal, 2, borders=(1 / 3,)), free_motion(SensorLayout(true, 2, borders=(1 / 3,))))


@pytest.mark.parametrize("factor", [0.8, 1.1])
def test_a_wrong_stiffness_is_found(shipped_finger: Finger, factor: float) -> None:
    scale = calibrated(calibrate_stiffness, shipped_finger, softened(shipped_finger, 1 / factor))
    np.testing.assert_allclose(scale, (factor, factor, 1 / factor), rtol=1e-3)


def test_a_wrong_pressure_is_found(shipped_finger: Finger) -> None:
    """It reads 20 % too low; weight and force are as they were."""
    layout = SensorLayout(shipped_finger, 2)
    free = free_motion(layout)
    scale = calibrate_gain(layout, free._replace(pressure=0.8 * free.pressure))
    np.testing.assert_allclose(scale, (1 / 0.8, 1, 1), rtol=1e-3)


def test_every_set_of_readings_is_calibrated_by_itself(shipped_finger: Finger) -> None:
    layout = SensorLayout(shipped_finger, 2)
    free = free_motion(layout)
    gains = np.array([[0.9, 1.0, 1.1], [1.0, 1.2, 0.8]])
    scale = calibrate_gain(layout, free._replace(readings=gains[..., None, None] * free.readings, gravity=np.zeros(3)))
    assert np.shape(scale.pressure) == gains.shape
    np.testing.assert_allclose(np.asarray(scale.pressure) / gains, np.asarray(scale.pressure)[0, 1], rtol=1e-2)
