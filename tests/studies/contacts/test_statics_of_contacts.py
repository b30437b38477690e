"""Contacts in balance with friction of a known share: their torque, and what friction makes of the estimates."""

import numpy as np

from soft_gripper.fingers.kinematics import as_planar, gravity_torque
from soft_gripper.fingers.statics import relaxed_law, softened
from studies.contacts.contacts import INNER, OUTER, read_finger
from studies.contacts.statics import balanced_contacts, link_forces, rubbing_contacts

FAR = 0.42, 0.99  # of the length, where a finger is usually touched


def test_torque_of_a_force_on_a_straight_finger_by_hand():
    """Of one that hardly bends: a force that rubs outside, and one that presses inside."""
    finger, s, none = softened(read_finger(), 1e-3), np.full(2, 0.0725), np.zeros(2)
    force = 1e-3 * np.array([[2.0, 0.0, 0.8], [-2.0, 0.0, 0.0]])
    place = np.array([[-0.019, 0.0, 0.0], [2e-4, 0.0, 0.0]])
    forces = link_forces(finger, s[:, None], place[:, None], force[:, None])
    size, side = np.full(2, 2e-3), np.array([OUTER, INNER])
    contacts = balanced_contacts(finger, none, np.zeros((2, 3)), forces, size, s, side, none)
    lever = np.maximum(0.0725 - finger.joint_arc_lengths, 0)
    rubbing = np.where(lever > 0, 0.8 * 0.019, 0)  # toward the tip, on the outer side: it closes the finger
    np.testing.assert_allclose(1e3 * contacts.torque, [2.0 * lever + rubbing, -2.0 * lever], atol=1e-5)
    np.testing.assert_allclose(contacts.force, force, atol=1e-7)


def test_contacts_are_in_balance():
    contacts = rubbing_contacts(20, 2, 0.45, 1.0, FAR)
    finger = contacts.finger
    weight = gravity_torque(finger, contacts.q, as_planar(contacts.gravity[:, ::2])[:, None])
    elastic = relaxed_law(finger).inverse()(finger.pressure_torque(contacts.pressure) + weight + contacts.torque)
    np.testing.assert_allclose(contacts.q, elastic, atol=1e-8)
    size = np.linalg.norm(contacts.force, axis=-1)
    np.testing.assert_allclose(size, contacts.normal_force * np.hypot(1, 0.45))
    assert {*contacts.side} == {INNER, OUTER}
