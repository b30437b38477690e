"""The force figures: external torque along the fingers and its error; contact forces and their places."""

from collections.abc import Sequence

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from soft_gripper.evaluation.paper.figures import run_with_pressure
from soft_gripper.evaluation.paper.forces import ContactForceRow, ForceRow
from soft_gripper.pictures.style import STYLE, section_style

_UNEQUAL = "#5aa02c"  # color of a second layout of as many sections


def force_figure(rows: Sequence[ForceRow], scenarios: Sequence[str]) -> Figure:
    """Above, torque along the first finger at the last step, true and estimated; below, the mean error."""
    with mpl.rc_context(STYLE):
        figure = Figure(figsize=(3 * len(scenarios), 5.4), layout="constrained")
        above, below = figure.subplots(2, len(scenarios), sharey="row", squeeze=False)
        for along, against, scenario in zip(above, below, scenarios, strict=True):
            chosen = [row for row in rows if row.scenario == scenario]
            _draw_along(along, chosen)
            _draw_against_pressure(against, chosen)
            run_with_pressure(against, chosen)
            along.set(title=scenario.replace("_", " ").capitalize(), xlabel="joint, from the base")
            against.set(xlabel="pressure [kPa]")
        above[0].set_ylabel("external torque [mN m]")
        below[0].set_ylim(bottom=0)  # of all of them, now that every error is drawn
        below[0].set_ylabel("mean error over the joints [mN m]")
        above[0].legend(frameon=False, fontsize="small", title="sensors per side")
    return figure


def _draw_along(axes: Axes, rows: Sequence[ForceRow]) -> None:
    last = [row for row in rows if row.finger == rows[0].finger and row.pressure_kpa == rows[-1].pressure_kpa]
    for sections in sorted({row.sections for row in last}):
        torque = [1e3 * row.estimated_nm for row in last if row.sections == sections]
        axes.plot(torque, **section_style(sections))
    truth = [1e3 * row.true_nm for row in last if row.sections == sections]
    axes.plot(truth, color="black", lw=2, ls=(0, (2, 1)), label="truth")


def _draw_against_pressure(axes: Axes, rows: Sequence[ForceRow]) -> None:
    for sections in sorted({row.sections for row in rows}):
        errors: dict[float, list[float]] = {}
        for row in rows:
            if row.sections == sections:
                errors.setdefault(row.pressure_kpa, []).append(1e3 * abs(row.estimated_nm - row.true_nm))
        pressures = sorted(errors)
        axes.plot(pressures, [np.mean(errors[pressure]) for pressure in pressures], **section_style(sections))


def contact_force_figure(rows: Sequence[ContactForceRow], scenarios: Sequence[str]) -> Figure:
    """Above, the contact force of the first finger against pressure, below, its place; true, and for every layout."""
    with mpl.rc_context(STYLE):
        figure = Figure(figsize=(3 * len(scenarios), 5.4), layout="constrained")
        above, below = figure.subplots(2, len(scenarios), sharex="col", squeeze=False)
        for force, place, scenario in zip(above, below, scenarios, strict=True):
            chosen = [row for row in rows if row.scenario == scenario]
            chosen = [row for row in chosen if row.finger == chosen[0].finger]
            _draw_beside_true(force, chosen, "n")
            _draw_beside_true(place, chosen, "mm")
            run_with_pressure(force, chosen)
            force.set_title(scenario.replace("_", " ").capitalize())
            force.axhline(0, color="0.8", lw=0.8, zorder=0)
            place.set(xlabel="pressure [kPa]", ylim=(0, 125))
        above[0].set_ylabel("contact force [N]")
        below[0].set_ylabel("place [mm from the base]")
        below[0].legend(frameon=False, fontsize="small", title="sections per side, where they meet")
    return figure


def _draw_beside_true(axes: Axes, rows: Sequence[ContactForceRow], unit: str) -> None:
    layouts = dict.fromkeys((row.sections, row.borders) for row in rows)
    numbers = [sections for sections, _ in layouts]
    for i, (sections, borders) in enumerate(layouts):
        of_layout = [row for row in rows if row.borders == borders]
        look = section_style(sections) | ({"color": _UNEQUAL, "marker": "v"} if sections in numbers[:i] else {})
        values = [getattr(row, f"estimated_{unit}") for row in of_layout]
        look |= {"mfc": "none", "label": f"{sections}: {borders} mm"}
        axes.plot([row.pressure_kpa for row in of_layout], values, **look)
    truth = [getattr(row, f"true_{unit}") for row in of_layout]
    axes.plot([row.pressure_kpa for row in of_layout], truth, color="black", lw=2, ls=(0, (2, 1)), label="truth")
