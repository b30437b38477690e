"""Estimators of contact by name, alike for a finger in its plane and for one that leaves it.

Leading axes are free; D joint positions, way after way; R readings.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np

from soft_gripper.arrays import Array
from soft_gripper.estimators.estimate import SpatialContact
from soft_gripper.estimators.force_posterior import ContactPosterior
from soft_gripper.estimators.shape_functions import spatial_function
from soft_gripper.estimators.uncertainty import Uncertainty
from soft_gripper.extras.studies.contacts.contacts import Contacts
from soft_gripper.fingers.finger import Finger
from soft_gripper.fingers.kinematics import as_planar
from soft_gripper.scenario.named_estimators import estimator_function
from soft_gripper.sensors.measurement import MeasurementModel, SpatialSensors


@dataclass(frozen=True)
class Estimator:
    """An estimator of shape and contact."""

    function: Any
    is_spatial: bool

    @classmethod
    def of(cls, name: str, layout: MeasurementModel, assumed: Uncertainty) -> "Estimator":
        """The estimator of a name, with the nominal sensors and finger.

        Raises:
            InputError: if there is none for these sensors.
        """
        is_spatial = isinstance(layout, SpatialSensors)
        return cls((spatial_function if is_spatial else estimator_function)(name, layout, assumed), is_spatial)

    def __call__(self, readings: Array, driving: Array, gravity: Array) -> Any:
        """The shape, from readings (..., R), driving torque (..., D) N m and gravity in B, (..., 3) m/s^2."""
        return self.function(readings, driving, self._gravity(gravity))

    def posterior(self, readings: Array, driving: Array, gravity: Array) -> ContactPosterior:
        """What is known of one contact."""
        found: Any = self.function.posterior(readings, driving, self._gravity(gravity))
        return found.known if self.is_spatial else found

    def _gravity(self, gravity: Array) -> Any:
        return gravity if self.is_spatial else as_planar(gravity[..., ::2])


@dataclass(frozen=True)
class FoundContact:
    """Contacts as estimated, each (...); NaN where none is found."""

    force: Array  # N, along the normals of the faces that are pressed; negative on the opposite face
    force_std: Array  # N
    arc_length: Array  # m
    arc_length_std: Array  # m
    degrees: Array  # between the true and the estimated force; NaN for a finger in its plane

    @classmethod
    def of(cls, contact: Any, contacts: Contacts) -> "FoundContact":
        """What is found of contacts, (M), each (..., M).

        In space the friction is estimated as well: its share is taken to be the true one.
        """
        if not isinstance(contact, SpatialContact):
            signed = np.where(contacts.is_inside, contact.force, -contact.force)
            found = signed, contact.force_std, contact.arc_length, contact.arc_length_std
            return cls(*found, np.full(signed.shape, np.nan))
        size, true = (np.linalg.norm(force, axis=-1) for force in (contact.force, contacts.force))
        cosine = (contacts.force * contact.force).sum(axis=-1) / (true * size + 1e-30)
        degrees = np.where(size > 0, np.degrees(np.arccos(np.clip(cosine, -1, 1))), np.nan)
        std = np.linalg.norm(contact.force_std, axis=-1)
        place, place_std = contact.across.arc_length, contact.across.arc_length_std
        return cls(size / (true / contacts.normal_force), std, place, place_std, degrees)


def driving_torque(finger: Finger, ways: tuple[str, ...], pressure: Array) -> Array:
    """Torque of pressures at the joints, (..., D) N m: of one chamber, (...) Pa."""
    bending = finger.pressure_torque(pressure)
    return np.concatenate([bending, *[np.zeros_like(bending)] * (len(ways) - 1)], axis=-1)
