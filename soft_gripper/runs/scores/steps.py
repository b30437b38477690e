"""Step responses of a closed loop: overshoot, settling time and steady error at each set point."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Annotated

import numpy as np

from soft_gripper.arrays import Array
from soft_gripper.control.task import Outcome
from soft_gripper.diagrams.recording import Recording, phase_spans
from soft_gripper.diagrams.station_parts import Station
from soft_gripper.load.opening import Gripper
from soft_gripper.truth.poses import TRUE_TIP

if TYPE_CHECKING:  # imported when a signal is read or drawn
    import xarray as xr
    from matplotlib.figure import Figure


def step_figure(recordings: Mapping[str, Recording]) -> "Figure":
    """Plots the gripper opening (top) and pressure or tension (bottom) over time, with a line per recording."""
    import matplotlib as mpl
    from matplotlib.figure import Figure

    from soft_gripper.pictures.style import STYLE

    with mpl.rc_context(STYLE):
        figure = Figure(figsize=(8, 4.8), layout="constrained")
        distance, pressure = figure.subplots(2, sharex=True, height_ratios=[2, 1])
        for (label, recording), color in zip(recordings.items(), ("#b2182b", "#2166ac", "#5aae61"), strict=False):
            time = recording.data["time"]
            distance.plot(time, 1e3 * recording["grip.opening"], color=color, lw=1.3, label=label)
            kind, scale = ("pressure", 1e-3) if _first_of(recording, "pressure") else ("tension", 1.0)
            pressure.plot(time, scale * recording[_first_of(recording, kind)], color=color, lw=1.3)
        distance.step(time, 1e3 * recording["grip.set_point"], color="black", lw=0.9, ls="--", label="set point")
        distance.set_ylabel("opening [mm]")
        distance.legend(frameon=False, ncols=4, columnspacing=1.2, loc="lower center", bbox_to_anchor=(0.5, 1.0))
        pressure.set(ylabel="pressure [kPa]" if kind == "pressure" else "tension [N]", xlabel="time [s]")
    return figure


def _first_of(recording: Recording, kind: str) -> str:
    """The signal of that kind of the first finger; empty if there is none."""
    return next((str(name) for name in recording.data if str(name).endswith(f".{kind}")), "")


BAND = 0.02  # share of the step; the opening has settled within this band
STEADY = 0.5  # s at the end of a step, over which the steady error is averaged


@dataclass(frozen=True)
class StepRow:
    """One step of the gripper opening; overshoot, crossings and settling refer to the estimated opening.

    `crossings` counts how often the opening passes from one side of the band around the set point to the other.
    """

    step: int
    from_mm: Annotated[float, ".1f"]
    to_mm: Annotated[float, ".1f"]
    overshoot_percent: Annotated[float, ".2f"]
    crossings: int
    settling_s: Annotated[float, ".2f"]
    steady_error_estimated_mm: Annotated[float, ".4f"]
    steady_error_true_mm: Annotated[float, ".3f"]


def step_table(station: Station, recording: Recording) -> list[StepRow]:
    """A row for each set point of the scenario's closed loop."""
    time = recording.data["time"].values
    estimated, true = recording.values("grip.opening"), true_opening(station, recording)
    hold = station.scenario.control.hold
    rows = []
    begin = float(estimated[0])
    for step, end in enumerate(station.scenario.control.set_points or []):
        is_in_step = (time > step * hold + 1e-9) & (time <= (step + 1) * hold + 1e-9)
        since = time[is_in_step] - step * hold
        last = since > hold - STEADY
        opening = estimated[is_in_step]
        steady = (float((signal[is_in_step][last] - end).mean()) * 1e3 for signal in (estimated, true))
        rows.append(StepRow(step, 1e3 * begin, 1e3 * end, *_follow(since, opening, begin, end), *steady))
        begin = float(opening[-1])
    return rows


def _follow(since: Array, opening: Array, begin: float, end: float) -> tuple[float, int, float]:
    """Overshoot, percent of the step; crossings; and settling time, s, NaN if the opening does not settle."""
    progress = (opening - end) / (end - begin)  # -1 at the start of the step
    overshoot = max(0.0, float(progress.max())) * 100
    outside = np.flatnonzero(np.abs(progress) > BAND)
    if len(outside) == 0:
        return overshoot, 0, 0.0
    crossings = int(np.count_nonzero(np.diff(np.sign(progress[outside]))))
    has_settled = outside[-1] + 1 < len(since)
    return overshoot, crossings, float(since[outside[-1] + 1]) if has_settled else float("nan")


def true_opening(station: Station, recording: Recording) -> Array:
    """True gripper opening at each sample, m."""
    tips = np.stack([recording.values(f"{finger.name}.{TRUE_TIP}") for finger in station.fingers], axis=1)
    return Gripper.of_bases([finger.X_WB for finger in station.fingers]).opening(tips)


@dataclass(frozen=True)
class PhaseRow:
    """One phase; opening, torque and pressure are the estimated or measured values at its end."""

    phase: str
    began_s: Annotated[float, ".2f"]
    lasted_s: Annotated[float, ".2f"]
    opening_mm: Annotated[float, ".1f"]
    torque_mnm: Annotated[float, ".1f"]
    pressure_kpa: Annotated[float, ".1f"]


def phase_table(station: Station, recording: Recording) -> list[PhaseRow]:
    """A row for each executed phase of the task, in order."""
    assert station.task is not None
    pressure = f"{station.fingers[0].name}.sampled_pressure" if station.fingers else ""
    rows = []
    for phase, begin, end in phase_spans(recording, station.task.phases):
        data = recording.data.sel(time=end)
        opening, torque, pascals = (_value(data, name) for name in ("grip.opening", "grip.torque", pressure))
        rows.append(PhaseRow(phase.name, begin, end - begin, 1e3 * opening, 1e3 * torque, pascals / 1e3))
    return rows


def _value(data: "xr.Dataset", signal: str) -> float:
    """A signal; NaN if it was not recorded, such as grip signals in a task without grip, or has several entries."""
    return float(data[signal]) if signal in data and data[signal].size == 1 else float("nan")


def outcome(recording: Recording) -> Outcome:
    """The outcome of the task when the recording ended."""
    return Outcome(int(recording.values("task.outcome")[-1]))
