"""Contact trials: where pegs stand, what sensors read, and errors of estimates."""

import numpy as np
import pytest

from soft_gripper.estimators.estimate import ContactForce
from soft_gripper.sensors.sensor_layout import SensorLayout, extension_ratios
from soft_gripper.sensors.strain_errors import StrainErrors
from studies.contacts.contacts import Contacts, read_finger
from studies.contacts.estimates import HELD, PRESSURES, compare, contact_readings
from studies.contacts.trials import error_rows
from studies.estimator_setup import EstimatorSetup

TRUE = Contacts(
    read_finger(),
    *(np.zeros((4, 12)), np.zeros(4), np.zeros((4, 3))),
    normal_force=np.array([1.0, 2.0, 1.0, 4.0]),
    force=np.zeros((4, 3)),
    torque=np.zeros((4, 12)),
    arc_length=np.full(4, 0.06),
    side=np.pi * np.array([0, 1, 1, 0]),
    friction=np.full(4, 0.45),
)


CONTACT = ContactForce(
    force=np.array([[1.1, -1.9, 0.0, np.nan], [1.0, -2.0, -1.0, 4.0]]),
    arc_length=np.array([[0.066, 0.06, np.nan, np.nan], [0.06, 0.06, 0.06, 0.072]]),
    force_std=np.array([[0.04, 0.06, 0.1, np.nan], [0.1] * 4]),
    arc_length_std=np.array([[0.003, 0.0, np.nan, np.nan], [0.005] * 4]),
)
FOUND = compare(CONTACT, TRUE)
SETUP = EstimatorSetup(3, borders=(0.25, 0.5), stiffness=0.1)


def test_a_row_for_both_and_for_each_side() -> None:
    both, inner, outer = error_rows("contact", SETUP, FOUND, TRUE)
    assert [row.side for row in (both, inner, outer)] == ["both", "inner", "outer"]
    assert (both.contacts, inner.contacts, outer.contacts) == (4, 2, 2)
    assert (both.sections, both.borders, both.nominal, both.sensors) == (3, "30 60", "youngs_modulus +10 %", "ideal")
    assert both.found_percent == inner.found_percent == outer.found_percent == 75
    assert inner.force_90_percent == pytest.approx(np.percentile([10, 0, 0], 90))
    assert outer.force_median_percent == pytest.approx(0)
    assert both.place_90_percent == pytest.approx(np.percentile([5, 0, 0, 0, 0, 10], 90))
    assert inner.force_within_2_std_percent == pytest.approx(100 * 2 / 3)  # the error of 0.1 is 2.5 of 0.04
    assert inner.place_within_2_std_percent == pytest.approx(100 * 1 / 3)
    assert outer.force_within_2_std_percent == outer.place_within_2_std_percent == 100


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
