"""What is fitted of an arm, against one that is known."""

import numpy as np

from soft_gripper.extras.hardware.replay.arm_estimation import PERIOD, ArmRecording, RigidParts
from soft_gripper.extras.hardware.replay.geometry_fit import ArmGeometry, fit_drive
from soft_gripper.extras.hardware.replay.wire_lengths import WireGeometry
from soft_gripper.fingers.finger_parts import CreepBranch
from soft_gripper.fingers.statics import gravity_torque

GAINS = np.array([2e-5, -2e-5, 4e-5, -4e-5])  # N m/Pa, of chambers that oppose each other
REST = np.array([0.3, -0.2])  # N m, of the sections
ASIDE = np.array([3.0, 0.0, 9.0])  # m/s^2, gravity in B
BRANCH = CreepBranch(0.4, 2.0)
STRAIGHT = ArmGeometry(
    WireGeometry(0.04, *np.zeros((4, 2))), RigidParts(0j, 0.0, np.zeros(2), np.zeros(2), np.zeros(2)), 0.0
)


def driven_arm(number, finger, noise):
    """6 s of an arm without offsets that bends as  k q = G p + u_0 + w(q) + memory  says, sample after sample."""
    rng, count = np.random.default_rng(number), 300
    upper, lower = (rng.permutation(np.linspace(0, 1e5, 10)) for _ in range(2))  # Pa; the others have the rest of it
    steps = np.stack([upper, 1e5 - upper, lower, 1e5 - lower], axis=1)
    pressures = np.repeat(steps, count // 10, axis=0)
    driven = GAINS * pressures
    torque = np.stack([driven[:, :2].sum(axis=1), driven[:, 2:].sum(axis=1)], axis=1) + REST
    kept, stiffness = np.exp(-PERIOD / BRANCH.time), finger.stiffness[0]
    angles, q, memory = np.zeros((count, 2)), np.zeros(2), np.zeros(2)
    for i in range(count):
        for _ in range(4):  # the weight hardly depends on the bend
            weight = gravity_torque(finger, np.repeat(q, 6), ASIDE[2] + 1j * ASIDE[0])
            q = (torque[i] + weight.reshape(2, 6).mean(axis=1)) / stiffness + BRANCH.share * memory
        angles[i] = q
        memory = kept * memory + (1 - kept) * q
    half = 6 * angles * 0.04 / 2
    sides = [(0.12 + side * half).cumsum(axis=1) for side in (-1, 1)]
    inner, outer = (side + rng.normal(0, noise, (count, 1)) * [1, 1] for side in sides)
    none = np.zeros((count, 2))
    time, chambers = PERIOD * np.arange(count), (0, 0, 1, 1)
    return ArmRecording(f"{number}", 0.04, time, inner, outer, pressures, chambers, ("middle", "tip"), none + 0j, none)


def test_the_drive_of_an_arm_that_follows_the_balance_is_found(arm_finger):
    """Weight, creep and what bends without pressure are known; only a little of the gains is lost to the ridge."""
    drive = fit_drive([driven_arm(i, arm_finger, 0.0) for i in range(3)], STRAIGHT, arm_finger, ASIDE)
    assert drive.finger.creep == (BRANCH,)
    np.testing.assert_allclose(drive.gains[0], [*GAINS[:2], 0, 0], rtol=0.15)
    np.testing.assert_allclose(drive.gains[-1], [0, 0, *GAINS[2:]], rtol=0.15)
    np.testing.assert_allclose(drive.rest[[0, -1]], REST, atol=0.02)
