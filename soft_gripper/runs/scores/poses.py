"""Pose errors of a run by its own estimator."""

from collections.abc import Iterator, Sequence
from dataclasses import astuple, dataclass
from typing import Annotated

import numpy as np
from numpy.typing import NDArray

from soft_gripper.arrays import Array
from soft_gripper.diagrams.recording import Recording
from soft_gripper.diagrams.station_parts import Station
from soft_gripper.diagrams.wiring.drive import steps_of
from soft_gripper.fingers.plant_finger import PlantFinger
from soft_gripper.scenario.nominal_model import describe_nominal_model
from soft_gripper.scenario.schema import Scenario


@dataclass(frozen=True)
class HeldStep:
    """The finger, estimator and step of a table row."""

    scenario: str
    finger: str
    estimator: str
    nominal: str
    sections: int
    pressure_kpa: Annotated[float, ".1f"]  # NaN unless the finger has one chamber


def held_steps(
    name: str, station: Station, finger: PlantFinger, estimator: str | None = None, sections: int | None = None
) -> list[HeldStep]:
    """The steady states of a finger; by default with the estimator and the number of sections of the scenario."""
    scenario = station.scenario
    keys = name, finger.name, estimator or station.parts.estimator, describe_nominal_model(scenario.nominal)
    pressures = _pressures(scenario, finger)
    return [HeldStep(*keys, sections or scenario.sensor.sections, pressure) for pressure in pressures]


def _pressures(scenario: Scenario, finger: PlantFinger) -> list[float]:
    """Pressures of a finger with one chamber at each step, kPa; NaN for others."""
    if finger.finger.pressures != 1:
        return [np.nan] * scenario.steps
    chambers = [chamber.name for chamber in finger.finger.chambers]
    steps = steps_of("pressure", scenario.pressure.steps, finger.name, chambers)[:, 0] / 1e3
    return [float(steps[min(i, len(steps) - 1)]) for i in range(scenario.steps)]


def held_samples(scenario: Scenario, recording: Recording, signal: str | Array) -> Array:
    """The samples to average in each step, (steps, hold_samples, ...).

    `signal` is a name, or values at each sample of the recording, (T, ...).
    """
    values: Array = recording.values(signal) if isinstance(signal, str) else signal
    return values[held_rows(scenario, recording)]


def held_rows(scenario: Scenario, recording: Recording) -> NDArray[np.int_]:
    """Indices of the samples to average in each step, (steps, hold_samples)."""
    period, hold = scenario.sensor.period, scenario.pressure.hold_samples
    ends = (np.arange(scenario.steps) + 1) * scenario.step_duration
    last = np.searchsorted(recording.values("time"), ends + period / 2) - 1
    return last[:, None] + np.arange(-hold + 1, 1)


@dataclass(frozen=True)
class PoseRow(HeldStep):
    """Averages over the steady state of one step."""

    bend_angle_deg: Annotated[float, ".2f"]
    pose_error_mm: Annotated[float, ".3f"]
    tip_error_mm: Annotated[float, ".3f"]
    sideways_angle_deg: Annotated[float, ".2f"] = 0.0  # of fingers in space, like the bend: the sum over the joints
    twist_angle_deg: Annotated[float, ".2f"] = 0.0


def recorded_pose_table(name: str, station: Station, recording: Recording) -> list[PoseRow]:
    """A row for each finger and steady state, for the estimator of the scenario."""
    rows: list[PoseRow] = []
    for finger in station.fingers:
        signals = (f"{finger.name}.{error}" for error in ("pose_error", "fingertip_error"))
        errors = (held_samples(station.scenario, recording, signal) for signal in signals)
        rows += pose_rows(held_steps(name, station, finger), station, recording, finger, *errors)
    return rows


def pose_rows(
    steps: Sequence[HeldStep], station: Station, recording: Recording, finger: PlantFinger, pose: Array, tip: Array
) -> Iterator[PoseRow]:
    """The rows of one finger from its errors at the held samples, m, (steps, hold_samples)."""
    scenario = station.scenario
    turns = (f"{finger.name}.{name}" for name in ("sampled_joint_angles", "true_sideways_angles", "true_twist_angles"))
    bend, *other_turns = (_mean_turn(scenario, recording, name) for name in turns)
    errors = (1e3 * error.mean(axis=-1) for error in (pose, tip))
    for step, *values in zip(steps, bend, *errors, *other_turns, strict=True):
        yield PoseRow(*astuple(step), *map(float, values))


def _mean_turn(scenario: Scenario, recording: Recording, signal: str) -> Array:
    """Sum of the angles of all joints, averaged over each step, (steps) degrees; 0 where the finger is rigid."""
    if signal not in recording:
        return np.zeros(scenario.steps)
    return np.degrees(held_samples(scenario, recording, signal).sum(axis=-1).mean(axis=-1))
