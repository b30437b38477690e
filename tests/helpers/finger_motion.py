"""Fingers in motion: samples of a finger at rest, and a base that moves and turns as known functions of time."""

import numpy as np
from pydrake.math import RotationMatrix

from soft_gripper.load.force_estimator import SAMPLES, TorqueBalance

Y = np.array([0.0, 1.0, 0.0])
UPRIGHT = np.eye(3)
TILTED = np.array([2.0, 1.0, -2.0]) / 3


def at_rest(finger, q, driving=0.0, R=UPRIGHT):
    """Samples of a finger that does not move."""
    X_WB = np.column_stack([R, [1.0, 2.0, 3.0]])
    values = np.tile(q, (SAMPLES, 1)), np.full((SAMPLES, len(q)), driving), np.tile(X_WB, (SAMPLES, 1, 1))
    return TorqueBalance(finger).samples(*values)


def wave(time, order, size, rate, phase=0.0):
    """A sine of time, or its derivative of that order."""
    return size * rate**order * np.sin(rate * time + phase + order * np.pi / 2)


def position(time, order=0):
    """Of the base, m, (3,): some m/s^2."""
    return np.array([wave(time, order, 0.02, 13.0), wave(time, order, 0.01, 20.0, 1.0), wave(time, order, 0.03, 9.0)])


def turn(axis, time):
    """Rotation of the base about an axis that turns about another, with its angular velocity and acceleration."""
    spin, tilt = (lambda order: wave(time, order, 0.4, 9.0)), (lambda order: wave(time, order, 0.2, 7.0, 0.5))
    first = RotationMatrix(rotation(Y, spin(0)))
    carried = first.multiply(axis)
    w_first = Y * spin(1)
    w, alpha = w_first + carried * tilt(1), Y * spin(2) + carried * tilt(2) + np.cross(w_first, carried) * tilt(1)
    return first.matrix() @ rotation(axis, tilt(0)), w, alpha


def rotation(axis, angle):
    """Rodrigues' formula."""
    cross = np.cross(np.eye(3), axis)
    return np.eye(3) + np.sin(angle) * cross + (1 - np.cos(angle)) * cross @ cross


def bend(joints, time, order=0):
    """Of every joint, rad, (N,)."""
    return wave(time, order, 0.08, 15.0 + np.arange(joints), np.arange(joints))


def chamber_pressure(time):
    """Pa."""
    return 60e3 + wave(time, 0, 30e3, 20.0)


def moving(finger, axis, time, period):
    """Samples around a time of a finger that bends, on a base that moves."""
    times = time + (np.arange(SAMPLES) - SAMPLES // 2) * period
    X_WB = [np.column_stack([turn(axis, t)[0], position(t)]) for t in times]
    q = [bend(finger.segments, t) for t in times]
    driving = finger.pressure_torque(chamber_pressure(times))
    return TorqueBalance(finger).samples(np.array(q), driving, np.array(X_WB))
