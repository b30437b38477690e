"""The table of robustness: errors of every estimator, with sensor errors and wrong nominal models.

Errors with other plants: exactly known fingers, and one of rubber whose nominal model is linear.

If plant and estimator are the same chain, an estimator may be right for the wrong reason: what a chain of twelve
linear joints cannot represent is wrong in both. So the rubber finger has twice the segments, another elastic law and
another time step, its sensors have errors, and the nominal model stays the shipped one, whose modulus is known to
10 %.
"""

from collections import defaultdict
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import product
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from soft_gripper.arrays import Array
from soft_gripper.estimators.driving_torque import recorded_driving
from soft_gripper.estimators.estimate import ShapeEstimate, estimates_at
from soft_gripper.estimators.finger_shape import BENDS, Places
from soft_gripper.estimators.named_estimators import estimator_function
from soft_gripper.estimators.uncertainty import EXACT, Uncertainty, uncertainty_of
from soft_gripper.extras.paper.scenario_run import SECTIONS
from soft_gripper.fingers.finger import Finger
from soft_gripper.fingers.kinematics import forward_kinematics, in_space
from soft_gripper.runs.scores.readings import with_sections
from soft_gripper.scenario.nominal_model import read_nominal_model
from soft_gripper.scenario.schema import NominalConfig, SensorConfig, StrainErrorsConfig
from soft_gripper.scenario.sensor_presets import sensor_layout, strain_errors
from soft_gripper.sensors.measurement import MeasurementModel
from soft_gripper.sensors.strain_errors import StrainErrors
from soft_gripper.truth.poses import fingertip_error, pose_error
from studies.contacts.contacts import read_finger
from studies.robustness.plants import FingerAtRest, Plant

BAND = 1.96  # standard deviations on either side of a 95 % band


class Errors(NamedTuple):
    """Errors of any number of samples."""

    pose: Array  # (samples) m
    tip: Array  # (samples) m
    covered: NDArray[np.bool_]  # whether positions lie in their 95 % bands, (positions); empty without a covariance


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
        layout: the nominal sensors and finger.
        uncertainty: of these.
        held: the finger.
        readings: of its sensors, (T, seeds, paths * S).
        gain: of the pressure sensor.
    """
    function, rows = estimator_function(estimator, layout, uncertainty, held.period), held.samples
    seeds = (1, readings.shape[1])
    pressure = np.tile(gain * held.pressure[:, None], seeds)
    gravity = np.tile(held.gravity[:, None], (*seeds, 1))
    finger = layout.finger
    driving = recorded_driving(function, finger, readings, pressure, gravity, held.period)
    estimate = estimates_at(function, rows, readings, driving, gravity)
    truth = held.points(np.append(finger.joint_arc_lengths, finger.length))
    return errors_of(finger, estimate, truth[:, None])


def errors_of(nominal: Finger, estimate: ShapeEstimate, truth: Array) -> Errors:
    """The errors of an estimate, (...), from the true positions of joints and tip, (..., N + 1, 3) m in B."""
    points = in_space(estimate.points(nominal))
    pose = pose_error(truth[..., :-1, :], points[..., :-1, :])
    tip = fingertip_error(truth[..., -1, :], points[..., -1, :])
    return Errors(pose.ravel(), tip.ravel(), covered(nominal, estimate, truth).ravel())


def covered(nominal: Finger, estimate: ShapeEstimate, truth: Array) -> NDArray[np.bool_]:
    """Whether the true positions lie in the 95 % bands across the finger, (..., N); the first joint does not move."""
    if estimate.covariance is None:
        return np.zeros(0, dtype=bool)
    normals = in_space(forward_kinematics(estimate.q, nominal.segment_length).normals)
    across = (normals * (truth - in_space(estimate.points(nominal)))).sum(axis=-1)
    moves = (Places(nominal, BENDS).place_jacobian(estimate.q) * normals[..., None, :, :]).sum(
        axis=-1
    )  # (..., D, N + 1)
    variance = ((estimate.covariance @ moves) * moves).sum(axis=-2)
    within: NDArray[np.bool_] = (np.abs(across) <= BAND * np.sqrt(np.maximum(variance, 0)))[..., 1:]
    return within


def together(parts: list[Errors]) -> Errors:
    """All samples in one."""
    return Errors(*(np.concatenate(part) for part in zip(*parts, strict=True)))


class Nominal(NamedTuple):
    """What an estimator is told of a finger."""

    layout: MeasurementModel
    uncertainty: Uncertainty
    gain: float = 1.0  # of the pressure sensor


def errors_by(
    fingers: Sequence[FingerAtRest],
    nominals: Callable[[FingerAtRest], Mapping[str, Nominal]],
    errors: StrainErrors | None,
    seeds: int,
    estimators: Sequence[str],
) -> dict[tuple[str, int, str], Errors]:
    """Errors of all fingers together by nominal model, number of sections and estimator.

    Without errors of the sensors all seeds would be the same, and one is enough.
    """
    found: dict[tuple[str, int, str], list[Errors]] = defaultdict(list)
    for held in fingers:
        readings = {sections: held.readings(sections, errors, seeds if errors else 1) for sections in SECTIONS}
        for (name, nominal), sections, estimator in product(nominals(held).items(), SECTIONS, estimators):
            layout, uncertainty, gain = nominal
            given = with_sections(layout, sections), uncertainty, held, readings[sections], gain
            found[name, sections, estimator].append(estimated(estimator, *given))
    return {key: together(parts) for key, parts in found.items()}


def in_mm(errors: Errors) -> tuple[float, float, float, float]:
    """Mean, 95th percentile and worst of the pose error, mm, and the share that is covered, NaN if unknown."""
    pose = 1e3 * errors.pose
    share = float(errors.covered.mean()) if errors.covered.size else float("nan")
    return float(pose.mean()), float(np.quantile(pose, 0.95)), float(pose.max()), share


PRESET = "realistic"
NOISES = (0.0, 1.0, 2.0, 4.0)  # times the errors of the preset
_SIZES = ("creep", "hysteresis", "gain_error", "offset", "drift", "low_frequency_noise", "noise")


@dataclass(frozen=True)
class NominalError:
    """The relative errors of the nominal model."""

    modulus: float = 0.0  # of Young's modulus of the silicone
    pressure: float = 0.0  # of the measured pressure

    @property
    def name(self) -> str:
        """In tables."""
        parts = ("E", self.modulus), ("p", self.pressure)
        return ", ".join(f"{what} {100 * share:+.0f} %" for what, share in parts if share) or "as simulated"

    @property
    def size(self) -> float:
        """Relative error of the bend per pressure, of stiffness and pressure together."""
        return float(np.hypot(self.modulus, self.pressure))

    @property
    def config(self) -> NominalConfig:
        """As in a scenario."""
        return NominalConfig({"youngs_modulus": f"{100 * self.modulus:+g} %"} if self.modulus else {})


# Too soft a finger and too high a pressure both predict too much bend: the signs are chosen to add up.
NOMINAL_ERRORS = (NominalError(), NominalError(-0.1, 0.01), NominalError(0.1, -0.01))


def errors_at(noise: float) -> StrainErrors | None:
    """The errors of sensors, so many times those of the preset; None for 0."""
    preset = strain_errors(SensorConfig(errors=StrainErrorsConfig(preset=PRESET)))
    if preset is None or noise == 0:
        return None
    return replace(preset, **{name: noise * getattr(preset, name) for name in _SIZES})


@dataclass(frozen=True)
class RobustnessRow:
    """Errors of all touched fingers, held samples and seeds together."""

    scenario: str
    estimator: str
    nominal: str
    noise: float  # times the errors of the preset
    sections: int
    mean_mm: float
    p95_mm: float  # 95th percentile
    worst_mm: float
    coverage: float  # share of positions in their 95 % bands; NaN for an estimator without covariance
    seeds: int


def robustness_table(
    name: str,
    fingers: Sequence[FingerAtRest],
    noise: float,
    seeds: int,
    estimators: Sequence[str],
    nominal_errors: Sequence[NominalError] = NOMINAL_ERRORS,
) -> list[RobustnessRow]:
    """A row for every nominal model, number of sections and estimator, in this order, at one noise."""
    errors = errors_at(noise)

    def nominals(held: FingerAtRest) -> dict[str, Nominal]:
        return {
            wrong.name: Nominal(
                read_nominal_model(wrong.config).layout(held.simulated, held.station.scenario.sensor),
                uncertainty_of(errors, None, wrong.size),
                1 + wrong.pressure,
            )
            for wrong in nominal_errors
        }

    return [
        RobustnessRow(name, estimator, nominal, noise, sections, *in_mm(found), seeds)
        for (nominal, sections, estimator), found in errors_by(fingers, nominals, errors, seeds, estimators).items()
    ]


MODULUS = 0.1  # share, standard deviation of the nominal modulus of rubber


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
    coverage: float  # share of positions in their 95 % bands; NaN for an estimator without covariance
    seeds: int


def plant_table(
    plant: Plant, name: str, fingers: Sequence[FingerAtRest], seeds: int, estimators: Sequence[str]
) -> list[PlantRow]:
    """A row for every number of sections and estimator, in this order; of a known plant with ideal sensors."""
    errors = None if plant.is_known else errors_at(1.0)
    exact = Uncertainty(bend_per_pressure=EXACT)
    uncertainty = exact if plant.is_known else uncertainty_of(errors, None, MODULUS)

    def nominals(held: FingerAtRest) -> dict[str, Nominal]:
        finger = held.simulated if plant.is_known else read_finger()
        return {plant.name: Nominal(sensor_layout(finger, held.station.scenario.sensor), uncertainty)}

    rows = []
    for (_, sections, estimator), found in errors_by(fingers, nominals, errors, seeds, estimators).items():
        mean, p95, worst, coverage = in_mm(found)
        tip = 1e3 * float(found.tip.mean())
        rows.append(PlantRow(plant.name, name, estimator, sections, mean, p95, worst, tip, coverage, seeds))
    return rows
