"""Errors of estimated contacts by estimator and setup.

In: contacts. Out: rows, their table, and a figure of SHOWN_SETUPS. Another error is a key of `relative_errors` and
its columns in `ContactErrorRow`.
"""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator
from numpy.typing import NDArray

from soft_gripper.arrays import Array
from soft_gripper.extras.paper.forces import describe_borders
from soft_gripper.files.row_table import write_csv
from soft_gripper.pictures.style import COLORS, STYLE, save_figure
from studies.contacts.contacts import Contacts
from studies.contacts.estimates import ESTIMATOR, SHOWN_SETUPS, Estimates, contact_estimates
from studies.estimator_setup import EstimatorSetup

BOTH, *SIDES = "both", "inner", "outer"
STATED = 2  # standard deviations, within which 95 % of all errors lie if the estimated ones are right


@dataclass(frozen=True)
class ContactErrorRow:
    """Errors of one estimator in one setup, for the contacts that it detects."""

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


def relative_errors(estimates: Estimates) -> dict[str, Array]:
    """Errors over true force, true transverse force and length, (..., M); NaN where no contact is detected."""
    is_detected = np.isfinite(estimates.estimated_force) & (estimates.estimated_force != 0)
    errors = {
        "force": np.abs(estimates.estimated_force - estimates.force) / estimates.force,
        "transverse": np.abs(estimates.estimated_transverse - estimates.transverse) / estimates.transverse,
        "place": np.abs(estimates.estimated_location - estimates.location),
    }
    return {name: np.where(is_detected, values, np.nan) for name, values in errors.items()}


def error_rows(
    estimator: str, setup: EstimatorSetup, estimates: Estimates, contacts: Contacts
) -> Iterator[ContactErrorRow]:
    """Rows of both sides together, of the inner and of the outer one."""
    for side in (BOTH, *SIDES):
        mask = _side_mask(side, contacts)
        if mask.any():
            yield ContactErrorRow(
                estimator=estimator,
                sections=setup.sections,
                borders=describe_borders(setup.layout(contacts.finger)),
                nominal=setup.nominal,
                calibration=setup.calibration,
                sensors=setup.sensors,
                averaged=setup.averaged,
                friction=float(contacts.friction[0]),
                side=side,
                contacts=int(mask.sum()),
                **_summary(estimates, mask),
            )


def _side_mask(side: str, contacts: Contacts) -> NDArray[np.bool_]:
    """Contacts that press on a side, (M,)."""
    return np.full(len(contacts.side), True) if side == BOTH else contacts.is_inside == (side == "inner")


def _summary(estimates: Estimates, mask: NDArray[np.bool_]) -> dict[str, float]:
    """Numbers of a row of chosen contacts, (M,); NaN if none is detected."""
    errors = relative_errors(estimates)
    is_detected = np.isfinite(errors["force"]) & mask
    row = {"found_percent": 100 * float(is_detected[..., mask].mean())}
    for name, values in errors.items():
        row |= {f"{name}_{key}_percent": 100 * value for key, value in statistics(values[is_detected]).items()}
    stds = {"force": estimates.force_std / estimates.force, "place": estimates.location_std}
    for name, std in stds.items():
        covers = (errors[name] <= STATED * std)[is_detected]
        row[f"{name}_within_2_std_percent"] = 100 * float(covers.mean()) if len(covers) else np.nan
    return row


def statistics(values: Array) -> dict[str, float]:
    """Mean, median and 90th percentile; NaN of no values."""
    if not len(values):
        return dict.fromkeys(("mean", "median", "90"), np.nan)
    median, tenth = np.percentile(values, [50, 90])
    return {"mean": float(values.mean()), "median": float(median), "90": float(tenth)}


SIDE_COLORS = dict(zip(SIDES, (COLORS[4], COLORS[1]), strict=True))


def contact_errors_figure(columns: Sequence[tuple[EstimatorSetup, Estimates]], contacts: Contacts) -> Figure:
    """Estimated over true force and location, by the first set of sensors; a column a setup.

    Contacts that are not detected are left out; points beyond the scales are drawn at their edges.
    """
    length = 1e3 * contacts.finger.length
    scales = (0.0, 1.05 * float(contacts.normal_force.max())), (0.3 * length, 1.03 * length)
    with mpl.rc_context(STYLE):
        figure = Figure(figsize=(3 * len(columns), 6), layout="constrained")
        panels = figure.subplots(2, len(columns), sharex="row", sharey="row", squeeze=False)
        for column, (setup, estimates) in zip(panels.T, columns, strict=True):
            errors = relative_errors(estimates)
            points = (
                (estimates.force, estimates.estimated_force[0]),
                (length * estimates.location, length * estimates.estimated_location[0]),
            )
            for axes, name, pair, limits, unit in zip(
                column, ("force", "place"), points, scales, ("%", "% of the length"), strict=True
            ):
                _scatter(axes, pair[0], np.clip(pair[1], *limits), contacts)
                axes.set(xlim=limits, ylim=limits, aspect="equal")
                median = f"median error {100 * np.nanmedian(errors[name]):.2g} {unit}"
                axes.text(0.98, 0.04, median, transform=axes.transAxes, ha="right", fontsize="small")
            column[0].set_title(_describe(setup), fontsize="medium")
        for row, label in zip(panels, ("force [N]", "contact location [mm]"), strict=True):
            row[0].set_ylabel(f"estimated {label}")
            for axes in row:
                axes.set_xlabel(f"true {label}")
                axes.xaxis.set_major_locator(MaxNLocator(4))
                axes.yaxis.set_major_locator(MaxNLocator(4))
        panels[0, -1].legend(title="pressed on the", frameon=False, fontsize="small", loc="upper left")
        setup = columns[0][0]
        figure.suptitle(
            f"{setup.sections} sections, {describe_borders(setup.layout(contacts.finger))} mm from the base;"
            f" coefficient of friction {contacts.friction[0]:.2g}",
            fontsize="medium",
        )
    return figure


def _scatter(axes: Axes, true: Array, estimated: Array, contacts: Contacts) -> None:
    axes.axline((0, 0), slope=1, color="0.75", lw=1, zorder=1)
    for side, color in SIDE_COLORS.items():
        mask = _side_mask(side, contacts)
        style: dict[str, Any] = {"s": 13, "alpha": 0.75, "lw": 0.0, "zorder": 2}
        axes.scatter(true[mask], estimated[mask], color=color, label=f"{side} side", clip_on=False, **style)


def _describe(setup: EstimatorSetup) -> str:
    """Text of a setup, in three lines."""
    mean = f", mean of {setup.averaged} samples" if setup.averaged > 1 else ""
    sensors = f"{setup.sensors} sensors{mean}".capitalize()
    if not setup.stiffness:
        return f"{sensors}\nfinger as simulated\n"
    calibrated = "not calibrated" if setup.calibration == "none" else f"calibrated {setup.calibration}"
    return f"{sensors}\nnominal stiffness {100 * setup.stiffness:+g} %,\n{calibrated}"


ERRORS, FIGURE = "contact_errors.csv", "contact_errors"


def score_contacts(
    contacts: Contacts, folder: Path, report: Callable[[], Any], estimators: Sequence[str] = (ESTIMATOR,)
) -> list[ContactErrorRow]:
    """Writes the table, and the figure of the first estimator; returns the rows.

    `report` is called after each of SETUPS of every estimator.
    """
    rows, estimates_by_setup = list[ContactErrorRow](), dict[EstimatorSetup, Estimates]()
    for estimator, setup, estimates in contact_estimates(contacts, estimators):
        rows += error_rows(estimator, setup, estimates, contacts)
        if estimator == estimators[0]:
            estimates_by_setup[setup] = estimates
        report()
    write_csv(folder / ERRORS, rows)
    columns = [(setup, estimates_by_setup[setup]) for setup in SHOWN_SETUPS]
    save_figure(contact_errors_figure(columns, contacts), folder / FIGURE)
    return rows
