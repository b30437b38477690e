"""Contacts as estimated, and compared with the true ones, alike for a finger in its plane and for one that leaves it.

Leading axes are free; D joint positions, way after way.
"""

from dataclasses import dataclass

import numpy as np

from soft_gripper.arrays import Array
from soft_gripper.estimators.estimate import ContactForce
from soft_gripper.fingers.finger import Finger
from studies.contacts.contacts import Contacts


@dataclass(frozen=True)
class FoundContact:
    """Contacts as estimated, each (...); NaN where none is found."""

    force: Array  # N, along the normals of the faces that are pressed; negative on the opposite face
    force_std: Array  # N
    arc_length: Array  # m
    arc_length_std: Array  # m
    transverse_force: Array  # N, the size of the part that bends the finger
    degrees: Array  # between the true and the estimated force; NaN for a finger in its plane

    @classmethod
    def of(cls, contact: ContactForce | None, contacts: Contacts, in_space: bool = False) -> "FoundContact":
        """Estimates of contacts, (M), each (..., M).

        In space the friction is estimated as well: its share is taken to be the true one.
        """
        assert contact is not None
        unknown = np.full(contact.force.shape, np.nan)
        transverse = unknown if contact.transverse_force is None else contact.transverse_force
        if not in_space:
            signed = np.where(contacts.is_inside, contact.force, -contact.force)
            found = signed, contact.force_std, contact.arc_length, contact.arc_length_std
            return cls(*found, transverse, unknown)
        assert contact.vector is not None
        assert contact.vector_covariance is not None
        size, true = (np.linalg.norm(force, axis=-1) for force in (contact.vector, contacts.force))
        cosine = (contacts.force * contact.vector).sum(axis=-1) / (true * size + 1e-30)
        degrees = np.where(size > 0, np.degrees(np.arccos(np.clip(cosine, -1, 1))), np.nan)
        of_normal = np.divide(contacts.normal_force, true, out=np.ones(true.shape), where=true > 0)
        std = np.sqrt(np.trace(contact.vector_covariance, axis1=-2, axis2=-1))
        return cls(size * of_normal, std, contact.arc_length, contact.arc_length_std, transverse, degrees)


def driving_torque(finger: Finger, ways: tuple[str, ...], pressure: Array) -> Array:
    """Torque of pressures at the joints, (..., D) N m: of one chamber, (...) Pa."""
    bending = finger.pressure_torque(pressure)
    return np.concatenate([bending, *[np.zeros_like(bending)] * (len(ways) - 1)], axis=-1)
