"""The figures of the paper, from the rows of the evaluation."""

from collections.abc import Sequence

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from soft_gripper.extras.paper.forces import ContactForceRow
from soft_gripper.pictures.style import STYLE, section_style
from soft_gripper.runs.scores.external_torques import ForceRow
from soft_gripper.runs.scores.poses import HeldStep, PoseRow

ERRORS = {"pose_error_mm": "mean pose error [mm]", "tip_error_mm": "fingertip error [mm]"}
PRESSURE, BEND = ("pressure_kpa", "pressure [kPa]"), ("bend_angle_deg", "bend angle [degrees]")
NOTHING = 1e-3  # mm; a straight finger has no error but rounding, which would fill a logarithmic axis


def free_bending_figure(rows: Sequence[PoseRow]) -> Figure:
    """Fig. 5: pose error (left) and fingertip error (right) against the bend angle, 1 to 4 sensors, on equal scales."""
    with mpl.rc_context(STYLE):
        figure = Figure(figsize=(8, 3.4), layout="constrained")
        for axes, (error, label) in zip(figure.subplots(1, 2, sharex=True, sharey=True), ERRORS.items(), strict=True):
            _draw_errors(axes, rows, BEND[0], error)
            axes.set(title=label.split(" [")[0].capitalize(), xlabel=BEND[1])
            axes.axvline(0, color="0.8", lw=0.8, zorder=0)
        figure.axes[0].set(ylabel="error [mm]", ylim=(0, None))
        figure.axes[0].legend(title="sensors per side", frameon=False)
    return figure


def contact_figure(rows: Sequence[PoseRow], scenarios: Sequence[str], error: str) -> Figure:
    """Fig. 6 (pose error) or 7 (fingertip error): a panel a contact scenario, on equal scales.

    They are logarithmic: two to four sensors differ by factors, and one errs so much more that it hides them. Steps
    without an error are left out, as they have no place on such an axis.
    """
    with mpl.rc_context(STYLE):
        figure = Figure(figsize=(8, 5.6), layout="constrained")
        panels = figure.subplots(2, 2, sharey=True).flat
        for axes, scenario in zip(panels, scenarios, strict=False):
            scenario_rows = [row for row in rows if row.scenario == scenario]
            _draw_errors(axes, scenario_rows, PRESSURE[0], error, min_error=NOTHING)
            axes.set(title=scenario.replace("_", " ").capitalize(), xlabel=PRESSURE[1], yscale="log")
            run_with_pressure(axes, scenario_rows)
        figure.axes[0].yaxis.set_major_formatter("{x:g}")
        for axes in figure.axes[::2]:
            axes.set_ylabel(ERRORS[error])
        figure.axes[0].legend(title="sensors per side", frameon=False, loc="lower right", ncols=2)
    return figure


def run_with_pressure(axes: Axes, rows: Sequence[HeldStep]) -> None:
    """Starts an axis of pressure at the first step, so that a growing vacuum runs to the right too."""
    first_pressure = rows[0].pressure_kpa
    last_pressure = max((row.pressure_kpa for row in rows), key=lambda pressure: abs(pressure - first_pressure))
    margin = 0.04 * (last_pressure - first_pressure)
    axes.set_xlim(first_pressure - margin, last_pressure + margin)


def _draw_errors(axes: Axes, rows: Sequence[PoseRow], x: str, error: str, min_error: float = -np.inf) -> None:
    """Plots a line for each number of sections, averaged over the fingers and the steps of equal pressure.

    Args:
        min_error: no smaller errors are drawn.
    """
    for sections in sorted({row.sections for row in rows}):
        step_rows: dict[float, list[PoseRow]] = {}
        for row in rows:
            if row.sections == sections:
                step_rows.setdefault(row.pressure_kpa, []).append(row)
        x_values, errors = (
            np.array([np.mean([getattr(row, column) for row in step]) for _, step in sorted(step_rows.items())])
            for column in (x, error)
        )
        is_drawn = errors > min_error
        axes.plot(x_values[is_drawn], errors[is_drawn], **section_style(sections))


_UNEQUAL_COLOR = "#5aa02c"  # color of a second layout of as many sections


def force_figure(rows: Sequence[ForceRow], scenarios: Sequence[str]) -> Figure:
    """Plots torque along the first finger at the last step, true and estimated; below, the mean error."""
    with mpl.rc_context(STYLE):
        figure = Figure(figsize=(3 * len(scenarios), 5.4), layout="constrained")
        torque_row, error_row = figure.subplots(2, len(scenarios), sharey="row", squeeze=False)
        for torque_axes, error_axes, scenario in zip(torque_row, error_row, scenarios, strict=True):
            scenario_rows = [row for row in rows if row.scenario == scenario]
            _draw_torques(torque_axes, scenario_rows)
            _draw_mean_errors(error_axes, scenario_rows)
            run_with_pressure(error_axes, scenario_rows)
            torque_axes.set(title=scenario.replace("_", " ").capitalize(), xlabel="joint, from the base")
            error_axes.set(xlabel="pressure [kPa]")
        torque_row[0].set_ylabel("external torque [mN m]")
        error_row[0].set_ylim(bottom=0)  # of all of them, now that every error is drawn
        error_row[0].set_ylabel("mean error over the joints [mN m]")
        torque_row[0].legend(frameon=False, fontsize="small", title="sensors per side")
    return figure


def _draw_torques(axes: Axes, rows: Sequence[ForceRow]) -> None:
    last_rows = [row for row in rows if row.finger == rows[0].finger and row.pressure_kpa == rows[-1].pressure_kpa]
    for sections in sorted({row.sections for row in last_rows}):
        torque = [1e3 * row.estimated_nm for row in last_rows if row.sections == sections]
        axes.plot(torque, **section_style(sections))
    truth = [1e3 * row.true_nm for row in last_rows if row.sections == sections]
    axes.plot(truth, color="black", lw=2, ls=(0, (2, 1)), label="truth")


def _draw_mean_errors(axes: Axes, rows: Sequence[ForceRow]) -> None:
    for sections in sorted({row.sections for row in rows}):
        errors: dict[float, list[float]] = {}
        for row in rows:
            if row.sections == sections:
                errors.setdefault(row.pressure_kpa, []).append(1e3 * abs(row.estimated_nm - row.true_nm))
        pressures = sorted(errors)
        axes.plot(pressures, [np.mean(errors[pressure]) for pressure in pressures], **section_style(sections))


def contact_force_figure(rows: Sequence[ContactForceRow], scenarios: Sequence[str]) -> Figure:
    """Plots force and location of the contact of the first finger against pressure, true, and for every layout."""
    with mpl.rc_context(STYLE):
        figure = Figure(figsize=(3 * len(scenarios), 5.4), layout="constrained")
        force_row, place_row = figure.subplots(2, len(scenarios), sharex="col", squeeze=False)
        for force, place, scenario in zip(force_row, place_row, scenarios, strict=True):
            scenario_rows = [row for row in rows if row.scenario == scenario]
            scenario_rows = [row for row in scenario_rows if row.finger == scenario_rows[0].finger]
            _draw_estimates(force, scenario_rows, "n")
            _draw_estimates(place, scenario_rows, "mm")
            run_with_pressure(force, scenario_rows)
            force.set_title(scenario.replace("_", " ").capitalize())
            force.axhline(0, color="0.8", lw=0.8, zorder=0)
            place.set(xlabel="pressure [kPa]", ylim=(0, 125))
        force_row[0].set_ylabel("contact force [N]")
        place_row[0].set_ylabel("contact location [mm]")
        place_row[0].legend(frameon=False, fontsize="small", title="sections per side, where they meet")
    return figure


def _draw_estimates(axes: Axes, rows: Sequence[ContactForceRow], unit: str) -> None:
    layouts = dict.fromkeys((row.sections, row.borders) for row in rows)
    numbers = [sections for sections, _ in layouts]
    for i, (sections, borders) in enumerate(layouts):
        layout_rows = [row for row in rows if row.borders == borders]
        style = section_style(sections) | ({"color": _UNEQUAL_COLOR, "marker": "v"} if sections in numbers[:i] else {})
        values = [getattr(row, f"estimated_{unit}") for row in layout_rows]
        style |= {"mfc": "none", "label": f"{sections}: {borders} mm"}
        axes.plot([row.pressure_kpa for row in layout_rows], values, **style)
    truth = [getattr(row, f"true_{unit}") for row in layout_rows]
    axes.plot([row.pressure_kpa for row in layout_rows], truth, color="black", lw=2, ls=(0, (2, 1)), label="truth")
