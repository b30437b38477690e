"""What trials of pick and place came to, as a figure."""

from collections.abc import Mapping, Sequence
from typing import Any

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Circle
from matplotlib.ticker import MaxNLocator

from soft_gripper.pictures.style import STYLE
from soft_gripper.runs.trials.trial import MAX_PLACED_ANGLE, MAX_PLACED_ERROR, MAX_SLIP, Trial

GOOD, BAD = "#2166ac", "#b2182b"
RIM = 1.3  # of a limit: where what is far beyond it is drawn
MEASURES = {  # columns of the rows
    "placed_error_mm": "placed error [mm]",
    "placed_angle_deg": "placed angle [degrees]",
    "slip_mm": "slip [mm]",
    "peak_force_n": "peak force [N]",
    "detection_delay_ms": "detection delay [ms]",
}


def trials_figure(trials: Sequence[Trial], force_limits: Mapping[str, float | None]) -> Figure:
    """Where the objects ended about the goal, and measures in order of size; a row of panels a scenario.

    `force_limits` are those of the scenarios, N; None: there is none.
    """
    scenarios = list(dict.fromkeys(trial.row.scenario for trial in trials))
    with mpl.rc_context(STYLE):
        figure = Figure(figsize=(14, 2.7 * len(scenarios)), layout="constrained")
        panels = figure.subplots(len(scenarios), 1 + len(MEASURES), squeeze=False, sharex="col")
        for row, scenario in zip(panels, scenarios, strict=True):
            found = [trial for trial in trials if trial.row.scenario == scenario]
            _draw_places(row[0], found)
            limits = {
                "placed_error_mm": MAX_PLACED_ERROR,
                "placed_angle_deg": MAX_PLACED_ANGLE,
                "slip_mm": MAX_SLIP,
                "peak_force_n": force_limits[scenario] or 0.0,
            }
            for axes, measure in zip(row[1:], MEASURES, strict=True):
                _draw_measure(axes, found, measure, limits.get(measure, 0.0))
            row[0].set_title(scenario.replace("_", " ").capitalize(), loc="left")
            row[1].set_ylabel("trials, cumulative")
        for axes, label in zip(panels[-1], ("x from the goal [mm]", *MEASURES.values()), strict=True):
            axes.set_xlabel(label)
        for axes in panels[-1][1:]:
            axes.set_xlim(0, 1.02 * axes.get_xlim()[1])
    return figure


def _draw_places(axes: Axes, trials: Sequence[Trial]) -> None:
    """Where the objects ended; those far beyond the circle lie on the rim, in their direction."""
    axes.add_patch(Circle((0, 0), MAX_PLACED_ERROR, fill=False, ls="--", ec="0.4"))
    axes.plot(0, 0, "+", color="0.4", ms=10)
    for trial in trials:
        place = np.array([trial.details.placed_x_mm, trial.details.placed_y_mm])
        axes.plot(*place * min(1.0, RIM * MAX_PLACED_ERROR / max(np.hypot(*place), 1e-9)), **_look(trial))
    end = 1.1 * RIM * MAX_PLACED_ERROR
    axes.set(xlim=(-end, end), ylim=(-end, end), aspect="equal", ylabel="y [mm]")


def _draw_measure(axes: Axes, trials: Sequence[Trial], measure: str, limit: float) -> None:
    """The trials in order of a measure: how many stay below a value. `limit` 0: none."""
    rim = RIM * limit if limit > 0 else np.inf
    measured = [trial for trial in trials if not np.isnan(getattr(trial.row, measure))]
    for rank, trial in enumerate(sorted(measured, key=lambda trial: getattr(trial.row, measure)), start=1):
        axes.plot(min(getattr(trial.row, measure), rim), rank, **_look(trial))
    if limit > 0:
        axes.axvline(limit, color="0.4", ls="--")
    axes.set_ylim(0, len(trials) + 1)
    axes.yaxis.set_major_locator(MaxNLocator(integer=True))


def _look(trial: Trial) -> dict[str, Any]:
    """A dot for a success, a cross for a failure."""
    success = trial.row.success
    return {"marker": "o" if success else "x", "ms": 4, "color": GOOD if success else BAD, "clip_on": False}
