"""Held steps: which samples of a recording belong to the hold at the end of each step of pressure."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from soft_gripper.arrays import Array
from soft_gripper.diagrams.recording.recording import Recording
from soft_gripper.diagrams.schema.scenario import Scenario


@dataclass(frozen=True)
class HeldStep:
    """Of which finger, estimator and step a row of a table is."""

    scenario: str
    finger: str
    estimator: str
    belief: str
    sections: int
    pressure_kpa: float


def held_samples(scenario: Scenario, recording: Recording, signal: str | Array) -> Array:
    """The averaged samples of every step, (steps, hold_samples, ...).

    `signal` is the name of one, or values for every sample of the recording, (T, ...).
    """
    values: Array = recording[signal].values if isinstance(signal, str) else signal
    return values[held_rows(scenario, recording)]


def held_rows(scenario: Scenario, recording: Recording) -> NDArray[np.int_]:
    """Which samples of the recording are averaged in every step, (steps, hold_samples)."""
    period, hold = scenario.sensor.period, scenario.pressure.hold_samples
    ends = (np.arange(scenario.steps) + 1) * scenario.step_duration
    last = np.searchsorted(recording["time"].values, ends + period / 2) - 1
    rows: NDArray[np.int_] = last[:, None] + np.arange(-hold + 1, 1)
    return rows
