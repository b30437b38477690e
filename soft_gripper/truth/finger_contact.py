"""What presses on one finger, out of all patches of a plant; and what several fingers hold between them."""

from collections.abc import Collection, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from pydrake.geometry import GeometryId
from pydrake.math import RigidTransform
from pydrake.multibody.tree import BodyIndex

from soft_gripper.arrays import Array
from soft_gripper.fingers.plant_finger import PlantFinger
from soft_gripper.truth.contact_patches import Patch


@dataclass(frozen=True)
class TouchedLinks:
    """The links of a finger as contact results know them, from the base to the tip."""

    bodies: Sequence[BodyIndex]
    shapes: Sequence[Collection[GeometryId]]  # collision shapes of each
    begins: Sequence[float]  # m, arc lengths at their frames

    @classmethod
    def of(cls, finger: PlantFinger) -> "TouchedLinks":
        """Those of a finger in a finalized plant."""
        shapes = [finger.plant.GetCollisionGeometriesForBody(link) for link in finger.links]
        return cls([link.index() for link in finger.links], shapes, finger.finger.link_ends[:-1].tolist())

    @cached_property
    def link_of(self) -> dict[GeometryId, int]:
        """The numbers of the links, by their shapes."""
        return {shape: link for link, shapes in enumerate(self.shapes) for shape in shapes}


class FingerContact(NamedTuple):
    """All P patches in which a finger touches something else."""

    link: NDArray[np.int_]  # (P,) number of the link, 0 at the base
    arc_length: Array  # (P,) m from the base: where the centre of pressure lies along the axis of the link
    center: Array  # (P, 3) m, of the pressure, in the world
    normal: Array  # (P, 3) unit vectors in the world, either way
    total: Array  # (P,) N, magnitude of the force, friction included
    pressing: Array  # (P,) N, along the normal of the patch, not negative
    opening: Array  # (P,) N, across the link in the bending plane; positive on the inner side, so that it opens

    @property
    def mean_arc_length(self) -> float:
        """Arc length of the centre of pressure, m: by the sizes of `opening`; NaN without contact."""
        sizes = np.abs(self.opening)
        return float(sizes @ self.arc_length / sizes.sum()) if sizes.any() else float("nan")

    @property
    def mean_center(self) -> Array:
        """Centre of all that presses, (3,) m in the world; NaN without contact."""
        force = self.pressing.sum()
        return self.pressing @ self.center / force if force else np.full(3, np.nan)

    @property
    def main_normal(self) -> Array:
        """Normal of the strongest patch, (3,) in the world, either way; NaN without contact."""
        return self.normal[np.argmax(self.pressing)] if self.pressing.any() else np.full(3, np.nan)


PLACES = ("true_contact_arc_length", "contact_center")  # of the signals below; the others are forces
NO_CONTACT = FingerContact(np.zeros(0, int), np.zeros(0), np.zeros((0, 3)), np.zeros((0, 3)), *np.zeros((3, 0)))


def finger_contact(finger: TouchedLinks, found: Sequence[Patch], X_WB: Sequence[RigidTransform]) -> FingerContact:
    """What presses on a finger from outside.

    A force that presses on the inner side pushes a link along the -x axis of its frame.

    Args:
        finger: its links.
        found: all patches of its plant.
        X_WB: poses of all bodies of the plant, in the order of their indices.
    """
    rows = [_row(finger, patch, X_WB) for patch in found if _touches_once(finger, patch)]
    return FingerContact(*map(np.array, zip(*rows, strict=True))) if rows else NO_CONTACT


def _touches_once(finger: TouchedLinks, patch: Patch) -> bool:
    first, second = (shape in finger.link_of for shape in patch.shapes)
    return first != second


def _row(finger: TouchedLinks, patch: Patch, X_WB: Sequence[RigidTransform]) -> tuple[object, ...]:
    """The entries of FingerContact for one patch."""
    is_first = patch.shapes[0] in finger.link_of
    link = finger.link_of[patch.shapes[0 if is_first else 1]]
    X_WL = X_WB[finger.bodies[link]]
    x, _, z = X_WL.rotation().matrix().T
    force = patch.force if is_first else -patch.force
    along = float(z @ (patch.center - X_WL.translation()))
    pressing = abs(float(patch.force @ patch.normal))
    where = (link, finger.begins[link] + along, patch.center, patch.normal)
    return (*where, float(np.linalg.norm(force)), pressing, -float(force @ x))


def contact_signals(contact: FingerContact, links: int) -> dict[str, Array]:
    """What `TrueContact` puts out of a finger of so many links; see there."""
    return {
        "link_contact_force": np.bincount(contact.link, contact.total, links),
        "link_normal_force": np.bincount(contact.link, contact.opening, links),
        "true_contact_force": contact.opening.sum(keepdims=True),
        "true_contact_total": contact.total.sum(keepdims=True),
        "true_contact_arc_length": np.array([contact.mean_arc_length]),
        "normal_force": contact.pressing.sum(keepdims=True),
        "contact_center": contact.mean_center,
    }


def contact_width(contacts: Sequence[FingerContact]) -> float:
    """Width between what all fingers touch, m; NaN unless there are two fingers or more, and all touch something.

    Twice the mean over the fingers of how far their centres of force lie from the centroid of these, along the normal
    at each: of two fingers on parallel faces, the distance of the faces; of more around a cylinder, its diameter.
    """
    centers = np.array([contact.mean_center for contact in contacts])
    if len(contacts) < 2 or not np.isfinite(centers).all():
        return float("nan")
    from_middle = centers - centers.mean(axis=0)
    along = [abs(float(arm @ contact.main_normal)) for arm, contact in zip(from_middle, contacts, strict=True)]
    return 2 * sum(along) / len(along)
