"""Contacts in space: their balance."""

import numpy as np

from soft_gripper.fingers.spatial_chain import posture, spatial_chain
from studies.contacts.statics import contacts_in_space, finger_in_space


def test_contacts_are_in_balance_with_virtual_work():
    """Springs, pressure and weight are the work of the force on its place; the friction is as asked."""
    contacts, finger = contacts_in_space(12, 0.3, 4), finger_in_space()
    chain = spatial_chain(finger)
    order = chain.position_indices(finger.yields)
    stiffness = chain.interleaved(finger.stiffnesses)
    size = np.linalg.norm(contacts.force, axis=-1)
    np.testing.assert_allclose(size, np.hypot(1, 0.3) * contacts.normal_force, rtol=1e-6)

    def energy(q, i):
        at, links = posture(chain, q), chain.link_frames(np.arange(finger.segments + 1))
        x, z = finger.links.center
        centres = (
            at.origins[links] + x[:, None] * at.rotations[links][..., 0] + z[:, None] * at.rotations[links][..., 2]
        )
        driving = chain.interleaved({"bending": finger.pressure_torque(contacts.pressure[i])})
        return stiffness @ q**2 / 2 - driving @ q - (finger.links.mass @ centres) @ contacts.gravity[i]

    for i in range(3):
        q, step = contacts.q[i][order], 1e-6 * np.eye(len(order))
        left = np.array([(energy(q + dq, i) - energy(q - dq, i)) / 2e-6 for dq in step])
        moved = int(chain.link_frames(np.searchsorted(finger.joint_arc_lengths, contacts.arc_length[i])))
        np.testing.assert_allclose(left[moved:], 0, atol=1e-6)
        screws, force = posture(chain, q).screws[:moved], contacts.force[i]
        levers = np.cross(force, screws[:, :3])  # w . (p x F) = p . (F x w), of one place p for all joints
        place = np.linalg.lstsq(levers, left[:moved] - screws[:, 3:] @ force, rcond=None)[0]
        np.testing.assert_allclose(levers @ place + screws[:, 3:] @ force, left[:moved], atol=1e-6)
