"""External torques of a run, estimated and true, as recorded."""

from collections.abc import Iterator, Sequence
from dataclasses import astuple, dataclass

import numpy as np

from soft_gripper.arrays import Array
from soft_gripper.diagrams.recording import Recording
from soft_gripper.diagrams.station_parts import Station
from soft_gripper.fingers.plant_finger import PlantFinger
from soft_gripper.runs.scores.poses import HeldStep, held_samples, held_steps


@dataclass(frozen=True)
class ForceRow(HeldStep):
    """Averages over one held step at one joint, counted from the base."""

    joint: int
    estimated_nm: float
    true_nm: float


def recorded_force_table(name: str, station: Station, recording: Recording) -> list[ForceRow]:
    """A row for every finger, held step and joint, of the estimator of the scenario."""
    rows: list[ForceRow] = []
    for finger in station.fingers:
        estimate = recording[f"{finger.name}.external_torque"].values
        rows += force_rows(held_steps(name, station, finger), station, recording, finger, estimate)
    return rows


def force_rows(
    steps: Sequence[HeldStep], station: Station, recording: Recording, finger: PlantFinger, torque: Array
) -> Iterator[ForceRow]:
    """The rows of one finger from its estimated torque at every sample, N m, (T, N)."""
    scenario = station.scenario
    estimated = held_samples(scenario, recording, torque).mean(axis=1)
    true = held_samples(scenario, recording, f"{finger.name}.true_external_torque").mean(axis=1)
    for step, joint in np.ndindex(estimated.shape):
        values = float(estimated[step, joint]), float(true[step, joint])
        yield ForceRow(*astuple(steps[step]), *[joint, *values])
