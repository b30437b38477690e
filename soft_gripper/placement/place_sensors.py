"""Runs, an estimator and its errors -> all placements ranked, and what the best one gains elsewhere."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from itertools import count as numbers
from typing import Any

import numpy as np

from soft_gripper.arrays import Array
from soft_gripper.evaluation.contacts.dataset import Contacts
from soft_gripper.fingers.finger import Finger
from soft_gripper.placement.assumptions import Assumptions
from soft_gripper.placement.errors import ContactErrors, contact_errors, mean_pose_error
from soft_gripper.placement.held_finger import HeldFinger
from soft_gripper.placement.placements import Placement, equal_placement
from soft_gripper.placement.samples import read_contacts, read_held
from soft_gripper.placement.search import LeftOut, leave_one_out, ranked


@dataclass(frozen=True, eq=False)
class PlacedSensors:
    """What came of all placements that were tried, P of them, in R runs."""

    finger: Finger
    runs: list[str]
    placements: list[Placement]  # the best first
    pose_errors: Array  # (P, R) m, means
    equal: int  # which of the placements has equal sections
    contacts: list[ContactErrors] | None  # of every placement; None without contacts
    left_out: list[LeftOut]

    @property
    def mean_pose_errors(self) -> Array:
        """By which they are ranked: every run counts alike, (P) m."""
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
        runs: by which sensors are placed: the fingers of each, all of as many segments, by its name.
        assumptions: the estimator, and what goes wrong.
        contacts: single contacts, whose errors are given besides; nothing is chosen by them.
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
