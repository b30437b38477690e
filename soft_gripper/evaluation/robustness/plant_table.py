"""Errors with other plants: fingers that are known as they are, and one of rubber that is believed to be linear.

Where plant and estimator are the same chain, an estimator may be right for the wrong reason: what a chain of twelve
linear joints cannot be is wrong in both. So the rubber finger has twice the segments, another elastic law and another
time step, its sensors have errors, and the estimators go on believing in the shipped one, whose modulus they know to a
tenth.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from soft_gripper.arrays import Array
from soft_gripper.estimators.uncertainty import Uncertainty, uncertainty_of
from soft_gripper.evaluation.paper.scenario_run import SECTIONS
from soft_gripper.evaluation.robustness.plants import FingerAtRest, Plant
from soft_gripper.evaluation.robustness.sample_errors import Errors, estimated, in_mm, together
from soft_gripper.evaluation.robustness.table import errors_at
from soft_gripper.fingers.finger import Finger
from soft_gripper.fingers.urdf import expand_urdf
from soft_gripper.runs.scores.readings import with_sections
from soft_gripper.scenario.model_files import model_path
from soft_gripper.scenario.scenario_file import load_scenario
from soft_gripper.scenario.sensor_presets import sensor_layout

MODULUS = 0.1  # share, standard deviation of what is believed of the modulus of rubber


@dataclass(frozen=True)
class PlantRow:
    """Of all touched fingers, held samples and seeds together."""

    plant: str
    scenario: str
    estimator: str
    sections: int
    mean_mm: float
    p95_mm: float  # 95th percentile
    worst_mm: float
    tip_mm: float  # mean
    coverage: float  # share of places in their 95 % bands; NaN for an estimator that gives no covariance
    seeds: int


def plant_table(
    plant: Plant, name: str, fingers: Sequence[FingerAtRest], seeds: int, estimators: Sequence[str]
) -> list[PlantRow]:
    """A row for every number of sections and estimator, in this order; of rubber with realistic sensors, else ideal."""
    found: dict[tuple[int, str], list[Errors]] = {}
    for held in fingers:
        for key, errors in _errors(plant, name, held, seeds, estimators):
            found.setdefault(key, []).append(errors)
    rows = []
    for (sections, estimator), parts in found.items():
        errors = together(parts)
        mean, p95, worst, coverage = in_mm(errors)
        tip = 1e3 * float(errors.tip.mean())
        rows.append(PlantRow(plant.name, name, estimator, sections, mean, p95, worst, tip, coverage, seeds))
    return rows


def _errors(
    plant: Plant, name: str, held: FingerAtRest, seeds: int, estimators: Sequence[str]
) -> Iterator[tuple[tuple[int, str], Errors]]:
    errors = errors_at(1.0) if plant.rubber else None
    believed = shipped_finger(name, held.simulated.name) if plant.rubber else held.simulated
    uncertainty = uncertainty_of(errors, None, MODULUS) if plant.rubber else Uncertainty()
    layout = sensor_layout(believed, held.station.scenario.sensor)
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
