"""How well a closed loop follows the steps of its set point."""

from dataclasses import dataclass

import numpy as np

from soft_gripper.arrays import Array
from soft_gripper.diagrams.recording.recording import Recording
from soft_gripper.diagrams.station_parts import Station
from soft_gripper.estimation.gripper_opening import Gripper
from soft_gripper.evaluation.true_chain import true_chain
from soft_gripper.fingers.kinematics import as_points

BAND = 0.02  # of the step, within which the opening has settled
STEADY = 0.5  # s at the end of a step, over which the steady error is averaged


@dataclass(frozen=True)
class StepRow:
    """One step of the opening of the gripper; overshoot, crossings and settling of the estimated opening.

    `crossings` is how often the opening goes from one side of the band around the set point to the other.
    """

    step: int
    from_mm: float
    to_mm: float
    overshoot_percent: float
    crossings: int
    settling_s: float
    steady_error_estimated_mm: float
    steady_error_true_mm: float


def step_table(station: Station, recording: Recording) -> list[StepRow]:
    """A row for every set point of the scenario's closed loop."""
    time = recording.data["time"].values
    estimated, true = recording["grip.opening"].values, true_opening(station, recording)
    hold = station.scenario.control.hold
    rows = []
    begin = float(estimated[0])
    for step, end in enumerate(station.scenario.control.set_points or []):
        during = (time > step * hold + 1e-9) & (time <= (step + 1) * hold + 1e-9)
        since = time[during] - step * hold
        last = since > hold - STEADY
        opening = estimated[during]
        steady = (float((signal[during][last] - end).mean()) * 1e3 for signal in (estimated, true))
        rows.append(StepRow(step, 1e3 * begin, 1e3 * end, *_follow(since, opening, begin, end), *steady))
        begin = float(opening[-1])
    return rows


def _follow(since: Array, opening: Array, begin: float, end: float) -> tuple[float, int, float]:
    """Overshoot, percent of the step, crossings, and when, s, the opening stays within the band; NaN if it does not."""
    beyond = (opening - end) / (end - begin)  # -1 where the step begins
    overshoot = max(0.0, float(beyond.max())) * 100
    outside = np.flatnonzero(np.abs(beyond) > BAND)
    if len(outside) == 0:
        return overshoot, 0, 0.0
    crossings = int(np.count_nonzero(np.diff(np.sign(beyond[outside]))))
    settled = outside[-1] + 1 < len(since)
    return overshoot, crossings, float(since[outside[-1] + 1]) if settled else float("nan")


def true_opening(station: Station, recording: Recording) -> Array:
    """True opening of the gripper at every sample, m."""
    tips = np.stack([as_points(true_chain(recording, finger).tip) for finger in station.fingers], axis=1)
    return Gripper.of_bases([finger.X_WB for finger in station.fingers]).opening(tips)
