"""Placements as rows of tables."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Polygon

from soft_gripper.diagrams.station_parts import Station
from soft_gripper.errors import InputError
from soft_gripper.extras.hardware.recorded_run import RecordedRun
from soft_gripper.extras.placement.place_sensors import PlacedSensors
from soft_gripper.extras.placement.placements import Placement, as_borders, equal_placement
from soft_gripper.extras.placement.samples import Assumptions
from soft_gripper.extras.studies.contacts.contacts import Contacts
from soft_gripper.fingers.finger import Finger
from soft_gripper.pictures.style import STYLE
from soft_gripper.scenario.named_estimators import estimator_function
from soft_gripper.scenario.schema import Scenario
from soft_gripper.sensors.sensor_layout import SensorLayout


@dataclass(frozen=True)
class PlacementRow:
    """One placement; NaN where no contacts were given."""

    rank: int
    borders: str  # shares of the length
    pose_error_mm: float  # the mean over all runs, by which it is ranked
    force_error_n: float
    place_error_mm: float
    missed_percent: float


@dataclass(frozen=True)
class RunRow:
    """One placement in one run."""

    rank: int
    borders: str
    run: str
    pose_error_mm: float


@dataclass(frozen=True)
class LeftOutRow:
    """A run, with equal sections and with the placement found without it."""

    run: str
    borders: str
    equal_mm: float
    placed_mm: float
    gain_percent: float  # positive where the placement is better


def placement_rows(placed: PlacedSensors) -> list[PlacementRow]:
    """A row for every placement, the best first."""
    rows = []
    for i, (placement, error) in enumerate(zip(placed.placements, placed.mean_pose_errors, strict=True)):
        contact = (np.nan,) * 3
        if placed.contacts is not None:
            found = placed.contacts[i]
            contact = found.force, 1e3 * found.place, 100 * found.missed
        rows.append(PlacementRow(i + 1, describe(placement, placed.finger), 1e3 * float(error), *contact))
    return rows


def run_rows(placed: PlacedSensors) -> list[RunRow]:
    """A row for every placement and run, in this order."""
    return [
        RunRow(i + 1, describe(placement, placed.finger), run, 1e3 * float(error))
        for i, (placement, errors) in enumerate(zip(placed.placements, placed.pose_errors, strict=True))
        for run, error in zip(placed.runs, errors, strict=True)
    ]


def left_out_rows(placed: PlacedSensors) -> list[LeftOutRow]:
    """A row for every run that was left out."""
    return [
        LeftOutRow(
            row.run,
            describe(row.placement, placed.finger),
            1e3 * row.equal,
            1e3 * row.placed,
            100 * (1 - row.placed / row.equal),
        )
        for row in placed.left_out
    ]


def describe(placement: Placement, finger: Finger) -> str:
    """Borders as shares of the length, as text for tables."""
    return " ".join(f"{border:.4g}" for border in as_borders(placement, finger.segments)) or "none"


_SHADES = "#9ecae1", "#deebf7"
_MEAN, _EQUAL = "#b2182b", "0.35"


def placement_figure(placed: PlacedSensors) -> Figure:
    """Best, equal and worst sections along the finger, its base to the left; below, errors against the rank."""
    with mpl.rc_context(STYLE):
        figure = Figure(figsize=(7.5, 5.8), layout="constrained")
        *fingers, errors = figure.subplots(4, 1, gridspec_kw={"height_ratios": [1, 1, 1, 4.5]})
        drawn = {"best": 0, "equal": placed.equal, "worst": len(placed.placements) - 1}
        for axes, (name, i) in zip(fingers, drawn.items(), strict=True):
            error = 1e3 * placed.mean_pose_errors[i]
            axes.set_title(f"{name}: {error:.3f} mm, rank {i + 1}", loc="left", fontsize=9)
            _draw_finger(axes, placed.finger, placed.placements[i])
        fingers[-1].set_xlabel("from the base [mm]")
        _draw_errors(errors, placed)
    return figure


def _draw_finger(axes: Axes, finger: Finger, placement: Placement) -> None:
    """A side view, with a shade for every section and a line for every segment."""
    ends = np.array([0, *placement, finger.segments]) * 1e3 * finger.segment_length
    for i, (begin, end) in enumerate(pairwise(ends)):
        low, high = (_half_thickness(finger, s) for s in (begin, end))
        corners = [(begin, -low), (end, -high), (end, high), (begin, low)]
        axes.add_patch(Polygon(corners, fc=_SHADES[i % 2], ec="0.2", lw=1.2))
    for s in np.arange(1, finger.segments) * 1e3 * finger.segment_length:
        axes.plot([s, s], [-2, 2], color="0.5", lw=0.6)
    most = 1.05 * max(_half_thickness(finger, s) for s in (0.0, 1e3 * finger.length))
    axes.set(xlim=(-2, 1e3 * finger.length + 2), ylim=(-most, most), aspect="equal", yticks=[])
    axes.set_xticks(ends, [f"{end:.0f}" for end in ends], fontsize=7)
    axes.grid(visible=False)
    axes.spines["left"].set_visible(False)


def _half_thickness(finger: Finger, s: float) -> float:
    """At s mm from the base, mm."""
    return float(500 * finger.section(1e-3 * s).thickness)


def _draw_errors(axes: Axes, placed: PlacedSensors) -> None:
    ranks = np.arange(1, len(placed.placements) + 1)
    marker = "o" if len(ranks) < 30 else None
    for run, errors in zip(placed.runs, placed.pose_errors.T, strict=True):
        axes.plot(ranks, 1e3 * errors, lw=0.9, marker=marker, ms=2.5, label=run.replace("_", " "))
    axes.plot(ranks, 1e3 * placed.mean_pose_errors, color=_MEAN, lw=2.2, marker=marker, ms=4, label="mean")
    axes.axvline(placed.equal + 1, color=_EQUAL, ls="--", lw=1, label="equal sections")
    axes.set(xlabel="rank of the placement", ylabel="mean pose error [mm]", ylim=(0, None))
    axes.legend(fontsize=8, loc="center left", bbox_to_anchor=(1, 0.5), frameon=False)


_WHERE = "place-sensors"


def check_runs(count: int, runs: Mapping[str, Station | RecordedRun], others: Sequence[Finger] = ()) -> None:
    """Checks the runs by which sensors are placed, before they are simulated or read.

    Raises:
        InputError: unless all runs, by name, have pressure steps, and all their fingers and `others` have equally many
            segments, at least `count`.
    """
    for name, run in runs.items():
        check_has_held_steps(name, run.scenario)
    fingers = [*others, *(finger.finger for run in runs.values() for finger in run.fingers)]
    for finger in fingers:
        equal_placement(finger, count)
    segments = sorted({finger.segments for finger in fingers})
    if len(segments) > 1:
        expected = "choose runs and contacts whose fingers have equally many; borders are between segments"
        raise InputError(_WHERE, "segments", segments, expected)


def check_has_held_steps(name: str, scenario: Scenario) -> None:
    """Raises an InputError for a scenario of that name that is not one of pressure steps."""
    others = {"task": scenario.task, "control.set_points": scenario.control.set_points, "external": scenario.external}
    for field, value in others.items():
        if value:
            raise InputError(name, field, "given", "sensors are placed by scenarios with steps of pressure alone")


def check_contacts(contacts: Contacts, assumptions: Assumptions) -> None:
    """Raises an InputError unless the estimator estimates contacts."""
    layout = SensorLayout(contacts.finger, 1)
    estimate = estimator_function(assumptions.estimator, layout, assumptions.uncertainty)
    if estimate(np.zeros(layout.readings), np.zeros(contacts.finger.segments), 0j).contact is None:
        expected = "does not estimate contact; omit --contacts, or give --estimator contact"
        raise InputError(_WHERE, "--estimator", assumptions.estimator, expected)
