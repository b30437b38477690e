"""Contacts scored: what estimators make of them, as a table and a figure."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

from soft_gripper.evaluation.contacts.dataset import Contacts
from soft_gripper.evaluation.contacts.errors import ContactErrorRow, error_rows
from soft_gripper.evaluation.contacts.estimates import (
    CASES,
    ESTIMATORS,
    SHOWN_CASES,
    SHOWN_LAYOUT,
    ContactEstimate,
    contact_estimates,
)
from soft_gripper.evaluation.contacts.figure import contact_errors_figure
from soft_gripper.evaluation.contacts.sensors import LAYOUTS
from soft_gripper.files.csv_table import write_csv
from soft_gripper.pictures.style import save_figure

ERRORS, FIGURE = "contact_errors.csv", "contact_errors"
SCORES = len(LAYOUTS) * len(CASES) * len(ESTIMATORS)


def score_contacts(contacts: Contacts, folder: Path, report: Callable[[], Any]) -> list[ContactErrorRow]:
    """Writes the table and the figure, and returns the rows; `report` is called after each of SCORES."""
    estimates = []
    for estimate in contact_estimates(contacts):
        estimates.append(estimate)
        report()
    rows = error_rows(estimates, contacts)
    write_csv(folder / ERRORS, rows)
    shown = sorted(filter(_is_shown, estimates), key=lambda estimate: SHOWN_CASES.index(estimate.case))
    save_figure(contact_errors_figure(shown, contacts), folder / FIGURE)
    return rows


def _is_shown(estimate: ContactEstimate) -> bool:
    sensors = estimate.layout.sections, estimate.layout.borders
    return (estimate.estimator, sensors) == (ESTIMATORS[0], SHOWN_LAYOUT) and estimate.case in SHOWN_CASES
