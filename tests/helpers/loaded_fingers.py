"""Fingers in static balance with pressure, weight and forces, by nothing but the definition of a torque."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from soft_gripper.arrays import Array
from soft_gripper.fingers.finger import Finger
from soft_gripper.fingers.kinematics import forward_kinematics, gravity_torque, in_space


class Push(NamedTuple):
    """A force on a finger."""

    arc_length: float  # m, from the base
    across: float  # N, positive where it presses on the inner side
    along: float = 0.0  # N, toward the tip
    offset: float = 0.0  # m, from the neutral axis, of the place where it acts


def vector(gravity: Array | complex) -> Array:
    """Gravity in the bending plane, z + i x in B, (...), as a vector in B, (..., 3)."""
    return in_space(np.asarray(gravity, dtype=complex))


def torque_of(finger: Finger, q: Array, push: Push) -> Array:
    """Torque of a push at every joint, N m, (N,): the cross product of lever and force."""
    chain = forward_kinematics(q, finger.segment_length)
    link = int(np.sum(finger.joint_arc_lengths < push.arc_length))
    direction = np.exp(1j * chain.headings[link])
    begin = chain.joints[link - 1] if link else 0.0
    place = begin + direction * (push.arc_length - finger.link_ends[link] + 1j * push.offset)
    force = direction * (push.along - 1j * push.across)
    lever = place - chain.joints[:link]
    torque = np.zeros(finger.segments)
    torque[:link] = lever.real * force.imag - lever.imag * force.real
    return torque


def in_balance(finger: Finger, pressure: float, gravity: complex, pushes: Sequence[Push] = ()) -> Array:
    """Joint angles at which the elastic torque bears pressure, weight and pushes, rad, (N,)."""
    q = np.zeros(finger.segments)
    for _ in range(200):
        load = sum((torque_of(finger, q, push) for push in pushes), gravity_torque(finger, q, gravity))
        before, q = q, finger.angle(pressure * finger.pressure_gain + load)
        if np.abs(q - before).max() < 1e-14:
            return q
    raise AssertionError("the load is too large for the iteration to converge")
