"""Runs, an estimator and its errors -> all placements ranked, and the gain of the best one on held-out runs.

The search for the best placement: exhaustive where there are few, otherwise by exchange of one border at a time.

Up to EXHAUSTIVE placements, all are tried: of 12 segments there are 462 at most. For finer fingers the search begins
at a given placement and goes through the borders in turn; each goes to the best of all places between its neighbours.
It ends when no border moves: the placement is then the best of all that differ from it in one border, though perhaps
not of all. (Coordinate exchange, as for designs of experiments: Meyer and Nachtsheim 1995, doi
10.1080/00401706.1995.10485889.)
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from itertools import count as numbers
from typing import Any

import numpy as np
from numpy.typing import NDArray

from soft_gripper.arrays import Array
from soft_gripper.extras.placement.placements import Placement, all_placements, equal_placement, number_of_placements
from soft_gripper.extras.placement.samples import Assumptions, HeldFinger, Samples, read_contacts, read_held
from soft_gripper.extras.studies.contacts.contacts import Contacts
from soft_gripper.fingers.finger import Finger
from soft_gripper.fingers.kinematics import forward_kinematics, in_space
from soft_gripper.truth.poses import pose_error

EXHAUSTIVE = 500
Objective = Callable[[Placement], float]


def ranked(objective: Objective, segments: int, begin: Placement) -> list[Placement]:
    """The placements tried, sorted by objective.

    `begin` is where the exchange begins; it has as many borders as all others, and is among those tried.
    """
    tried: dict[Placement, float] = {}

    def score(placement: Placement) -> float:
        if placement not in tried:
            tried[placement] = objective(placement)
        return tried[placement]

    if number_of_placements(segments, len(begin) + 1) <= EXHAUSTIVE:
        for placement in all_placements(segments, len(begin) + 1):
            score(placement)
    else:
        _exchange(score, segments, begin)
    return sorted(tried, key=lambda placement: (tried[placement], placement))


def _exchange(score: Objective, segments: int, begin: Placement) -> None:
    """Moves the borders in turn to their best places, until none moves."""
    now, before = begin, None
    while now != before:
        before = now
        for i in range(len(now)):
            now = min(_moved(now, i, segments), key=score)


def _moved(placement: Placement, i: int, segments: int) -> list[Placement]:
    """All placements that differ from one in border i alone, itself included."""
    low, _, high = (0, *placement, segments)[i : i + 3]
    return [(*placement[:i], end, *placement[i + 1 :]) for end in range(low + 1, high)]


@dataclass(frozen=True)
class LeftOut:
    """A held-out run, and sensors placed using the other runs only."""

    run: str
    placement: Placement
    equal: float  # m, mean pose error with equal sections
    placed: float  # m, with the placement


def leave_one_out(
    errors: Callable[[Placement], Array], runs: Sequence[str], segments: int, equal: Placement
) -> list[LeftOut]:
    """One for every run; none for a single run, which leaves no others to place by.

    `errors` are mean pose errors of a placement in all runs, (R) m.
    """
    if len(runs) < 2:
        return []
    left_out = []
    for i, run in enumerate(runs):
        best = best_placement(errors, np.arange(len(runs)) != i, segments, equal)
        left_out.append(LeftOut(run, best, float(errors(equal)[i]), float(errors(best)[i])))
    return left_out


def best_placement(
    errors: Callable[[Placement], Array], by: NDArray[np.bool_], segments: int, begin: Placement
) -> Placement:
    """The best in the mean over the runs `by`, (R)."""
    return ranked(lambda placement: float(errors(placement)[by].mean()), segments, begin)[0]


@dataclass(frozen=True)
class ContactErrors:
    """Errors of random single contacts."""

    force: float  # N, mean; a missed contact counts with its whole force across the finger
    place: float  # m, mean over the detected contacts
    missed: float  # share of the contacts


def mean_pose_error(fingers: Sequence[Samples], placement: Placement, assumptions: Assumptions) -> float:
    """Mean pose error of the fingers of a scenario, m; each finger counts alike."""
    return float(np.mean([_pose_error(finger, placement, assumptions) for finger in fingers]))


def _pose_error(samples: Samples, placement: Placement, assumptions: Assumptions) -> float:
    finger = samples.layout.finger
    true = forward_kinematics(samples.q, finger.segment_length).joints[:, None]
    estimates = samples.estimates(placement, assumptions)
    found = (in_space(estimate.points(finger)[..., :-1]) for estimate in estimates)
    return float(np.mean([pose_error(in_space(true), joints) for joints in found]))


def contact_errors(
    contacts: Contacts, samples: Samples, placement: Placement, assumptions: Assumptions
) -> ContactErrors:
    """Errors of force and place of contacts, of which `samples` are the readings, by an estimator of these."""
    found: list[tuple[Array, Array]] = []
    for estimate in samples.estimates(placement, assumptions):
        assert estimate.contact is not None
        force = np.nan_to_num(estimate.contact.force)
        true = np.where(contacts.is_inside, contacts.normal_force, -contacts.normal_force)
        found.append((force - true[:, None], estimate.contact.arc_length - contacts.arc_length[:, None]))
    force_error, place_error = (np.abs(errors) for errors in zip(*found, strict=True))
    missed = np.isnan(place_error)
    place = float(place_error[~missed].mean()) if not missed.all() else float("nan")
    return ContactErrors(float(force_error.mean()), place, float(missed.mean()))


@dataclass(frozen=True, eq=False)
class PlacedSensors:
    """The results of all P placements tried, in R runs."""

    finger: Finger
    runs: list[str]
    placements: list[Placement]  # the best first
    pose_errors: Array  # (P, R) m, means
    equal: int  # which of the placements has equal sections
    contacts: list[ContactErrors] | None  # of every placement; None without contacts
    left_out: list[LeftOut]

    @property
    def mean_pose_errors(self) -> Array:
        """The ranking criterion: every run counts alike, (P) m."""
        means: Array = self.pose_errors.mean(axis=-1)
        return means


def place_sensors(
    count: int,
    runs: Mapping[str, Sequence[HeldFinger]],
    assumptions: Assumptions,
    contacts: Contacts | None = None,
    progress: Callable[[], Any] = lambda: None,
) -> PlacedSensors:
    """Tries placements of `count` sections per side.

    Args:
        count: of sections.
        runs: by which sensors are placed: the fingers of each run by its name, all with as many segments.
        assumptions: the estimator, and the errors of sensors and nominal model.
        contacts: single contacts, whose errors are also reported; they do not affect the choice.
        progress: called after every placement that was tried.

    Raises:
        InputError: if the fingers have fewer segments than that.
    """
    number = numbers()
    read = [[read_held(finger, assumptions, next(number)) for finger in fingers] for fingers in runs.values()]
    layout = read[0][0].layout
    segments, equal = layout.finger.segments, equal_placement(layout.finger, count)

    @cache
    def errors(placement: Placement) -> Array:
        found = np.array([mean_pose_error(fingers, placement, assumptions) for fingers in read])
        progress()
        return found

    placements = ranked(lambda placement: float(errors(placement).mean()), segments, equal)
    left_out = leave_one_out(errors, list(runs), segments, equal)
    of_contacts = None
    if contacts is not None:
        samples = read_contacts(contacts, layout, assumptions, next(number))
        of_contacts = [contact_errors(contacts, samples, placement, assumptions) for placement in placements]
    pose_errors = np.array([errors(placement) for placement in placements])
    return PlacedSensors(
        layout.finger, list(runs), placements, pose_errors, placements.index(equal), of_contacts, left_out
    )
