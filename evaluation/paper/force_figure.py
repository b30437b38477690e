"""The force figure: the external torque along the fingers, and its error against pressure."""

from collections.abc import Sequence

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from soft_gripper.evaluation.figure_style import STYLE, section_style
from soft_gripper.evaluation.paper.figures import run_with_pressure
from soft_gripper.evaluation.paper.force_table import ForceRow


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
        above[0].legend(frameon=False, fontsize="small", title="sensors a side")
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
