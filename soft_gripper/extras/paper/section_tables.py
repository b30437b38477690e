"""Pose errors and external torques for several numbers of sensor sections, from one simulation."""

from collections.abc import Sequence
from itertools import product

import numpy as np
from numpy.typing import NDArray

from soft_gripper.arrays import Array
from soft_gripper.diagrams.recording import Recording
from soft_gripper.diagrams.station_parts import Station
from soft_gripper.estimators.estimate import ShapeEstimate
from soft_gripper.fingers.kinematics import in_space
from soft_gripper.fingers.plant_finger import PlantFinger
from soft_gripper.runs.scores.external_torques import ForceRow, force_rows
from soft_gripper.runs.scores.poses import PoseRow, held_rows, held_steps, pose_rows
from soft_gripper.runs.scores.readings import external_torque_again, read_again
from soft_gripper.truth.poses import TRUE_JOINTS, TRUE_TIP, fingertip_error, pose_error


def pose_table(
    name: str, station: Station, recording: Recording, sections: Sequence[int], estimators: Sequence[str] = ("arcs",)
) -> list[PoseRow]:
    """A row for each estimator, finger, number of sections and steady state, in this order."""
    rows: list[PoseRow] = []
    rows_held = held_rows(station.scenario, recording)
    for estimator, finger, count in product(estimators, station.fingers, sections):
        shape = read_again(station, recording, finger, count).shape(estimator, rows_held.ravel())
        errors = (error.reshape(rows_held.shape) for error in _errors(recording, finger, shape, rows_held.ravel()))
        rows += pose_rows(held_steps(name, station, finger, estimator, count), station, recording, finger, *errors)
    return rows


def _errors(
    recording: Recording, finger: PlantFinger, shape: ShapeEstimate, samples: NDArray[np.int_]
) -> tuple[Array, Array]:
    """Pose and fingertip error of the shape at some samples, m, (M)."""
    joints, tip = (recording.values(f"{finger.name}.{name}")[samples] for name in (TRUE_JOINTS, TRUE_TIP))
    points = in_space(shape.points(finger.finger))
    return pose_error(joints, points[..., :-1, :]), fingertip_error(tip, points[..., -1, :])


def force_table(
    name: str, station: Station, recording: Recording, sections: Sequence[int], estimators: Sequence[str] = ("arcs",)
) -> list[ForceRow]:
    """A row for every estimator, finger, number of sections, held step and joint, in this order."""
    rows: list[ForceRow] = []
    for estimator, finger, count in product(estimators, station.fingers, sections):
        readings = read_again(station, recording, finger, count)
        estimate = external_torque_again(station, recording, finger, readings, estimator)
        rows += force_rows(held_steps(name, station, finger, estimator, count), station, recording, finger, estimate)
    return rows
