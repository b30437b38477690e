"""What a force does to the joints: the work that it does when a joint turns."""

import numpy as np
import pytest

from soft_gripper.estimators.contact import face_offset, unit_torques
from soft_gripper.fingers.kinematics import forward_kinematics

STEP = 1e-6  # rad


def place(finger, q, s, offset=0.0):
    """The point of the link at arc length s, at an offset from the axis, and the direction of the link."""
    chain = forward_kinematics(q, finger.segment_length)
    link = int(np.sum(finger.joint_arc_lengths < s))
    direction = np.exp(1j * chain.headings[link])
    begin = chain.joints[link - 1] if link else 0.0
    return begin + direction * (s - finger.link_ends[link] + 1j * offset), direction


def work(finger, q, s, force, offset=0.0):
    """Work of a force that keeps its direction in B, per angle of every joint, N m, by central differences."""
    moves = [
        place(finger, q + turn, s, offset)[0] - place(finger, q - turn, s, offset)[0]
        for turn in STEP * np.eye(finger.segments)
    ]
    return np.real(np.conj(force) * np.array(moves)) / (2 * STEP)


@pytest.mark.parametrize("share", [0.02, 0.1, 0.47, 0.8, 0.999, 1.0])
def test_torques_are_the_work_of_the_forces(shipped_finger, bent, share):
    q, s = bent(12), share * shipped_finger.length
    torques = unit_torques(forward_kinematics(q, shipped_finger.segment_length), np.array([s]))
    _, direction = place(shipped_finger, q, s)
    np.testing.assert_allclose(torques.across[0], work(shipped_finger, q, s, -1j * direction), atol=1e-9)
    np.testing.assert_allclose(torques.along[0], work(shipped_finger, q, s, direction), atol=1e-9)


@pytest.mark.parametrize("side", [1.0, -1.0])
def test_friction_acts_on_the_face(shipped_finger, bent, side):
    """Its torque is that in the line of the axis and the offset's beside, at the joints before it."""
    q, s = bent(12), 0.08
    offset = face_offset(shipped_finger, np.array(s), np.array(side))
    torques = unit_torques(forward_kinematics(q, shipped_finger.segment_length), np.array([s]))
    _, direction = place(shipped_finger, q, s)
    before = shipped_finger.joint_arc_lengths < s
    np.testing.assert_allclose(
        torques.along[0] - offset * before, work(shipped_finger, q, s, direction, offset), atol=1e-9
    )


def test_faces_lie_a_thickness_apart_with_the_inner_one_at_the_inner_side(tapered_finger):
    s = np.linspace(0, tapered_finger.length, 5)
    inner, outer = (face_offset(tapered_finger, s, np.full(5, side)) for side in (1.0, -1.0))
    np.testing.assert_allclose(inner - outer, tapered_finger.section(s).thickness, rtol=1e-12)
    assert (inner > outer).all()


def test_a_force_on_the_inner_side_opens_and_one_before_a_joint_leaves_it_alone(shipped_finger):
    chain = forward_kinematics(np.zeros(12), shipped_finger.segment_length)
    torques = unit_torques(chain, np.array([0.062]))
    levers = np.maximum(0.062 - shipped_finger.joint_arc_lengths, 0)
    np.testing.assert_allclose(torques.across[0], -levers, atol=1e-15)
    np.testing.assert_allclose(torques.along[0], 0, atol=1e-15)


def test_a_batch_is_its_samples(shipped_finger, bent):
    q, s = bent(3, 2, 12), np.random.default_rng(4).uniform(0, 0.12, (3, 2, 5))
    torques = np.array(unit_torques(forward_kinematics(q, shipped_finger.segment_length), s))
    assert torques.shape == (2, 3, 2, 5, 12)
    for index in np.ndindex(3, 2, 5):
        chain = forward_kinematics(q[index[:2]], shipped_finger.segment_length)
        alone = np.array(unit_torques(chain, s[index][None]))[:, 0]
        np.testing.assert_allclose(torques[:, *index], alone, atol=1e-16)
