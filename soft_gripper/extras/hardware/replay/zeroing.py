"""Sensors that were set anew: their offsets, found again while the pose is known.

The pose of a finger is known while it is free and at rest: that in which pressure and weight balance. What its readings
differ by from those there, in the mean, is taken from all.

Of an arm the pose is measured. Two offsets per section, of its bend and its length, are all that setting the wires anew
can change. They follow from the poses of the bodies in the first seconds; all else stays as it was fitted. What the
model is wrong by there goes into the offsets: the band of the bodies in that pose makes the offsets uncertain, and
these every other pose.
"""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from soft_gripper.arrays import Array
from soft_gripper.estimators.plane import planar_gravity
from soft_gripper.extras.hardware.finger_logs import FingerLog
from soft_gripper.extras.hardware.least_squares import Problem, fit
from soft_gripper.extras.hardware.replay.arm_estimation import ArmRecording
from soft_gripper.extras.hardware.replay.geometry_fit import HEADING_STD, ArmGeometry, measured, places
from soft_gripper.files.document import require
from soft_gripper.fingers.finger import Finger
from soft_gripper.fingers.kinematics import as_points
from soft_gripper.fingers.statics import resting_angles
from soft_gripper.sensors.measurement import MeasurementModel
from soft_gripper.sensors.sensor_layout import strain_sensors

_TYPICAL = 1.0, 0.02  # rad and m, offsets of a bend and a length


@dataclass(frozen=True)
class Zeroed:
    """A geometry with offsets of its own."""

    geometry: ArmGeometry
    variants: tuple[ArmGeometry, ...]  # one standard deviation away, in each of the independent directions


def zeroed(geometry: ArmGeometry, recording: ArmRecording, finger: Finger, seconds: float, std: Array) -> Zeroed:
    """The offsets that place the bodies best in the first seconds of a recording.

    Args:
        geometry: fitted to other recordings.
        recording: begins with a known pose.
        finger: that represents the arm.
        seconds: for which the pose is known.
        std: of the bodies about their places along an axis, (S,) m.

    Raises:
        InputError: if the recording is not longer, or no row of these shows all bodies.
    """
    rows = _first(recording.name, recording.time, seconds)
    measured_positions, headings = (values[rows] for values in measured(recording, geometry.delay))
    seen = np.isfinite(measured_positions + headings).all(axis=-1)
    expected = "its first seconds must show all bodies: give more, or cut what comes before"
    require(bool(seen.any()), recording.name, "--zero", seconds, expected)
    inner, outer = recording.inner[rows][seen], recording.outer[rows][seen]

    def build_geometry(x: Array) -> ArmGeometry:
        """The geometry with other offsets, of the bends (rad), then of the lengths (m)."""
        bends, lengths = x.reshape(2, -1)
        wires = geometry.wires
        shifted = replace(wires, bend_offsets=wires.bend_offsets + bends, length_offsets=wires.length_offsets + lengths)
        return replace(geometry, wires=shifted)

    def residuals(x: Array) -> Array:
        moved = build_geometry(x)
        positions, turned = places(moved, finger, *moved.wires.sections(inner, outer))
        away, apart = (
            (positions - measured_positions[seen]).mean(axis=0) / std,
            (turned - headings[seen]).mean(axis=0) / HEADING_STD,
        )
        return np.concatenate([as_points(away).ravel(), apart])

    problem = Problem(build_geometry, residuals, options={"x_scale": np.repeat(_TYPICAL, len(std))})
    zero_fit = fit(problem, np.zeros(2 * len(std)))
    deviations = np.linalg.cholesky(zero_fit.covariance).T
    return Zeroed(zero_fit.model, tuple(build_geometry(zero_fit.x + one) for one in deviations))


def zeroed_log(log: FingerLog, layout: MeasurementModel, seconds: float) -> FingerLog:
    """A log whose finger is free and at rest in the first seconds, with readings as of its nominal sensors.

    Raises:
        InputError: if the log is not longer, or a sensor is not read in these.
    """
    rows, sensors = _first(log.name, log.time - log.time[0], seconds), strain_sensors(layout, "--zero")
    q = resting_angles(sensors.finger, log.pressure[rows], planar_gravity(log.X_WB[rows], log.gravity))
    away = log.readings[rows] - sensors.read(q)
    unread = ~np.isfinite(away).any(axis=0)
    require(not unread.any(), log.name, "--zero", seconds, f"reading {int(unread.argmax())} is NaN until then")
    return replace(log, readings=log.readings - np.nanmean(away, axis=0))


def _first(name: str, time: Array, seconds: float) -> NDArray[np.bool_]:
    """Which samples are in the first seconds, of times from 0 on, (T,)."""
    require(seconds < time[-1], name, "--zero", seconds, f"give less than the {time[-1]:g} s that it lasts")
    return time <= seconds
