"""External torques of a run, estimated and true: as recorded, or for several numbers of sensor sections."""

from collections.abc import Iterator, Sequence
from dataclasses import astuple, dataclass
from itertools import product

import numpy as np

from soft_gripper.arrays import Array
from soft_gripper.diagrams.recording import Recording
from soft_gripper.diagrams.station_parts import Station
from soft_gripper.fingers.plant_finger import PlantFinger
from soft_gripper.runs.scores.poses import HeldStep, held_samples, held_steps
from soft_gripper.runs.scores.readings import external_torque_again, read_again


@dataclass(frozen=True)
class ForceRow(HeldStep):
    """Averages over one held step at one joint, counted from the base."""

    joint: int
    estimated_nm: float
    true_nm: float


def force_table(
    name: str, station: Station, recording: Recording, sections: Sequence[int], estimators: Sequence[str] = ("arcs",)
) -> list[ForceRow]:
    """A row for every estimator, finger, number of sections, held step and joint, in this order."""
    rows: list[ForceRow] = []
    for estimator, finger, count in product(estimators, station.fingers, sections):
        readings = read_again(station, recording, finger, count)
        estimate = external_torque_again(station, recording, finger, readings, estimator)
        rows += _rows(held_steps(name, station, finger, estimator, count), station, recording, finger, estimate)
    return rows


def recorded_force_table(name: str, station: Station, recording: Recording) -> list[ForceRow]:
    """A row for every finger, held step and joint, of the estimator of the scenario."""
    rows: list[ForceRow] = []
    for finger in station.fingers:
        estimate = recording[f"{finger.name}.external_torque"].values
        rows += _rows(held_steps(name, station, finger), station, recording, finger, estimate)
    return rows


def _rows(
    steps: Sequence[HeldStep], station: Station, recording: Recording, finger: PlantFinger, torque: Array
) -> Iterator[ForceRow]:
    """The rows of one finger from its estimated torque at every sample, N m, (T, N)."""
    scenario = station.scenario
    estimated = held_samples(scenario, recording, torque).mean(axis=1)
    true = held_samples(scenario, recording, f"{finger.name}.true_external_torque").mean(axis=1)
    for step, joint in np.ndindex(estimated.shape):
        values = float(estimated[step, joint]), float(true[step, joint])
        yield ForceRow(*astuple(steps[step]), *[joint, *values])
