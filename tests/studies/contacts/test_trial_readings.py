"""What sensors read in contact trials, with errors and without."""

import numpy as np

from soft_gripper.sensors.sensor_layout import SensorLayout, extension_ratios
from soft_gripper.sensors.strain_errors import StrainErrors
from studies.contacts.contacts import Contacts, read_finger
from studies.contacts.estimates import HELD, PRESSURES, contact_readings

LAYOUT = SensorLayout(read_finger(), 2)


def contacts(number: int) -> Contacts:
    """Joint angles from which the rest does not follow; only they are read."""
    q = np.linspace(0.01, 0.1, number)[:, None] * np.linspace(0.5, 1.5, 12)
    ones = np.ones(number)
    forces = np.zeros((number, 3))
    return Contacts(LAYOUT.finger, q, 5e4 * ones, forces + 5.0, ones, forces, q, 0.08 * ones, 0 * ones, ones)


def test_ideal_sensors_read_the_shape() -> None:
    pressed = contacts(3)
    found = contact_readings(LAYOUT, pressed, None)
    np.testing.assert_allclose(found.pressed, [extension_ratios(LAYOUT, pressed.q) - 1], atol=1e-15)
    assert found.free.readings.shape == (1, 3, len(PRESSURES), LAYOUT.readings)


def test_a_mean_is_less_noisy_by_the_root_of_its_samples() -> None:
    pressed, noise = contacts(40), StrainErrors(noise=0.002)
    ideal = contact_readings(LAYOUT, pressed, None)
    for averaged in (1, HELD):
        found = contact_readings(LAYOUT, pressed, noise, seeds=4, averaged=averaged)
        for read, true in ((found.pressed, ideal.pressed), (found.free.readings, ideal.free.readings)):
            np.testing.assert_allclose((read - true).std(), 0.002 / np.sqrt(averaged), rtol=0.1)


def test_a_sensor_keeps_its_gain_from_free_motion_to_contact() -> None:
    pressed, ideal = contacts(5), contact_readings(LAYOUT, contacts(5), None)
    found = contact_readings(LAYOUT, pressed, StrainErrors(gain_error=0.1), seeds=3, averaged=1)
    gains = found.pressed / ideal.pressed
    assert gains.std() > 0.05
    np.testing.assert_allclose(found.free.readings / ideal.free.readings, np.repeat(gains[:, :, None], 4, axis=2))
