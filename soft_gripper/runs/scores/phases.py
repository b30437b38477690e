"""The phases that a task went through."""

from dataclasses import dataclass

import xarray as xr

from soft_gripper.control.task_phases import Outcome
from soft_gripper.diagrams.recording.phase_spans import phase_spans
from soft_gripper.diagrams.recording.recording import Recording
from soft_gripper.diagrams.station_parts import Station


@dataclass(frozen=True)
class PhaseRow:
    """One phase; opening, torque and pressure are the estimated or measured ones at its end."""

    phase: str
    began_s: float
    lasted_s: float
    opening_mm: float
    torque_mnm: float
    pressure_kpa: float


def phase_table(station: Station, recording: Recording) -> list[PhaseRow]:
    """A row for every phase that the task of the station went through, in order."""
    assert station.task is not None
    pressure = f"{station.fingers[0].name}.sampled_pressure" if station.fingers else ""
    rows = []
    for phase, begin, end in phase_spans(recording, station.task.phases):
        now = recording.data.sel(time=end)
        opening, torque, pascals = (_value(now, name) for name in ("grip.opening", "grip.torque", pressure))
        rows.append(PhaseRow(phase.name, begin, end - begin, 1e3 * opening, 1e3 * torque, pascals / 1e3))
    return rows


def _value(now: xr.Dataset, signal: str) -> float:
    """A signal; NaN if it was not recorded, as those of the grip in a task that does not command it."""
    return float(now[signal]) if signal in now else float("nan")


def outcome(recording: Recording) -> Outcome:
    """How the task stood when the recording ended."""
    return Outcome(int(recording["task.outcome"].values[-1]))
