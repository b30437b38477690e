"""Normal forces of fingers in MuJoCo, which suffice for rewards.

Their sensors return a fifth of the numbers of those of `touching`, and need no table of patches.
"""

import xml.etree.ElementTree as ET
from typing import TYPE_CHECKING

import numpy as np

from soft_gripper.arrays import Array
from soft_gripper.diagrams.station_parts import Station
from soft_gripper.extras.mujoco_engine.touching import MIN_CONTACTS, max_link_shapes

if TYPE_CHECKING:  # it is optional
    import mujoco


class NormalForces:
    """Contact sensors, one per finger of a station."""

    def __init__(self, station: Station):
        self._roots = [str(finger.links[0].scoped_name()) for finger in station.fingers]
        link_contacts = max(MIN_CONTACTS, max_link_shapes(station))
        self._max_contacts = [link_contacts * len(finger.links) for finger in station.fingers]  # contacts of a finger

    def add_to(self, root: ET.Element) -> None:
        """Adds the sensors to a file."""
        element = ET.SubElement(root, "sensor")
        for finger, max_contacts in zip(self._roots, self._max_contacts, strict=True):
            ET.SubElement(element, "contact", subtree1=finger, num=str(max_contacts), data="force", reduce="none")

    def bind(self, model: "mujoco.MjModel") -> None:
        """Does nothing: sensors are read in their order."""

    def read(self, sensed: Array) -> Array:
        """Sum of the normal forces on each of F fingers, (..., F) N, from the readings of all sensors, (..., n)."""
        along_normals = np.abs(sensed[..., ::3])
        return np.add.reduceat(along_normals, np.cumsum([0, *self._max_contacts[:-1]]), axis=-1)
