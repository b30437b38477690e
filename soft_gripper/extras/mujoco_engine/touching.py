"""Contacts of fingers in MuJoCo, as the table of patches for the ground truth of contact.

MuJoCo has points, so a patch is a point, without an area. There is a sensor for every link and object, and one for
every link and any body, since a sensor of MuJoCo does not name the other body.
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
_CONTACT_DATA = "found force torque pos normal tangent"
_CONTACT_SIZE = 16  # numbers of one contact
MIN_CONTACTS = 8  # minimum of contacts that a sensor can report: a link may touch several shapes of an object
_FOUND_COLUMN, _FORCES, _TORQUES, _PLACES, _NORMALS, _TANGENTS = (0, *(slice(i, i + 3) for i in (1, 4, 7, 10, 13)))


class _TouchedLink(NamedTuple):
    """A link of a finger, by finger and link number."""

    body: str
    base: str  # the body of its finger's base
    finger: int
    link: int
    begin: float  # m, arc length at its frame


class TouchSensors:
    """Contact sensors of a station's fingers; none if contact is not recorded."""

    def __init__(self, station: Station):
        inspector = station.parts.scene_graph.model_inspector()
        objects: Mapping[int, int] | None = None  # the numbers of the objects to which geometries belong
        if station.diagram.HasSubsystemNamed(TRUTH):
            truth: TrueContact = station.diagram.GetSubsystemByName(TRUTH)
            objects = truth.objects
        self.links: list[_TouchedLink] = []
        for number, finger in enumerate(() if objects is None else station.fingers):
            names = [str(link.scoped_name()) for link in finger.links]
            begins = finger.finger.link_ends.tolist()
            self.links += [_TouchedLink(name, names[0], number, i, begins[i]) for i, name in enumerate(names)]
        geometry_ids = {geometry_id.get_value(): geometry_id for geometry_id in inspector.GetAllGeometryIds()}
        shapes = Counter((_body(station, geometry_ids[key]), number) for key, number in (objects or {}).items())
        self.objects = list(shapes)  # bodies of objects, and the numbers of these
        shapes_per_link = 2 if max(shapes.values(), default=1) > 1 else 1
        self._max_contacts = max(MIN_CONTACTS, max_link_shapes(station) * shapes_per_link)  # contacts of a sensor
        self._begins = np.array([[link.begin for link in self.links]])  # m, of links in each environment, or in all
        self._bodies = self._bases = np.zeros(len(self.links), int)

    def add_to(self, root: ET.Element) -> None:
        """Adds the sensors to a file."""
        if not self.links:
            return
        sensor_element = ET.SubElement(root, "sensor")
        for link in self.links:
            for body in (*(name for name, _ in self.objects), None):
                settings = {"body1": link.body, "num": str(self._max_contacts), "data": _CONTACT_DATA, "reduce": "none"}
                ET.SubElement(sensor_element, "contact", settings if body is None else settings | {"body2": body})

    def bind(self, model: "mujoco.MjModel") -> None:
        """Finds the links in a model."""
        self._bodies = np.array([model.body(link.body).id for link in self.links], int)
        self._bases = np.array([model.body(link.base).id for link in self.links], int)

    def with_environments(self, environment_sensors: Sequence["TouchSensors"]) -> "TouchSensors":
        """Copy for environments whose fingers have the lengths of those of other sensors, one each."""
        sensors = copy(self)
        sensors._begins = np.concatenate([sensor._begins for sensor in environment_sensors])
        return sensors

    def read(self, sensed: Array, xpos: Array, xmat: Array) -> tuple[Array, NDArray[np.int_]]:
        """Rows of `patch_table`, (P, 34), and where those of each environment begin, (E + 1,).

        Args:
            sensed: the readings of all sensors, (E, ...).
            xpos, xmat: poses of all bodies, (E, B, 3) and (E, B, 9).
        """
        if not self.links:
            return np.empty((0, COLUMNS)), np.zeros(len(sensed) + 1, int)
        sensors = len(self.links), len(self.objects) + 1
        all_contacts = sensed.reshape(len(sensed), *sensors, self._max_contacts, _CONTACT_SIZE)
        reporting = np.nonzero(all_contacts[..., 0, _FOUND_COLUMN])  # sensors that report contacts: most report none
        reports = all_contacts[reporting]
        sensor_rows, slot = np.nonzero(reports[..., _FOUND_COLUMN] > 0)
        contacts = reports[sensor_rows, slot]
        environment, link, sensor = (indices[sensor_rows] for indices in reporting)
        is_unique = self._find_unique(environment * len(self.links) + link, sensor, contacts[:, _PLACES])
        environment, link, sensor = environment[is_unique], link[is_unique], sensor[is_unique]
        contacts = contacts[is_unique]
        rows = np.empty((len(contacts), COLUMNS))
        link_numbers = np.array([(numbered.finger, numbered.link) for numbered in self.links])
        begins = np.broadcast_to(self._begins, (len(sensed), len(self.links)))
        rows[:, :2], rows[:, 2], rows[:, 3] = link_numbers[link], begins[environment, link], 1.0
        rows[:, 4:7], rows[:, 7:10] = contacts[:, _PLACES], contacts[:, _NORMALS]
        rows[:, 10:13], rows[:, 13:16] = np.moveaxis(-_wrenches(contacts), 1, 0)
        body = self._bodies[link]
        X_WL = np.concatenate([xmat[environment, body].reshape(-1, 3, 3), xpos[environment, body][:, :, None]], axis=2)
        rows[:, 16:28] = X_WL.reshape(-1, 12)
        rows[:, 28] = np.array([*(number for _, number in self.objects), NO_OBJECT])[sensor]
        rows[:, 29:31], rows[:, 31:] = np.nan, xpos[environment, self._bases[link]]
        return rows, np.searchsorted(environment, np.arange(len(sensed) + 1))

    def _find_unique(self, link_index: NDArray[np.int_], sensor: NDArray[np.int_], place: Array) -> NDArray[np.bool_]:
        """Mask of contacts without duplicates: the sensor for any body repeats contacts with objects.

        Args:
            link_index: environment and link of each, (P,), in rising order.
            sensor: number of the sensor, (P,); that of any body comes last.
            place: of the contact, (P, 3) m.
        """
        is_of_all = sensor == len(self.objects)
        if not self.objects:
            return is_of_all
        contact_counts, with_object = (
            np.bincount(link_index[mask], minlength=link_index.max(initial=-1) + 1) for mask in (is_of_all, ~is_of_all)
        )
        is_unique = ~is_of_all
        for number in np.flatnonzero(contact_counts > with_object):  # the link also touches bodies that are no objects
            is_in_cell = link_index == number
            object_places = {row.tobytes() for row in place[is_in_cell & ~is_of_all]}
            rows = place[is_in_cell & is_of_all]
            is_unique[is_in_cell & is_of_all] = [row.tobytes() not in object_places for row in rows]
        return is_unique


def max_link_shapes(station: Station) -> int:
    """Maximum number of shapes of a link of a finger."""
    links = (link for finger in station.fingers for link in finger.links)
    return max((len(station.plant.GetCollisionGeometriesForBody(link)) for link in links), default=1)


def _wrenches(contacts: Array) -> Array:
    """Forces and torques of contacts on the touched bodies, in the world, (P, 2, 3)."""
    normal, tangent = contacts[:, _NORMALS], contacts[:, _TANGENTS]
    frames = np.stack([normal, tangent, vector_product(normal, tangent)], axis=1)
    local = np.stack([contacts[:, _FORCES], contacts[:, _TORQUES]], axis=1)
    return np.asarray(local @ frames)


def _body(station: Station, geometry: GeometryId) -> str:
    inspector = station.parts.scene_graph.model_inspector()
    return str(station.plant.GetBodyFromFrameId(inspector.GetFrameId(geometry)).scoped_name())
