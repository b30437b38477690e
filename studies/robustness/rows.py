"""Rows of robustness: errors of every estimator, with sensor errors, wrong nominal models and other plants.

In: fingers at rest in recordings. Out: rows by setup and estimator. Other plants are exactly known fingers, and one of
rubber whose nominal model is linear; another wrong model is an entry of NOMINAL_ERRORS.

If plant and estimator are the same chain, an estimator may be right for the wrong reason: both miss the shapes that a
chain of twelve linear joints cannot have. So the rubber finger has twice the segments, another elastic law and
another time step, its sensors have errors, and the nominal model stays the shipped one, whose modulus is known to
10 %.
"""

import math
from collections import defaultdict
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import product
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from soft_gripper.arrays import Array
from soft_gripper.estimators.driving_torque import recorded_driving
from soft_gripper.estimators.estimate import ShapeEstimate, estimates_at
from soft_gripper.estimators.finger_shape import BENDS, Places
from soft_gripper.estimators.named_estimators import estimator_function
from soft_gripper.estimators.uncertainty import Uncertainty
from soft_gripper.extras.paper.scenario_run import SECTIONS
from soft_gripper.fingers.finger import Finger
from soft_gripper.fingers.kinematics import forward_kinematics, in_space
from soft_gripper.runs.scores.readings import with_sections
from soft_gripper.scenario.sensor_presets import sensor_layout
from soft_gripper.sensors.measurement import MeasurementModel
from soft_gripper.truth.poses import fingertip_error, pose_error
from studies.contacts.contacts import read_finger
from studies.estimator_setup import EstimatorSetup
from studies.robustness.plants import FingerAtRest, Plant

BAND = 1.96  # standard deviations on either side of a 95 % band


class Errors(NamedTuple):
    """Errors of any number of samples."""

    pose: Array  # (samples) m
    tip: Array  # (samples) m
    covered: NDArray[np.bool_]  # positions in their 95 % bands, (positions); empty without a covariance


def estimator_errors(
    estimator: str,
    layout: MeasurementModel,
    uncertainty: Uncertainty,
    resting: FingerAtRest,
    readings: Array,
    gain: float = 1.0,
) -> Errors:
    """Errors of an estimator at the held samples of a finger.

    Args:
        estimator: its name, see `estimator_function`.
        layout: the nominal sensors and finger.
        uncertainty: of these.
        resting: the finger.
        readings: of its sensors, (T, seeds, paths * S).
        gain: of the pressure sensor.
    """
    function = estimator_function(estimator, layout, uncertainty, resting.period)
    rows = resting.samples
    repeats = (1, readings.shape[1])
    pressure = np.tile(gain * resting.pressure[:, None], repeats)
    gravity = np.tile(resting.gravity[:, None], (*repeats, 1))
    finger = layout.finger
    driving = recorded_driving(function, finger, readings, pressure, gravity, resting.period)
    estimate = estimates_at(function, rows, readings, driving, gravity)
    truth = resting.points(np.append(finger.joint_arc_lengths, finger.length))
    return position_errors(finger, estimate, truth[:, None])


def position_errors(nominal: Finger, estimate: ShapeEstimate, truth: Array) -> Errors:
    """Errors of an estimate, (...), from the true positions of joints and tip, (..., N + 1, 3) m in B."""
    points = in_space(estimate.points(nominal))
    pose = pose_error(truth[..., :-1, :], points[..., :-1, :])
    tip = fingertip_error(truth[..., -1, :], points[..., -1, :])
    return Errors(pose.ravel(), tip.ravel(), band_coverage(nominal, estimate, truth).ravel())


def band_coverage(nominal: Finger, estimate: ShapeEstimate, truth: Array) -> NDArray[np.bool_]:
    """True positions in the 95 % bands across the finger, mask (..., N); the first joint does not move."""
    if estimate.covariance is None:
        return np.zeros(0, dtype=bool)
    normals = in_space(forward_kinematics(estimate.q, nominal.segment_length).normals)
    normal_errors = (normals * (truth - in_space(estimate.points(nominal)))).sum(axis=-1)
    moves = (Places(nominal, BENDS).place_jacobian(estimate.q) * normals[..., None, :, :]).sum(
        axis=-1
    )  # (..., D, N + 1)
    variance = ((estimate.covariance @ moves) * moves).sum(axis=-2)
    return (np.abs(normal_errors) <= BAND * np.sqrt(np.maximum(variance, 0)))[..., 1:]


def setup_errors(
    fingers: Sequence[FingerAtRest],
    setups: Sequence[EstimatorSetup],
    seeds: int,
    estimators: Sequence[str],
    nominal: Finger | None = None,
) -> dict[tuple[EstimatorSetup, str], Errors]:
    """Errors of all fingers together, by setup and estimator; all setups have the same noise.

    `nominal` is the finger that nominal models change; None: the simulated one. Without errors of the sensors all seeds
    would be the same, and one is enough.
    """
    parts: dict[tuple[EstimatorSetup, str], list[Errors]] = defaultdict(list)
    noise = setups[0].errors
    for resting in fingers:
        readings = {count: resting.readings(count, noise, seeds if noise else 1) for count in SECTIONS}
        for setup, estimator in product(setups, estimators):
            sensors = sensor_layout(setup.nominal_finger(nominal or resting.simulated), resting.station.scenario.sensor)
            layout, gain = with_sections(sensors, setup.sections), 1 + setup.pressure
            inputs = layout, setup.uncertainty, resting, readings[setup.sections], gain
            parts[setup, estimator].append(estimator_errors(estimator, *inputs))
    return {key: joined(errors) for key, errors in parts.items()}


def joined(parts: Sequence[Errors]) -> Errors:
    """Joins the samples of several errors."""
    return Errors(*(np.concatenate(part) for part in zip(*parts, strict=True)))


def pose_statistics(errors: Errors) -> tuple[float, float, float, float]:
    """Mean, 95th percentile and worst of the pose error, mm, and the covered fraction, NaN without a covariance."""
    pose = 1e3 * errors.pose
    coverage = float(errors.covered.mean()) if errors.covered.size else float("nan")
    return float(pose.mean()), float(np.quantile(pose, 0.95)), float(pose.max()), coverage


NOISES = (0.0, 1.0, 2.0, 4.0)  # errors of the sensors, see `EstimatorSetup`
# Relative errors of the nominal Young's modulus and of the measured pressure. Too soft a finger and too high a pressure
# both predict too much bend: the signs are chosen to add up.
NOMINAL_ERRORS = (0.0, 0.0), (-0.1, 0.01), (0.1, -0.01)


def nominal_name(modulus: float, pressure: float) -> str:
    """Cell that names the errors of a nominal model."""
    errors = ("E", modulus), ("p", pressure)
    return ", ".join(f"{name} {100 * error:+.0f} %" for name, error in errors if error) or "as simulated"


@dataclass(frozen=True)
class RobustnessRow:
    """Errors of all touched fingers, held samples and seeds together."""

    scenario: str
    estimator: str
    nominal: str
    noise: float  # see NOISES
    sections: int
    mean_mm: float
    p95_mm: float  # 95th percentile
    worst_mm: float
    coverage: float  # fraction of positions in their 95 % bands; NaN for an estimator without covariance
    seeds: int


def robustness_table(
    name: str,
    fingers: Sequence[FingerAtRest],
    noise: float,
    seeds: int,
    estimators: Sequence[str],
    nominal_errors: Sequence[tuple[float, float]] = NOMINAL_ERRORS,
) -> list[RobustnessRow]:
    """A row for every nominal model, number of sections and estimator, in this order, at one noise."""
    setups = [
        EstimatorSetup(count, noise, stiffness=modulus, pressure=pressure, declared=math.hypot(modulus, pressure))
        for (modulus, pressure), count in product(nominal_errors, SECTIONS)
    ]
    return [
        RobustnessRow(
            *(name, estimator, nominal_name(setup.stiffness, setup.pressure), noise, setup.sections),
            *(*pose_statistics(errors), seeds),
        )
        for (setup, estimator), errors in setup_errors(fingers, setups, seeds, estimators).items()
    ]


MODULUS = 0.1  # standard deviation of the nominal modulus of rubber, a fraction


@dataclass(frozen=True)
class PlantRow:
    """Errors under another plant, of all touched fingers, held samples and seeds together."""

    plant: str
    scenario: str
    estimator: str
    sections: int
    mean_mm: float
    p95_mm: float  # 95th percentile
    worst_mm: float
    tip_mm: float  # mean
    coverage: float  # fraction of positions in their 95 % bands; NaN for an estimator without covariance
    seeds: int


def plant_table(
    plant: Plant, name: str, fingers: Sequence[FingerAtRest], seeds: int, estimators: Sequence[str]
) -> list[PlantRow]:
    """A row for every number of sections and estimator, in this order; of a known plant with ideal sensors."""
    noise, modulus_error = (0.0, 0.0) if plant.is_known else (1.0, MODULUS)
    setups = [EstimatorSetup(count, noise, declared=modulus_error) for count in SECTIONS]
    nominal = None if plant.is_known else read_finger()
    rows = []
    for (setup, estimator), errors in setup_errors(fingers, setups, seeds, estimators, nominal).items():
        mean, p95, largest, coverage = pose_statistics(errors)
        tip = 1e3 * float(errors.tip.mean())
        rows.append(PlantRow(plant.name, name, estimator, setup.sections, mean, p95, largest, tip, coverage, seeds))
    return rows
