"""Fingers at rest, in the plane and in space, some of which are touched."""

import numpy as np
import pytest

from soft_gripper.extras.placement.samples import Samples
from soft_gripper.extras.studies.contacts.contacts import Contacts
from soft_gripper.extras.studies.contacts.statics import contacts_in_space, rubbing_contacts
from soft_gripper.scenario.schema import SensorConfig


def as_samples(contacts: Contacts, run: str = "contacts") -> Samples:
    """Each read at once."""
    return Samples(
        run, SensorConfig(), contacts.q[None], contacts.pressure[None, :, None], None, np.array([0]), contacts
    )


@pytest.fixture(scope="session")
def in_plane() -> Samples:
    return as_samples(rubbing_contacts(24, 0.2, 0.5, 1))


@pytest.fixture(scope="session")
def in_space() -> Samples:
    return as_samples(contacts_in_space(12, 0.2, 2, places=(0.4, 0.99)))
