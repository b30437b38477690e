"""Contacts of fingers in MuJoCo, as the table of patches from which the ground truth of contact is computed.

MuJoCo has points, so a patch is a point, without an area. A sensor for every link and object, and one for every link
and all that it touches, since a sensor of MuJoCo does not say what touches.
"""

import xml.etree.ElementTree as ET
from collections import Counter
from collections.abc import Mapping, Sequence
from copy import copy
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import NDArray
from pydrake.geometry import GeometryId

from soft_gripper.arrays import Array
from soft_gripper.diagrams.station_parts import Station
from soft_gripper.fingers.spatial_chain import vector_product
from soft_gripper.truth.contact import COLUMNS, NO_OBJECT, TrueContact

if TYPE_CHECKING:  # it is optional
    import mujoco

TRUTH = "true_contact"  # the block that summarizes contact
_DATA = "found force torque pos normal tangent"
_SIZE = 16  # numbers of one contact
FEWEST = 8  # contacts that a sensor can report: a link may touch several shapes of an object
_FOUND, _FORCE, _TORQUE, _PLACE, _NORMAL, _TANGENT = (0, *(slice(i, i + 3) for i in (1, 4, 7, 10, 13)))


class _Touched(NamedTuple):
    """A link of a finger."""

    body: str
    base: str  # the body of its finger's base
    finger: int
    link: int
    begin: float  # m, arc length at its frame


class TouchSensors:
    """Sensors of contact of the fingers of a station; none if contact is not recorded."""

    def __init__(self, station: Station):
        inspector = station.parts.scene_graph.model_inspector()
        objects: Mapping[int, int] | None = None  # the numbers of the objects to which geometries belong
        if station.diagram.HasSubsystemNamed(TRUTH):
            truth: TrueContact = station.diagram.GetSubsystemByName(TRUTH)
            objects = truth.objects
        self.links: list[_Touched] = []
        for number, finger in enumerate(() if objects is None else station.fingers):
            names, begins = [str(link.scoped_name()) for link in finger.links], finger.finger.link_ends.tolist()
            self.links += [_Touched(name, names[0], number, i, begins[i]) for i, name in enumerate(names)]
        every = {each.get_value(): each for each in inspector.GetAllGeometryIds()}
        shapes = Counter((_body(station, every[geometry]), number) for geometry, number in (objects or {}).items())
        self.objects = list(shapes)  # bodies of objects, and the numbers of these
        parts = 2 if max(shapes.values(), default=1) > 1 else 1
        self._most = max(FEWEST, most_shapes(station) * parts)  # contacts of a sensor
        self._begins = np.array([[link.begin for link in self.links]])  # m, of links in each environment, or in all
        self._bodies = self._bases = np.zeros(len(self.links), int)

    def add_to(self, root: ET.Element) -> None:
        """Adds the sensors to a file."""
        if not self.links:
            return
        part = ET.SubElement(root, "sensor")
        for link in self.links:
            for other in (*(name for name, _ in self.objects), None):
                settings = {"body1": link.body, "num": str(self._most), "data": _DATA, "reduce": "none"}
                ET.SubElement(part, "contact", settings if other is None else settings | {"body2": other})

    def bind(self, model: "mujoco.MjModel") -> None:
        """Finds the links in a model."""
        self._bodies = np.array([model.body(link.body).id for link in self.links], int)
        self._bases = np.array([model.body(link.base).id for link in self.links], int)

    def beside(self, others: Sequence["TouchSensors"]) -> "TouchSensors":
        """These sensors where each environment has fingers as long as those of another one's."""
        found = copy(self)
        found._begins = np.concatenate([other._begins for other in others])
        return found

    def read(self, sensed: Array, xpos: Array, xmat: Array) -> tuple[Array, NDArray[np.int_]]:
        """Rows of `patch_table`, (P, 34), and where those of each environment begin, (E + 1,).

        Args:
            sensed: the readings of all sensors, (E, ...).
            xpos, xmat: poses of all bodies, (E, B, 3) and (E, B, 9).
        """
        if not self.links:
            return np.empty((0, COLUMNS)), np.zeros(len(sensed) + 1, int)
        all_contacts = sensed.reshape(len(sensed), len(self.links), len(self.objects) + 1, self._most, _SIZE)
        cells = np.nonzero(all_contacts[..., 0, _FOUND])  # sensors that report any: most report none
        reported = all_contacts[cells]
        number, slot = np.nonzero(reported[..., _FOUND] > 0)
        found, (environment, link, other) = reported[number, slot], (each[number] for each in cells)
        kept = self._once(environment * len(self.links) + link, other, found[:, _PLACE])
        environment, link, other, found = environment[kept], link[kept], other[kept], found[kept]
        rows = np.empty((len(found), COLUMNS))
        of_link = np.array([(each.finger, each.link) for each in self.links])
        begins = np.broadcast_to(self._begins, (len(sensed), len(self.links)))
        rows[:, :2], rows[:, 2], rows[:, 3] = of_link[link], begins[environment, link], 1.0
        rows[:, 4:7], rows[:, 7:10] = found[:, _PLACE], found[:, _NORMAL]
        rows[:, 10:13], rows[:, 13:16] = np.moveaxis(-_wrenches(found), 1, 0)
        body = self._bodies[link]
        X_WL = np.concatenate([xmat[environment, body].reshape(-1, 3, 3), xpos[environment, body][:, :, None]], axis=2)
        rows[:, 16:28] = X_WL.reshape(-1, 12)
        rows[:, 28] = np.array([*(number for _, number in self.objects), NO_OBJECT])[other]
        rows[:, 29:31], rows[:, 31:] = np.nan, xpos[environment, self._bases[link]]
        return rows, np.searchsorted(environment, np.arange(len(sensed) + 1))

    def _once(self, cell: NDArray[np.int_], other: NDArray[np.int_], place: Array) -> NDArray[np.bool_]:
        """Which contacts are not those with an object that the sensor of all that a link touches reports once more.

        Args:
            cell: environment and link of each, (P,), in rising order.
            other: number of the sensor, (P,); that of all comes last.
            place: of the contact, (P, 3) m.
        """
        is_of_all = other == len(self.objects)
        if not self.objects:
            return is_of_all
        total, with_object = (
            np.bincount(cell[which], minlength=cell.max(initial=-1) + 1) for which in (is_of_all, ~is_of_all)
        )
        kept = ~is_of_all
        for each in np.flatnonzero(total > with_object):  # it touches something else too
            own = cell == each
            known = {row.tobytes() for row in place[own & ~is_of_all]}
            kept[own & is_of_all] = [row.tobytes() not in known for row in place[own & is_of_all]]
        return kept


def most_shapes(station: Station) -> int:
    """The largest number of shapes of a link of a finger."""
    links = (link for finger in station.fingers for link in finger.links)
    return max((len(station.plant.GetCollisionGeometriesForBody(link)) for link in links), default=1)


def _wrenches(found: Array) -> Array:
    """Forces and torques of contacts on what a link touches, in the world, (P, 2, 3)."""
    normal, tangent = found[:, _NORMAL], found[:, _TANGENT]
    frames = np.stack([normal, tangent, vector_product(normal, tangent)], axis=1)
    local = np.stack([found[:, _FORCE], found[:, _TORQUE]], axis=1)
    return np.asarray(local @ frames)


def _body(station: Station, geometry: GeometryId) -> str:
    inspector = station.parts.scene_graph.model_inspector()
    return str(station.plant.GetBodyFromFrameId(inspector.GetFrameId(geometry)).scoped_name())
