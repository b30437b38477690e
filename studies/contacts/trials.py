"""Errors of estimated contacts: the rows, the figure, and the whole table of a set of contacts."""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any, NamedTuple

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator
from numpy.typing import NDArray

from soft_gripper.arrays import Array
from soft_gripper.extras.paper.forces import LAYOUTS, describe_borders
from soft_gripper.files.row_table import write_csv
from soft_gripper.pictures.style import COLORS, STYLE, save_figure
from studies.contacts.contacts import Contacts
from studies.contacts.estimates import (
    CONDITIONS,
    ESTIMATOR,
    SHOWN_CONDITIONS,
    SHOWN_LAYOUT,
    Condition,
    ContactEstimate,
    contact_estimates,
)
from studies.contacts.found_contact import FoundContact

BOTH, *SIDES = "both", "inner", "outer"
STATED = 2  # standard deviations, within which 95 % of all errors lie if the stated ones are right


@dataclass(frozen=True)
class ContactErrorRow:
    """One estimator in one condition: the errors of the contacts that it detects."""

    estimator: str
    sections: int
    borders: str  # mm from the base
    nominal: str
    calibration: str
    sensors: str
    averaged: int  # samples
    friction: float  # Coulomb
    side: str  # "both", "inner" or "outer"
    contacts: int  # by every set of sensors
    found_percent: float
    force_mean_percent: Annotated[float, ".2f"]  # of the true force
    force_median_percent: Annotated[float, ".2f"]
    force_90_percent: Annotated[float, ".2f"]  # 90th percentile
    transverse_mean_percent: Annotated[float, ".2f"]  # of the true transverse force
    transverse_median_percent: Annotated[float, ".2f"]
    transverse_90_percent: Annotated[float, ".2f"]
    place_mean_percent: Annotated[float, ".2f"]  # of the length
    place_median_percent: Annotated[float, ".2f"]
    place_90_percent: Annotated[float, ".2f"]
    force_within_2_std_percent: float
    place_within_2_std_percent: float


class Errors(NamedTuple):
    """Errors of estimates of M contacts by E sets of sensors, each (E, M); NaN where no contact is found."""

    force: Array  # share of the true force
    transverse: Array  # share of the true transverse force
    place: Array  # share of the length
    force_within: NDArray[np.bool_]  # STATED standard deviations
    place_within: NDArray[np.bool_]

    @property
    def found(self) -> NDArray[np.bool_]:
        """Where a contact is detected."""
        return np.isfinite(self.force)


def contact_errors(found: FoundContact, contacts: Contacts) -> Errors:
    """The absolute errors; an estimate without a force, or with an unknown one, counts as not detected."""
    known = np.isfinite(found.force) & (found.force != 0)
    force = np.where(known, np.abs(found.force - contacts.normal_force), np.nan)
    transverse = np.where(known, np.abs(found.transverse_force - contacts.transverse_force), np.nan)
    place = np.where(known, np.abs(found.arc_length - contacts.arc_length), np.nan)
    return Errors(
        force / contacts.normal_force,
        transverse / contacts.transverse_force,
        place / contacts.finger.length,
        force <= STATED * found.force_std,
        place <= STATED * found.arc_length_std,
    )


def error_rows(estimates: Sequence[ContactEstimate], contacts: Contacts) -> list[ContactErrorRow]:
    """A row for every estimate and both sides, the inner and the outer one."""
    return [row for estimate in estimates for row in _rows(estimate, contacts)]


def _rows(estimate: ContactEstimate, contacts: Contacts) -> Iterator[ContactErrorRow]:
    errors, condition = contact_errors(estimate.contact, contacts), estimate.condition
    for side in (BOTH, *SIDES):
        chosen = _pressed_on(side, contacts)
        if chosen.any():
            yield ContactErrorRow(
                estimator=estimate.estimator,
                sections=estimate.layout.sections,
                borders=describe_borders(estimate.layout),
                nominal=condition.nominal,
                calibration=condition.calibration,
                sensors=condition.sensors,
                averaged=condition.averaged,
                friction=float(contacts.friction[0]),
                side=side,
                contacts=int(chosen.sum()),
                **_summary(errors, chosen),
            )


def _pressed_on(side: str, contacts: Contacts) -> NDArray[np.bool_]:
    """Which of the contacts press on a side, (M)."""
    return np.full(len(contacts.side), True) if side == BOTH else contacts.is_inside == (side == "inner")


def _summary(errors: Errors, chosen: NDArray[np.bool_]) -> dict[str, float]:
    """The numbers of a row of chosen contacts, (M); NaN where none is found."""
    found = errors.found & chosen
    row = {"found_percent": 100 * float(errors.found[:, chosen].mean())}
    for name in ("force", "transverse", "place"):
        sizes = statistics(getattr(errors, name)[found])
        row |= {f"{name}_{at}_percent": 100 * value for at, value in sizes.items()}
    for name, within in (("force", errors.force_within), ("place", errors.place_within)):
        row[f"{name}_within_2_std_percent"] = 100 * float(within[found].mean()) if found.any() else np.nan
    return row


def statistics(values: Array) -> dict[str, float]:
    """Mean, median and 90th percentile; NaN of no values."""
    if not len(values):
        return dict.fromkeys(("mean", "median", "90"), np.nan)
    median, most = np.percentile(values, [50, 90])
    return {"mean": float(values.mean()), "median": float(median), "90": float(most)}


SIDE_COLORS = dict(zip(SIDES, (COLORS[4], COLORS[1]), strict=True))
_LABELS = "force [N]", "contact location [mm from the base]"


def contact_errors_figure(estimates: Sequence[ContactEstimate], contacts: Contacts) -> Figure:
    """A column for every estimate, with the first of its sets of sensors: force above, location below.

    Contacts that are not detected are left out; points beyond the scales are drawn at their edges.
    """
    scales = (
        (contacts.normal_force, (0.0, 1.05 * float(contacts.normal_force.max()))),
        (1e3 * contacts.arc_length, (0.3e3 * contacts.finger.length, 1.03e3 * contacts.finger.length)),
    )
    with mpl.rc_context(STYLE):
        figure = Figure(figsize=(3 * len(estimates), 6), layout="constrained")
        panels = figure.subplots(2, len(estimates), sharex="row", sharey="row", squeeze=False)
        for column, estimate in zip(panels.T, estimates, strict=True):
            found = estimate.contact.force[0], 1e3 * estimate.contact.arc_length[0]
            for axes, estimated, (true, limits) in zip(column, found, scales, strict=True):
                _draw(axes, true, np.clip(estimated, *limits), contacts)
                axes.set(xlim=limits, ylim=limits, aspect="equal")
            for axes, median in zip(column, _medians(estimate, contacts), strict=True):
                where: dict[str, Any] = {"transform": axes.transAxes, "ha": "right", "fontsize": "small"}
                axes.text(0.98, 0.04, f"median error {median}", **where)
            column[0].set_title(_describe(estimate.condition), fontsize="medium")
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
        chosen = _pressed_on(side, contacts)
        look: dict[str, Any] = {"s": 13, "alpha": 0.75, "lw": 0.0, "zorder": 2}
        axes.scatter(true[chosen], estimated[chosen], color=color, label=f"{side} side", clip_on=False, **look)


def _medians(estimate: ContactEstimate, contacts: Contacts) -> tuple[str, str]:
    """The medians of the errors of force and location, as text."""
    errors = contact_errors(estimate.contact, contacts)
    return f"{100 * np.nanmedian(errors.force):.2g} %", f"{100 * np.nanmedian(errors.place):.2g} % of the length"


def _describe(condition: Condition) -> str:
    """A condition in three lines."""
    mean = f", mean of {condition.averaged} samples" if condition.averaged > 1 else ""
    sensors = f"{condition.sensors} sensors{mean}"
    if condition.youngs_modulus is None:
        return f"{sensors.capitalize()}\nfinger as simulated\n"
    calibrated = "not calibrated" if condition.calibration == "none" else f"calibrated {condition.calibration}"
    return f"{sensors.capitalize()}\nnominal stiffness {condition.youngs_modulus},\n{calibrated}"


ERRORS, FIGURE = "contact_errors.csv", "contact_errors"
SCORES = len(LAYOUTS) * len(CONDITIONS)  # of an estimator


def score_contacts(
    contacts: Contacts, folder: Path, report: Callable[[], Any], estimators: Sequence[str] = (ESTIMATOR,)
) -> list[ContactErrorRow]:
    """Writes the table, and the figure of the first estimator; returns the rows.

    `report` is called after each of SCORES of every estimator.
    """
    estimates = []
    for estimate in contact_estimates(contacts, estimators):
        estimates.append(estimate)
        report()
    rows = error_rows(estimates, contacts)
    write_csv(folder / ERRORS, rows)
    shown = [estimate for estimate in estimates if estimate.estimator == estimators[0] and _is_shown(estimate)]
    shown.sort(key=lambda estimate: SHOWN_CONDITIONS.index(estimate.condition))
    save_figure(contact_errors_figure(shown, contacts), folder / FIGURE)
    return rows


def _is_shown(estimate: ContactEstimate) -> bool:
    sensors = estimate.layout.sections, estimate.layout.borders
    return sensors == SHOWN_LAYOUT and estimate.condition in SHOWN_CONDITIONS
