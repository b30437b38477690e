"""The table of robustness: errors of every estimator, with sensor errors and wrong nominal models.

Errors with other plants: exactly known fingers, and one of rubber whose nominal model is linear.

If plant and estimator are the same chain, an estimator may be right for the wrong reason: what a chain of twelve
linear joints cannot represent is wrong in both. So the rubber finger has twice the segments, another elastic law and
another time step, its sensors have errors, and the nominal model stays the shipped one, whose modulus is known to
10 %.
"""

from collections import defaultdict
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import chain
from typing import NamedTuple, TypeVar

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
from soft_gripper.fingers.urdf import expand_urdf
from soft_gripper.runs.scores.readings import with_sections
from soft_gripper.scenario.model_files import model_path
from soft_gripper.scenario.nominal_model import read_nominal_model
from soft_gripper.scenario.scenario_file import load_scenario
from soft_gripper.scenario.schema import NominalConfig, SensorConfig, StrainErrorsConfig
from soft_gripper.scenario.sensor_presets import sensor_layout, strain_errors
from soft_gripper.sensors.measurement import MeasurementModel
from soft_gripper.sensors.strain_errors import StrainErrors
from soft_gripper.truth.poses import fingertip_error, pose_error
from studies.robustness.plants import FingerAtRest, Plant

Key = TypeVar("Key")
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
    moves = (Places(nominal, BENDS).moves(estimate.q) * normals[..., None, :, :]).sum(axis=-1)  # (..., D, N + 1)
    variance = ((estimate.covariance @ moves) * moves).sum(axis=-2)
    within: NDArray[np.bool_] = (np.abs(across) <= BAND * np.sqrt(np.maximum(variance, 0)))[..., 1:]
    return within


def together(parts: list[Errors]) -> Errors:
    """All samples in one."""
    return Errors(*(np.concatenate(part) for part in zip(*parts, strict=True)))


def together_by(fingers: Iterable[Iterable[tuple[Key, Errors]]]) -> dict[Key, Errors]:
    """The errors of all fingers for each key."""
    found: dict[Key, list[Errors]] = defaultdict(list)
    for key, errors in chain.from_iterable(fingers):
        found[key].append(errors)
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
    """A row for every nominal model, number of sections and estimator, in this order, at one noise.

    Without noise all seeds would be the same, and one is enough.
    """
    each = (_errors(finger, noise, seeds if noise else 1, estimators, nominal_errors) for finger in fingers)
    return [
        RobustnessRow(name, estimator, nominal, noise, sections, *in_mm(errors), seeds)
        for (estimator, nominal, sections), errors in together_by(each).items()
    ]


def _errors(
    held: FingerAtRest, noise: float, seeds: int, estimators: Sequence[str], nominal_errors: Sequence[NominalError]
) -> Iterator[tuple[tuple[str, str, int], Errors]]:
    errors, sensor = errors_at(noise), held.station.scenario.sensor
    readings = {sections: held.readings(sections, errors, seeds) for sections in SECTIONS}
    for nominal_error in nominal_errors:
        nominal = read_nominal_model(nominal_error.config).layout(held.simulated, sensor)
        uncertainty = uncertainty_of(errors, None, nominal_error.size)
        for sections in SECTIONS:
            layout = with_sections(nominal, sections)
            for estimator in estimators:
                found = estimated(estimator, layout, uncertainty, held, readings[sections], 1 + nominal_error.pressure)
                yield (estimator, nominal_error.name, sections), found


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
    """A row for every number of sections and estimator, in this order; of rubber with realistic sensors, else ideal."""
    rows = []
    each = (_plant_errors(plant, name, held, seeds, estimators) for held in fingers)
    for (sections, estimator), errors in together_by(each).items():
        mean, p95, worst, coverage = in_mm(errors)
        tip = 1e3 * float(errors.tip.mean())
        rows.append(PlantRow(plant.name, name, estimator, sections, mean, p95, worst, tip, coverage, seeds))
    return rows


def _plant_errors(
    plant: Plant, name: str, held: FingerAtRest, seeds: int, estimators: Sequence[str]
) -> Iterator[tuple[tuple[int, str], Errors]]:
    errors = errors_at(1.0) if plant.rubber else None
    nominal = shipped_finger(name, held.simulated.name) if plant.rubber else held.simulated
    uncertainty = uncertainty_of(errors, None, MODULUS) if plant.rubber else Uncertainty(bend_per_pressure=EXACT)
    layout = sensor_layout(nominal, held.station.scenario.sensor)
    for sections in SECTIONS:
        readings: Array = held.readings(sections, errors, seeds if plant.rubber else 1)
        for estimator in estimators:
            found = estimated(estimator, with_sections(layout, sections), uncertainty, held, readings)
            yield (sections, estimator), found


def shipped_finger(scenario: str, name: str) -> Finger:
    """A finger of a shipped scenario, by its name; of a model with a single finger it is that of the model."""
    for model in load_scenario(scenario).models:
        if model.file.endswith(".urdf"):
            fingers = {finger.name: finger for finger in expand_urdf(model_path(model.file)).fingers}
            if name in fingers or (model.name == name and len(fingers) == 1):
                return fingers.get(name) or next(iter(fingers.values()))
    raise KeyError(name)
