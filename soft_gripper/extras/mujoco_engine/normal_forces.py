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
    """A sensor of contact for every link of the fingers of a station."""

    def __init__(self, station: Station):
        self._links = [[str(link.scoped_name()) for link in finger.links] for finger in station.fingers]
        self._most = max(FEWEST, most_shapes(station))  # contacts of a link
        self._begins = np.cumsum([0, *map(len, self._links[:-1])])  # of the links of each finger among all

    def add_to(self, root: ET.Element) -> None:
        """Adds the sensors to a file."""
        part = ET.SubElement(root, "sensor")
        for link in (link for links in self._links for link in links):
            ET.SubElement(part, "contact", body1=link, num=str(self._most), data="force", reduce="none")

    def bind(self, model: "mujoco.MjModel") -> None:
        """Sensors are read in their order."""

    def read(self, sensed: Array) -> Array:
        """The sum of the normal forces on each of F fingers, (..., F) N, from the readings of all sensors, (..., n)."""
        of_links = np.abs(sensed.reshape(*sensed.shape[:-1], -1, self._most, 3)[..., 0]).sum(axis=-1)
        forces: Array = np.add.reduceat(of_links, self._begins, axis=-1)
        return forces
