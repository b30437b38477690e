"""How far estimated shapes are from true ones, sample by sample, and whether they are as certain as they say."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from soft_gripper.arrays import Array
from soft_gripper.estimators.driving_torque import recorded_driving
from soft_gripper.estimators.estimate import ShapeEstimate
from soft_gripper.estimators.recursive import RecursiveShape
from soft_gripper.estimators.uncertainty import Uncertainty, position_std
from soft_gripper.evaluation.robustness.plants import FingerAtRest
from soft_gripper.fingers.finger import Finger
from soft_gripper.fingers.kinematics import forward_kinematics, in_space
from soft_gripper.runs.estimator_functions import estimator_function
from soft_gripper.sensors.measurement import MeasurementModel
from soft_gripper.truth.poses import fingertip_error, pose_error

BAND = 1.96  # standard deviations either side, of 95 %


class Errors(NamedTuple):
    """Of any number of samples."""

    pose: Array  # (samples) m
    tip: Array  # (samples) m
    covered: NDArray[np.bool_]  # whether places lie in their 95 % bands, (places); none without a covariance


def estimated(
    estimator: str,
    layout: MeasurementModel,
    uncertainty: Uncertainty,
    held: FingerAtRest,
    readings: Array,
    gain: float = 1.0,
) -> Errors:
    """The errors of an estimator at the held samples of a finger.

    Args:
        estimator: its name, see `estimator_function`.
        layout: sensors and finger as they are believed to be.
        uncertainty: of these.
        held: the finger.
        readings: of its sensors, (T, seeds, paths * S).
        gain: of the pressure sensor.
    """
    function, rows = estimator_function(estimator, layout, uncertainty, held.period), held.samples
    seeds = (1, readings.shape[1])
    pressure, gravity = (np.tile(values[:, None], seeds) for values in (gain * held.pressure, held.gravity))
    finger = layout.finger
    driving = recorded_driving(function, finger, readings, pressure, gravity, held.period)
    if isinstance(function, RecursiveShape):
        estimate = function.at(rows, readings, driving, gravity)
    else:
        estimate = function(readings[rows], driving[rows], gravity[rows])
    truth = held.points(np.append(finger.joint_arc_lengths, finger.length))
    return errors_of(finger, estimate, truth[:, None])


def errors_of(believed: Finger, estimate: ShapeEstimate, truth: Array) -> Errors:
    """The errors of an estimate, (...), from the true places of joints and tip, (..., N + 1, 3) m in B."""
    points = in_space(estimate.points(believed))
    pose = pose_error(truth[..., :-1, :], points[..., :-1, :])
    tip = fingertip_error(truth[..., -1, :], points[..., -1, :])
    return Errors(pose.ravel(), tip.ravel(), covered(believed, estimate, truth).ravel())


def covered(believed: Finger, estimate: ShapeEstimate, truth: Array) -> NDArray[np.bool_]:
    """Whether the true places lie in the 95 % bands across the finger, (..., N); the first joint rests."""
    if estimate.covariance is None:
        return np.zeros(0, dtype=bool)
    normals = forward_kinematics(estimate.q, believed.segment_length).normals
    across = (in_space(normals) * (truth - in_space(estimate.points(believed)))).sum(axis=-1)
    band = BAND * position_std(believed, estimate.q, estimate.covariance)
    within: NDArray[np.bool_] = (np.abs(across) <= band)[..., 1:]
    return within


def together(parts: list[Errors]) -> Errors:
    """All samples in one."""
    return Errors(*(np.concatenate(part) for part in zip(*parts, strict=True)))


def in_mm(errors: Errors) -> tuple[float, float, float, float]:
    """Mean, 95th percentile and worst of the pose error, mm, and the share that is covered, NaN if unknown."""
    pose = 1e3 * errors.pose
    share = float(errors.covered.mean()) if errors.covered.size else float("nan")
    return float(pose.mean()), float(np.quantile(pose, 0.95)), float(pose.max()), share
