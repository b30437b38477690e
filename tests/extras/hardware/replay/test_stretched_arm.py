"""Arms whose sections lengthen, against arcs and rotations in closed form."""

from dataclasses import replace

import numpy as np
import pytest

from soft_gripper.estimators.arcs import join_arcs
from soft_gripper.extras.hardware.replay.arm_estimation import RigidParts, StretchedArm, stretched_arm
from soft_gripper.fingers.kinematics import as_points, forward_kinematics

ENDS = np.array([0, 40, 80])
NOTHING = np.zeros(2, dtype=complex)


def parts(**numbers):
    return RigidParts(
        **{"base": 0j, "tilt": 0.0, "couplings": NOTHING, "bodies": NOTHING, "turns": np.zeros(2), **numbers}
    )


def shared(theta):
    return np.repeat(np.asarray(theta) / 40, 40, axis=-1)


def test_unequal_sections_lie_on_their_arcs():
    theta, length = np.array([[0.6, -0.8], [0.0, 0.3]]), np.array([[0.12, 0.17], [0.1, 0.13]])
    _, bodies, headings = stretched_arm(parts(), shared(theta), length, ENDS)
    np.testing.assert_allclose(bodies, join_arcs(theta, length).end, atol=1e-5)
    np.testing.assert_allclose(headings, theta.cumsum(axis=-1))


def test_rigid_parts_turn_with_what_carries_them():
    """Two right angles of the joint at 39, at the end of section 1: behind it all is seen from the other side."""
    q = np.zeros(80)
    q[39] = np.pi
    rigid = parts(couplings=np.array([0.02j, 0]), bodies=np.array([0.03, 0.01j]), turns=np.array([0.1, 0.0]))
    length = np.array([0.4, 0.4])
    _, bodies, headings = stretched_arm(rigid, q, length, ENDS)
    end = 0.395 - 0.005  # half of the last segment runs back
    np.testing.assert_allclose(bodies, [end - 0.03, end - 0.02j - 0.4 - 0.01j], atol=1e-12)
    np.testing.assert_allclose(headings, [np.pi + 0.1, np.pi])


def test_base_and_tilt_move_the_whole_arm():
    theta, length = shared([0.6, -0.8]), np.array([0.12, 0.17])
    joints, bodies, _ = stretched_arm(parts(), theta, length, ENDS)
    moved, moved_bodies, headings = stretched_arm(parts(base=0.01j, tilt=0.3), theta, length, ENDS)
    np.testing.assert_allclose(moved, 0.01j + joints * np.exp(0.3j))
    np.testing.assert_allclose(moved_bodies, 0.01j + bodies * np.exp(0.3j))
    assert headings[-1] == pytest.approx(0.3 - 0.2)


def test_equal_segments_are_the_usual_chain(bent):
    q = bent(5, 80)
    equal, one_by_one = forward_kinematics(q, 0.01), forward_kinematics(q, np.full(80, 0.01))
    for a, b in zip(equal, one_by_one, strict=True):
        np.testing.assert_allclose(a, b, atol=1e-15)


def test_the_block_puts_out_the_arm_and_how_far_its_bodies_are_from_the_measured_ones(shipped_finger, bent):
    finger, lengths = replace(shipped_finger, segments=80), np.array([0.12, 0.17])
    rigid, q = parts(base=0.01j, tilt=0.3, bodies=np.array([0.03, 0.01j])), bent(1, 80)[0] / 10
    arm = StretchedArm(rigid, finger, ["middle", "tip"])
    context = arm.CreateDefaultContext()
    joints, bodies, _ = stretched_arm(rigid, q, lengths, ENDS)
    off = np.array([3e-3 + 4e-3j, -5e-3j])
    inputs = q, lengths, as_points(bodies + off).ravel()
    for number, value in enumerate(inputs):
        arm.get_input_port(number).FixValue(context, value)
    found = {
        name: arm.GetOutputPort(name).Eval(context) for name in ("joint_positions", "body_positions", "body_error")
    }
    np.testing.assert_allclose(found["joint_positions"], as_points(joints).ravel(), atol=1e-12)
    np.testing.assert_allclose(found["body_positions"], as_points(bodies).ravel(), atol=1e-12)
    np.testing.assert_allclose(found["body_error"], [5e-3, 5e-3], atol=1e-12)
