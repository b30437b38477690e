"""The phases that a task went through."""

from dataclasses import dataclass

from soft_gripper.diagrams.phase_spans import phase_spans
from soft_gripper.diagrams.recording import Recording
from soft_gripper.diagrams.station import Station
from soft_gripper.task_phases import Outcome


@dataclass(frozen=True)
class PhaseRow:
    """One phase; distance, torque and pressure are the estimated or measured ones at its end."""

    phase: str
    began_s: float
    lasted_s: float
    distance_mm: float
    torque_mnm: float
    pressure_kpa: float


def phase_table(station: Station, recording: Recording) -> list[PhaseRow]:
    """A row for every phase that the task of the station went through, in order."""
    assert station.task is not None
    pressure = f"{station.fingers[0].name}.sampled_pressure"
    rows = []
    for phase, begin, end in phase_spans(recording, station.task.phases):
        now = recording.data.sel(time=end)
        distance, torque, pascals = (float(now[name]) for name in ("grip.distance", "grip.torque", pressure))
        rows.append(PhaseRow(phase.name, begin, end - begin, 1e3 * distance, 1e3 * torque, pascals / 1e3))
    return rows


def outcome(recording: Recording) -> Outcome:
    """How the task stood when the recording ended."""
    return Outcome(int(recording["task.outcome"].values[-1]))
