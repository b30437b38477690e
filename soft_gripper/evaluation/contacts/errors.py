"""How well force and place of single contacts are estimated: percentiles of the errors, and of the stated ones."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from soft_gripper.arrays import Array
from soft_gripper.estimators.estimate import ContactForce
from soft_gripper.evaluation.contacts.dataset import Contacts
from soft_gripper.evaluation.contacts.estimates import ContactEstimate
from soft_gripper.evaluation.contacts.random_contact import SIDES
from soft_gripper.evaluation.contacts.sensors import describe_borders

BOTH = "both"  # sides
STATED = 2  # standard deviations, within which 95 % of all errors lie if they are stated rightly
_PERCENTILES = 50, 90


@dataclass(frozen=True)
class ContactErrorRow:
    """One estimator in one case: of the contacts that it finds, the sizes of the errors."""

    estimator: str
    sections: int
    borders: str  # mm from the base
    belief: str
    calibration: str
    sensors: str
    averaged: int  # samples
    friction: float  # Coulomb
    side: str  # "both", "inner" or "outer"
    contacts: int  # by every set of sensors
    found_percent: float
    force_median_percent: float  # of the true force
    force_90_percent: float  # 90th percentile
    place_median_percent: float  # of the length
    place_90_percent: float
    force_within_2_std_percent: float
    place_within_2_std_percent: float


class Errors(NamedTuple):
    """Of estimates of M contacts by E sets of sensors, each (E, M); NaN where no contact is found."""

    force: Array  # share of the true force
    place: Array  # share of the length
    force_within: NDArray[np.bool_]  # STATED standard deviations
    place_within: NDArray[np.bool_]

    def of(self, chosen: NDArray[np.bool_]) -> "Errors":
        """Those of some contacts, (M)."""
        force, place = self.force[:, chosen], self.place[:, chosen]
        return Errors(force, place, self.force_within[:, chosen], self.place_within[:, chosen])

    @property
    def found(self) -> NDArray[np.bool_]:
        """Where a contact is found."""
        return np.isfinite(self.force)


def contact_errors(found: ContactForce, contacts: Contacts) -> Errors:
    """The sizes of the errors; an estimate of no force, or of an unknown one, is no contact that is found."""
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
    errors, case = contact_errors(estimate.contact, contacts), estimate.case
    for side in (BOTH, *SIDES):
        chosen = contacts.side == side if side in SIDES else np.ones(len(contacts.side), bool)
        if chosen.any():
            yield ContactErrorRow(
                estimate.estimator,
                estimate.layout.sections,
                describe_borders(estimate.layout),
                case.belief,
                case.calibration,
                case.sensors,
                case.averaged,
                float(contacts.friction[0]),
                side,
                int(chosen.sum()),
                *_summary(errors.of(chosen)),
            )


def _summary(errors: Errors) -> list[float]:
    """The numbers of a row, from the share that is found on; NaN where none is."""
    found = errors.found
    percentiles = [
        np.percentile(error[found], percentile) if found.any() else np.nan
        for error in (errors.force, errors.place)
        for percentile in _PERCENTILES
    ]
    stated = [within[found].mean() if found.any() else np.nan for within in (errors.force_within, errors.place_within)]
    return [100 * float(value) for value in (found.mean(), *percentiles, *stated)]
