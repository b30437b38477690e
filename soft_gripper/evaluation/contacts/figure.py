"""The figure of the contact trials: force and place of every contact, estimated against true."""

from collections.abc import Sequence
from typing import Any

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from soft_gripper.arrays import Array
from soft_gripper.evaluation.contacts.dataset import Contacts
from soft_gripper.evaluation.contacts.errors import contact_errors
from soft_gripper.evaluation.contacts.estimates import Case, ContactEstimate
from soft_gripper.evaluation.contacts.random_contact import SIDES
from soft_gripper.evaluation.contacts.sensors import describe_borders
from soft_gripper.pictures.style import COLORS, STYLE

SIDE_COLORS = dict(zip(SIDES, (COLORS[4], COLORS[1]), strict=True))
_LABELS = "force [N]", "place [mm from the base]"


def contact_errors_figure(estimates: Sequence[ContactEstimate], contacts: Contacts) -> Figure:
    """A column for every estimate, by the first of its sets of sensors: above the force, below the place.

    Contacts that are not found are left out; what lies beyond the scales is drawn on their edges.
    """
    scales = (
        (np.abs(contacts.force), (0.0, 1.05 * float(np.abs(contacts.force).max()))),
        (1e3 * contacts.arc_length, (0.3e3 * contacts.finger.length, 1.03e3 * contacts.finger.length)),
    )
    with mpl.rc_context(STYLE):
        figure = Figure(figsize=(3 * len(estimates), 6), layout="constrained")
        panels = figure.subplots(2, len(estimates), sharex="row", sharey="row", squeeze=False)
        for column, estimate in zip(panels.T, estimates, strict=True):
            # A force on the wrong side counts as below none.
            signed = estimate.contact.force[0] * np.sign(contacts.force)
            found = signed, 1e3 * estimate.contact.arc_length[0]
            for axes, estimated, (true, limits) in zip(column, found, scales, strict=True):
                _draw(axes, true, np.clip(estimated, *limits), contacts)
                axes.set(xlim=limits, ylim=limits, aspect="equal")
            for axes, median in zip(column, _medians(estimate, contacts), strict=True):
                where: dict[str, Any] = {"transform": axes.transAxes, "ha": "right", "fontsize": "small"}
                axes.text(0.98, 0.04, f"median error {median}", **where)
            column[0].set_title(_describe(estimate.case), fontsize="medium")
        for row, label in zip(panels, _LABELS, strict=True):
            row[0].set_ylabel(f"estimated {label}")
            for axes in row:
                axes.set_xlabel(f"true {label}")
                axes.xaxis.set_major_locator(MaxNLocator(4))
                axes.yaxis.set_major_locator(MaxNLocator(4))
        panels[0, -1].legend(title="pressed on the", frameon=False, fontsize="small", loc="upper left")
        layout = estimates[0].layout
        figure.suptitle(
            f"{layout.sections} sections, {describe_borders(layout)} mm from the base;"
            f" coefficient of friction {contacts.friction[0]:.2g}",
            fontsize="medium",
        )
    return figure


def _draw(axes: Axes, true: Array, estimated: Array, contacts: Contacts) -> None:
    axes.axline((0, 0), slope=1, color="0.75", lw=1, zorder=1)
    for side, color in SIDE_COLORS.items():
        chosen = contacts.side == side
        look: dict[str, Any] = {"s": 13, "alpha": 0.75, "lw": 0.0, "zorder": 2}
        axes.scatter(true[chosen], estimated[chosen], color=color, label=f"{side} side", clip_on=False, **look)


def _medians(estimate: ContactEstimate, contacts: Contacts) -> tuple[str, str]:
    """The medians of the errors of force and place, as they are written."""
    errors = contact_errors(estimate.contact, contacts)
    return f"{100 * np.nanmedian(errors.force):.2g} %", f"{100 * np.nanmedian(errors.place):.2g} % of the length"


def _describe(case: Case) -> str:
    """A case in three lines."""
    sensors = f"{case.sensors} sensors" + (f", mean of {case.averaged} samples" if case.averaged > 1 else "")
    if case.youngs_modulus is None:
        return f"{sensors.capitalize()}\nfinger as simulated\n"
    calibrated = "not calibrated" if case.calibration == "none" else f"calibrated {case.calibration}"
    return f"{sensors.capitalize()}\nstiffness believed {case.youngs_modulus},\n{calibrated}"
