"""Contact trials: where pegs stand, what sensors read, and errors of estimates."""

import numpy as np
import pytest

from soft_gripper.estimators.estimate import ContactForce
from soft_gripper.fingers.finger import Finger
from soft_gripper.fingers.kinematics import forward_kinematics
from soft_gripper.fingers.statics import resting_angles
from soft_gripper.sensors.sensor_layout import SensorLayout, extension_ratios
from soft_gripper.sensors.strain_errors import StrainErrors
from studies.contacts.contacts import Contacts, read_finger
from studies.contacts.estimates import HELD, PRESSURES, compare, contact_readings
from studies.contacts.peg import SIDES, peg_center
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


@pytest.mark.parametrize("side", SIDES)
@pytest.mark.parametrize("s", [0.048, 0.0771, 0.1188])
def test_a_peg_touches_the_face_of_one_link(shipped_finger: Finger, side: str, s: float) -> None:
    """Seen from each link, at its place along the axis, it is as far off as its radius and the face."""
    radius, sign = 0.006, SIDES[side]
    q = resting_angles(shipped_finger, 50e3, 0j)
    center = peg_center(shipped_finger, q, s, side, radius)
    chain, ends = forward_kinematics(q, shipped_finger.segment_length), shipped_finger.link_ends
    origins = np.concatenate([[0], chain.joints])
    seen = (center - origins) * np.exp(-1j * chain.headings)
    link = int(np.flatnonzero((ends[:-1] <= s) & (s < ends[1:]))[0])
    section = shipped_finger.section((ends[link] + ends[link + 1]) / 2)
    face = float(section.inner_face if side == "inner" else section.outer_face)
    assert seen[link].real == pytest.approx(s - ends[link], abs=1e-12)
    assert seen[link].imag == pytest.approx(face + sign * radius, abs=1e-12)
