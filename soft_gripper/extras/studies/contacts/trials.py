"""Contact trials: random single contacts, simulated many at a time, and their estimates."""

from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import Executor
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NamedTuple

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator
from numpy.typing import NDArray

from soft_gripper.arrays import Array
from soft_gripper.estimators.estimate import ContactForce
from soft_gripper.evaluation.paper.forces import LAYOUTS, describe_borders
from soft_gripper.extras.studies.contacts.dataset import (
    PEG_FRICTION,
    SIDES,
    Contact,
    Contacts,
    as_arrays,
    run_contact,
    save_contacts,
)
from soft_gripper.extras.studies.contacts.estimates import (
    CONDITIONS,
    ESTIMATOR,
    SHOWN_CONDITIONS,
    SHOWN_LAYOUT,
    Condition,
    ContactEstimate,
    contact_estimates,
)
from soft_gripper.files.csv_table import write_csv
from soft_gripper.fingers.kinematics import as_points
from soft_gripper.pictures.style import COLORS, STYLE, save_figure
from soft_gripper.runs.study import run_study

BOTH = "both"  # sides
STATED = 2  # standard deviations, within which 95 % of all errors lie if the stated ones are right
_PERCENTILES = 50, 90


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
    force_mean_percent: float  # of the true force
    force_median_percent: float
    force_90_percent: float  # 90th percentile
    place_mean_percent: float  # of the length
    place_median_percent: float
    place_90_percent: float
    force_within_2_std_percent: float
    place_within_2_std_percent: float


class Errors(NamedTuple):
    """Errors of estimates of M contacts by E sets of sensors, each (E, M); NaN where no contact is found."""

    force: Array  # share of the true force
    place: Array  # share of the length
    force_within: NDArray[np.bool_]  # STATED standard deviations
    place_within: NDArray[np.bool_]

    def of(self, chosen: NDArray[np.bool_]) -> "Errors":
        """Errors of some contacts, (M)."""
        force, place = self.force[:, chosen], self.place[:, chosen]
        return Errors(force, place, self.force_within[:, chosen], self.place_within[:, chosen])

    @property
    def found(self) -> NDArray[np.bool_]:
        """Where a contact is detected."""
        return np.isfinite(self.force)


def contact_errors(found: ContactForce, contacts: Contacts) -> Errors:
    """The absolute errors; an estimate without a force, or with an unknown one, counts as not detected."""
    known = np.isfinite(found.force) & (found.force != 0)
    force = np.where(known, np.abs(found.force - contacts.force), np.nan)
    place = np.where(known, np.abs(found.arc_length - contacts.arc_length), np.nan)
    return Errors(
        force / np.abs(contacts.force),
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
        chosen = contacts.side == side if side in SIDES else np.ones(len(contacts.side), bool)
        if chosen.any():
            yield ContactErrorRow(
                estimate.estimator,
                estimate.layout.sections,
                describe_borders(estimate.layout),
                condition.nominal,
                condition.calibration,
                condition.sensors,
                condition.averaged,
                float(contacts.friction[0]),
                side,
                int(chosen.sum()),
                *_summary(errors.of(chosen)),
            )


def _summary(errors: Errors) -> list[float]:
    """The numbers of a row, from the share detected onward; NaN where none is."""
    found = errors.found
    sizes = [size for error in (errors.force, errors.place) for size in _sizes(error[found])]
    stated = [within[found].mean() if found.any() else np.nan for within in (errors.force_within, errors.place_within)]
    return [100 * float(value) for value in (found.mean(), *sizes, *stated)]


def _sizes(errors: Array) -> list[float]:
    """Mean and percentiles."""
    if not len(errors):
        return [np.nan] * (1 + len(_PERCENTILES))
    return [errors.mean(), *np.percentile(errors, _PERCENTILES)]


SIDE_COLORS = dict(zip(SIDES, (COLORS[4], COLORS[1]), strict=True))
_LABELS = "force [N]", "place [mm from the base]"


def contact_errors_figure(estimates: Sequence[ContactEstimate], contacts: Contacts) -> Figure:
    """A column for every estimate, with the first of its sets of sensors: force above, location below.

    Contacts that are not detected are left out; points beyond the scales are drawn at their edges.
    """
    scales = (
        (np.abs(contacts.force), (0.0, 1.05 * float(np.abs(contacts.force).max()))),
        (1e3 * contacts.arc_length, (0.3e3 * contacts.finger.length, 1.03e3 * contacts.finger.length)),
    )
    with mpl.rc_context(STYLE):
        figure = Figure(figsize=(3 * len(estimates), 6), layout="constrained")
        panels = figure.subplots(2, len(estimates), sharex="row", sharey="row", squeeze=False)
        for column, estimate in zip(panels.T, estimates, strict=True):
            # A force on the wrong side counts as negative.
            signed = estimate.contact.force[0] * np.sign(contacts.force)
            found = signed, 1e3 * estimate.contact.arc_length[0]
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
        chosen = contacts.side == side
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


TABLE, ARRAYS = "contacts.csv", "contacts.npz"


@dataclass(frozen=True)
class ContactRow:
    """The draw for a contact, and its ground truth."""

    contact: int
    side: str
    radius_mm: float
    place_mm: float  # arc length at which the peg was placed against the finger
    arc_length_mm: float  # where it presses
    force_n: float  # across the finger, positive on the inner side
    total_n: float  # friction included
    pressure_kpa: float
    gravity_x: float  # m/s^2, in B
    gravity_z: float
    redrawn: int  # number of draws that were not single contacts


def contact_row(contact: Contact) -> ContactRow:
    """The row of a contact."""
    drawn, found = contact.drawn, contact.found
    gravity_x, gravity_z = as_points(drawn.gravity).tolist()
    return ContactRow(
        contact.number,
        drawn.side,
        drawn.radius_mm,
        drawn.place_mm,
        1e3 * found.arc_length,
        found.force,
        found.total,
        drawn.pressure_kpa,
        gravity_x,
        gravity_z,
        len(contact.redrawn),
    )


def run_contacts(
    number: int, seed: int, executor: Executor, report: Callable[[], Any], friction: float = PEG_FRICTION
) -> list[Contact]:
    """Simulates random contacts.

    Args:
        number: contacts 0 to `number` - 1 of the seed.
        seed: of the random numbers.
        executor: runs the simulations.
        report: called after each contact.
        friction: coefficient of the peg's surface.
    """
    contacts: dict[int, Contact] = {}
    jobs = {i: (seed, i, friction) for i in range(number)}
    run_study(executor, run_contact, jobs, contacts.__setitem__, ended=lambda i: report())
    return [contacts[i] for i in jobs]


def write_contacts(contacts: Sequence[Contact], folder: Path) -> None:
    """Writes the table and the arrays."""
    write_csv(folder / TABLE, [contact_row(contact) for contact in contacts])
    save_contacts(as_arrays(contacts), folder / ARRAYS)


def redrawn(contacts: Sequence[Contact]) -> Counter[str]:
    """The number of draws that were not single contacts, by reason."""
    return Counter(reason for contact in contacts for reason in contact.redrawn)


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
