"""Creep: how the stiffness of a finger fades while it is held bent, as internal angles of Maxwell branches.

Every joint has an internal angle z for each branch, which follows its angle q:

    dz_i/dt = (q - z_i) / time_i .

The spring of branch i is stretched by q - z_i alone, so that the balance of a joint of instantaneous stiffness k reads

    k q + d dq/dt = driving torque + sum of  share_i k z_i ,

the last of which is the memory torque: creep drives the finger on as pressure does. This is a Prony series in the
convention of finite element programs (J. C. Simo, T. J. R. Hughes: *Computational Inelasticity*, 1998, chapter 10), and
for an angle that is linear between samples, z follows exactly (same, 10.3).

A pressure law says that the finger bends s(p) = P(p) / p times as far as the chamber law has it. It is the chamber that
widens, and with it whatever bends it is multiplied, what creeps as well:

    dz_i/dt = (q / s - z_i) / time_i ,    memory torque = s sum of  share_i k z_i .

So a finger that is emptied remembers as much of its bend as the same stress would have left in a finger without a law.

Leading axes are free; B branches, N joints.
"""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from soft_gripper.arrays import Array
from soft_gripper.fingers.finger import Finger
from soft_gripper.fingers.finger_parts import CreepBranch


class Recursion(NamedTuple):
    """z after a period = kept * z + before * q before it + after * q after it; (B, 1) each."""

    kept: Array
    before: Array
    after: Array


def recursion(branches: Sequence[CreepBranch], period: float) -> Recursion:
    """Exact for angles that are linear over the period (s), which leads on to every exponential in closed form."""
    periods = period / np.array([branch.time for branch in branches])[:, None]
    kept, mean = np.exp(-periods), -np.expm1(-periods) / periods  # the mean of exp(-t / time) over the period
    return Recursion(kept, mean - kept, 1 - mean)


def advance(branches: Sequence[CreepBranch], z: Array, before: Array, after: Array, period: float) -> Array:
    """Internal angles a period (s) later, (..., B, N) rad.

    Args:
        branches: B of them.
        z: internal angles, (..., B, N) rad.
        before, after: joint angles at the beginning and at the end of the period, (..., N) rad, linear between; give
            the same twice for angles that are held. Those of a finger with a pressure law divided by its softening.
        period: s.
    """
    kept, of_before, of_after = recursion(branches, period)
    later: Array = kept * z + of_before * before[..., None, :] + of_after * after[..., None, :]
    return later


def memory_torque(finger: Finger, z: Array, pressure: Array | float = 0.0) -> Array:
    """Torque of creep that drives the joints, (..., B, N) rad -> (..., N) N m, positive where it closes.

    `pressure`, (...) Pa, is that in the chamber; it matters to a finger with a pressure law.
    """
    torque: Array = finger.softening(pressure)[..., None] * (shares(finger) @ z * finger.stiffness)
    return torque


def shares(finger: Finger) -> Array:
    """Of every branch, (B,)."""
    return np.array([branch.share for branch in finger.creep])
