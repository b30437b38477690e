"""How wrong estimates are with the sensors of a placement: mean errors over samples, sets of sensors and beliefs."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from soft_gripper.arrays import Array
from soft_gripper.evaluation.contacts.dataset import Contacts
from soft_gripper.fingers.kinematics import forward_kinematics, in_space
from soft_gripper.placement.assumptions import Assumptions
from soft_gripper.placement.placements import Placement
from soft_gripper.placement.samples import Samples
from soft_gripper.truth.poses import pose_error


@dataclass(frozen=True)
class ContactErrors:
    """Of random single contacts."""

    force: float  # N, mean; of a missed contact, all of the force across the finger
    place: float  # m, mean over the contacts that are found
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
        found.append((force - contacts.force[:, None], estimate.contact.arc_length - contacts.arc_length[:, None]))
    force_error, place_error = (np.abs(errors) for errors in zip(*found, strict=True))
    missed = np.isnan(place_error)
    place = float(place_error[~missed].mean()) if not missed.all() else float("nan")
    return ContactErrors(float(force_error.mean()), place, float(missed.mean()))
