"""Forces of fingers along the normals of their contacts in MuJoCo: all that a reward needs of a contact.

They are a fifth of what `touching` reads, and known without its table.
"""

import xml.etree.ElementTree as ET
from typing import TYPE_CHECKING

import numpy as np

from soft_gripper.arrays import Array
from soft_gripper.diagrams.station_parts import Station
from soft_gripper.extras.mujoco_engine.touching import FEWEST, most_shapes

if TYPE_CHECKING:  # it is optional
    import mujoco


class NormalForces:
    """A sensor of contact for every finger of a station."""

    def __init__(self, station: Station):
        self._roots = [str(finger.links[0].scoped_name()) for finger in station.fingers]
        of_link = max(FEWEST, most_shapes(station))
        self._most = [of_link * len(finger.links) for finger in station.fingers]  # contacts of a finger

    def add_to(self, root: ET.Element) -> None:
        """Adds the sensors to a file."""
        part = ET.SubElement(root, "sensor")
        for finger, most in zip(self._roots, self._most, strict=True):
            ET.SubElement(part, "contact", subtree1=finger, num=str(most), data="force", reduce="none")

    def bind(self, model: "mujoco.MjModel") -> None:
        """Sensors are read in their order."""

    def read(self, sensed: Array) -> Array:
        """The sum of the normal forces on each of F fingers, (..., F) N, from the readings of all sensors, (..., n)."""
        along_normals = np.abs(sensed[..., ::3])
        forces: Array = np.add.reduceat(along_normals, np.cumsum([0, *self._most[:-1]]), axis=-1)
        return forces
