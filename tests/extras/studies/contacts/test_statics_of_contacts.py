"""Contacts in balance with friction of a known share: their torque, and what friction makes of the estimates."""

import numpy as np

from soft_gripper.extras.studies.contacts.dataset import read_finger
from soft_gripper.extras.studies.contacts.estimates import Condition, estimate_contacts, ideal_readings
from soft_gripper.extras.studies.contacts.statics import rubbing_contacts, rubbing_torque
from soft_gripper.extras.studies.contacts.trials import contact_errors
from soft_gripper.fingers.kinematics import gravity_torque
from soft_gripper.fingers.statics import relaxed_law
from soft_gripper.sensors.sensor_layout import SensorLayout


def median_errors(contacts, sections):
    layout = SensorLayout(contacts.finger, sections)
    errors = contact_errors(
        estimate_contacts("contact", layout, Condition(), ideal_readings(layout, contacts), contacts), contacts
    )
    return np.nanmedian(errors.force), np.nanmedian(errors.place)


def test_torque_of_a_force_on_a_straight_finger_by_hand():
    finger = read_finger()
    place, offset = np.array([0.0725, 0.0725]), np.array([-0.019, 2e-4])
    torque = rubbing_torque(
        finger, np.zeros((2, finger.segments)), place, offset, np.array([-2.0, 2.0]), np.array([0.4, 0.0])
    )
    lever = np.maximum(0.0725 - finger.joint_arc_lengths, 0)
    rubbing = np.where(lever > 0, 0.4 * 2.0 * 0.019, 0)  # toward the tip, on the outer side: it closes the finger
    np.testing.assert_allclose(torque, [2.0 * lever + rubbing, -2.0 * lever], atol=1e-12)


def test_contacts_are_in_balance():
    contacts = rubbing_contacts(20, 0.45, 1.0, 2)
    finger = contacts.finger
    weight = gravity_torque(finger, contacts.q, contacts.gravity[:, None])
    elastic = relaxed_law(finger).inverse()(finger.pressure_torque(contacts.pressure) + weight + contacts.torque)
    np.testing.assert_allclose(contacts.q, elastic, atol=1e-8)
    np.testing.assert_allclose(contacts.total, np.abs(contacts.force) * np.hypot(1, 0.45))
    assert {*contacts.side} == {"inner", "outer"}
    assert (np.sign(contacts.force) == np.where(contacts.side == "inner", 1, -1)).all()


def test_friction_spoils_what_is_exact_without_it_where_it_is_not_seen():
    """Two sections do not tell friction from another place; four do, which are exact with it as well."""
    for sections in (2, 4):
        force, place = median_errors(rubbing_contacts(60, 0.45, 0.0, 3), sections)
        assert force < 0.005
        assert place < 0.002
    force, place = median_errors(rubbing_contacts(60, 0.45, 1.0, 3), 2)
    assert 0.05 < force < 0.2
    assert place > 0.01
    force, place = median_errors(rubbing_contacts(60, 0.45, 1.0, 3), 4)
    assert force < 0.02
    assert place < 0.005
