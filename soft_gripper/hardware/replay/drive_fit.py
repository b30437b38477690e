"""The fitted drive of an arm: torque per pressure of every chamber, and creep.

With the bends of training recordings known, the balance  k q = G p + u_0 + w(q) + memory  is linear in the gains G and
in the torque u_0 without pressure; creep of a given share and time filters both sides alike. So the gains follow by
least squares for every creep on a grid, and the creep with the smallest residual is chosen.

Geometry is fitted with arcs, and the drive with the resulting bends, on other recordings than the one that is
estimated: estimators then differ only in how they share bends between joints.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import product

import numpy as np
from numpy.typing import NDArray
from scipy.signal import lfilter

from soft_gripper.arrays import Array
from soft_gripper.fingers.creep import recursion
from soft_gripper.fingers.finger import Finger
from soft_gripper.fingers.finger_parts import CreepBranch
from soft_gripper.fingers.kinematics import gravity_torque
from soft_gripper.hardware.replay.arm_recording import PERIOD, ArmRecording
from soft_gripper.hardware.replay.geometry_fit import ArmGeometry

_SHARES, _TIMES = (0.1, 0.25, 0.4, 0.55, 0.7), (0.5, 1.0, 2.0, 4.0, 8.0)
_RIDGE = 1e-2  # of the mean square of a chamber's pressure, for chambers that are hardly used


@dataclass(frozen=True)
class ArmDrive:
    """What drives an arm of N joints with C chambers."""

    finger: Finger  # with creep
    gains: Array  # (N, C) N m/Pa
    rest: Array  # (N,) N m, torque without pressure
    angle_std: float  # rad, of a joint: what is not explained


def fit_drive(recordings: Sequence[ArmRecording], geometry: ArmGeometry, finger: Finger, gravity: Array) -> ArmDrive:
    """The drive that explains the bends of the sections best; `gravity` in B, (3,) m/s^2."""
    sections = len(recordings[0].bodies)
    joints = np.diff(finger.section_ends(sections))
    bends = [geometry.wires.sections(recording.inner, recording.outer).theta for recording in recordings]
    weights = [_weight(finger, theta, joints, gravity) for theta in bends]
    scale = np.sqrt(np.mean(np.concatenate([recording.pressures for recording in recordings]) ** 2))
    inputs = [np.column_stack([r.pressures / scale, np.ones(len(r.time))]) for r in recordings]
    chambers, stiffness = np.array(recordings[0].chamber_sections), finger.stiffness[0]

    def explained(branch: CreepBranch) -> tuple[float, Array]:
        """Mean square of what is left of the joints' angles, and the torques per input, (C + 1, S)."""
        known, wanted = [], []
        for driven, weight, theta in zip(inputs, weights, bends, strict=True):
            bent = bend_under(branch, np.concatenate([driven, weight], axis=1) / stiffness)
            known.append(bent[:, : driven.shape[1]])
            wanted.append(theta / joints - bent[:, driven.shape[1] :])
        A, y = np.concatenate(known), np.concatenate(wanted)
        torques = np.zeros((A.shape[1], sections))
        for section in range(sections):
            own = np.append(np.flatnonzero(chambers == section), len(chambers))
            ridge = _RIDGE * np.mean(A**2) * len(A) * np.diag([1.0] * (len(own) - 1) + [0.0])
            torques[own, section] = np.linalg.solve(A[:, own].T @ A[:, own] + ridge, A[:, own].T @ y[:, section])
        return float(np.mean((y - A @ torques) ** 2)), torques

    tried = [CreepBranch(share, time) for share, time in product(_SHARES, _TIMES)]
    branch = min(tried, key=lambda branch: explained(branch)[0])
    left, torques = explained(branch)
    of_joints = np.repeat(torques.T, joints, axis=0)
    return ArmDrive(
        finger=replace(finger, creep=(branch,)),
        gains=of_joints[:, :-1] / scale,
        rest=of_joints[:, -1],
        angle_std=float(np.sqrt(left)),
    )


def bend_under(branch: CreepBranch, torque: Array) -> Array:
    """Bend of joints of unit stiffness that creep, under torques (T, ...) from rest, samples PERIOD apart.

    As an estimator remembers: the internal angle of a sample goes by the bends before it, each held.
    """
    kept = recursion((branch,), PERIOD).kept.item()
    remembered = kept + (1 - kept) * branch.share  # of the internal angle, which bends too
    bends: Array = torque + branch.share * lfilter([0.0, 1 - kept], [1.0, -remembered], torque, axis=0)
    return bends


def _weight(finger: Finger, theta: Array, joints: NDArray[np.int_], gravity: Array) -> Array:
    """Mean torque of weight on a joint of every section, (T, S) N m."""
    q = np.repeat(theta / joints, joints, axis=-1)
    torque = gravity_torque(finger, q, gravity[2] + 1j * gravity[0])
    means: Array = np.add.reduceat(torque, np.concatenate([[0], np.cumsum(joints)[:-1]]), axis=-1) / joints
    return means
