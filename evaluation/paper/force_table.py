"""External torques of a run, estimated and true: as recorded, or for several numbers of sensor sections."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from soft_gripper.arrays import Array
from soft_gripper.diagrams.recording.recording import Recording
from soft_gripper.diagrams.station_parts import Station
from soft_gripper.diagrams.wiring.belief import describe_belief
from soft_gripper.diagrams.wiring.pressure_steps import pressure_steps
from soft_gripper.evaluation.paper.held_steps import HeldStep, held_samples
from soft_gripper.evaluation.paper.readings_again import external_torque_again, read_again
from soft_gripper.fingers.plant_finger import PlantFinger


@dataclass(frozen=True)
class ForceRow(HeldStep):
    """Averages over one held step at one joint, counted from the base."""

    joint: int
    estimated_nm: float
    true_nm: float


def force_table(name: str, station: Station, recording: Recording, sections: Sequence[int]) -> list[ForceRow]:
    """A row for every finger, number of sections, held step and joint, in this order, of the estimator `arcs`."""
    rows: list[ForceRow] = []
    for finger in station.fingers:
        for count in sections:
            again = read_again(station, recording, finger, count)
            estimate = external_torque_again(station, recording, finger, again)
            rows += _rows(name, station, recording, finger, "arcs", count, estimate)
    return rows


def recorded_force_table(name: str, station: Station, recording: Recording) -> list[ForceRow]:
    """A row for every finger, held step and joint, of the estimator of the scenario."""
    rows: list[ForceRow] = []
    for finger in station.fingers:
        estimate = recording[f"{finger.name}.external_torque"].values
        rows += _rows(
            name, station, recording, finger, station.parts.estimator, station.scenario.sensor.sections, estimate
        )
    return rows


def _rows(
    name: str,
    station: Station,
    recording: Recording,
    finger: PlantFinger,
    estimator: str,
    sections: int,
    torque: Array,
) -> Iterator[ForceRow]:
    """The rows of one finger from its estimated torque at every sample, N m, (T, N)."""
    scenario = station.scenario
    steps, belief = pressure_steps(scenario.pressure, finger.name) / 1e3, describe_belief(scenario.believed)
    estimated = held_samples(scenario, recording, torque).mean(axis=1)
    true = held_samples(scenario, recording, f"{finger.name}.true_external_torque").mean(axis=1)
    for step, joint in np.ndindex(estimated.shape):
        values = float(estimated[step, joint]), float(true[step, joint])
        yield ForceRow(name, finger.name, estimator, belief, sections, float(steps[step]), joint, *values)
