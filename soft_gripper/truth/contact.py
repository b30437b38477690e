"""Ground truth of contact: patches where geometries touch, forces on each finger, and the object that fingers hold.

The patches of several samples lie one after the other: P of them in T samples.

The block keeps raw patches, a table per sample, and forces and locations are computed after the run. Their number
varies, so they have an abstract port, and the block logs them itself. Only the mean normals of surfaces are computed at
once, since Drake's surfaces do not outlive the sample.
"""

from collections.abc import Collection, Container, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from operator import attrgetter, itemgetter
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray
from pydrake.common.value import AbstractValue, Value
from pydrake.geometry import ContactSurface, PolygonSurfaceMesh
from pydrake.math import RigidTransform
from pydrake.multibody.plant import ContactResults
from pydrake.multibody.tree import BodyIndex
from pydrake.systems.framework import Context

from soft_gripper.array_block import ArrayBlock
from soft_gripper.arrays import Array
from soft_gripper.fingers.plant_finger import PlantFinger
from soft_gripper.run_begin import declare_run_time
from soft_gripper.signals import XYZ


class Patch(NamedTuple):
    """A patch on which two geometries touch.

    Geometries are known by the values of their GeometryIds: a block that kept ids would keep the plant that gave them.
    """

    geometries: tuple[int, int]
    place: Array  # (3,) m, of the patch, in the world
    normal: Array  # (3,) in the world, either way, of any length
    force: Array  # (3,) N in the world, including friction, on the first geometry; the second receives the opposite
    torque: Array  # (3,) N m in the world, about the place
    area: float = np.nan  # m^2; NaN where points touch
    pressure: float = np.nan  # Pa, the largest; NaN where points or soft objects touch


def patches(results: ContactResults, geometries: Container[int]) -> Iterator[Patch]:
    """Yields all contacts of geometries of a plant, given by the values of their ids.

    The normal of a surface is the mean over its faces.
    """
    for i in range(results.num_hydroelastic_contacts()):
        info = results.hydroelastic_contact_info(i)
        surface = info.contact_surface()
        pair = (surface.id_M().get_value(), surface.id_N().get_value())
        if pair[0] in geometries or pair[1] in geometries:
            wrench = info.F_Ac_W()
            force, torque = wrench.translational(), wrench.rotational()
            area, pressure = surface.total_area(), _largest_pressure(surface)
            yield Patch(pair, surface.centroid(), _area(surface), force, torque, area, pressure)
    for i in range(results.num_deformable_contacts()):
        soft_info = results.deformable_contact_info(i)
        mesh, pair = soft_info.contact_mesh(), (soft_info.id_A().get_value(), soft_info.id_B().get_value())
        if pair[0] in geometries or pair[1] in geometries:
            wrench = soft_info.F_Ac_W()
            force, torque = wrench.translational(), wrench.rotational()
            yield Patch(pair, mesh.centroid(), _area(mesh), force, torque, mesh.total_area())
    for i in range(results.num_point_pair_contacts()):
        point = results.point_pair_contact_info(i)
        point_pair = point.point_pair()
        pair = (point_pair.id_B.get_value(), point_pair.id_A.get_value())
        if pair[0] in geometries or pair[1] in geometries:
            yield Patch(pair, point.contact_point(), point_pair.nhat_BA_W, point.contact_force(), np.zeros(3))


def _area(surface: ContactSurface | PolygonSurfaceMesh) -> Array:
    """Sum of the face normals of a surface, weighted by their areas, (3,) m^2."""
    faces = range(surface.num_faces())
    normals = np.concatenate([*map(surface.face_normal, faces)]).reshape(-1, 3)
    area: Array = np.array([*map(surface.area, faces)]) @ normals
    return area


def _largest_pressure(surface: ContactSurface) -> float:
    """Largest elastic pressure on a surface, Pa, without the share that dissipation adds."""
    field = surface.tri_e_MN() if surface.is_triangle() else surface.poly_e_MN()
    return max(map(field.EvaluateAtVertex, range(surface.num_vertices())), default=0.0)


CONTACT_SIGNALS = (
    *("link_contact_force", "link_normal_force", "true_contact_force", "true_contact_total"),
    *("true_contact_arc_length", "normal_force", "contact_center", "true_contact_force_world", "true_contact_side"),
    "true_transverse_force",
)
# Units of places; the others are forces.
PLACES = {"true_contact_arc_length": "m", "contact_center": "m", "true_contact_side": "rad"}
VECTORS = ("contact_center", "true_contact_force_world")  # (3), in the world
COLUMNS = 34  # of a table of patches, see `patch_table`
_EMPTY_TABLE = np.empty((0, COLUMNS))


@dataclass(frozen=True)
class TouchedLinks:
    """The links of a finger as they appear in contact results, from the base to the tip."""

    bodies: Sequence[BodyIndex]
    geometries: Sequence[Collection[int]]  # collision geometries of each, values of their GeometryIds
    begins: Sequence[float]  # m, arc lengths at their frames
    only_bends: bool = True  # whether the finger stays in its plane

    @classmethod
    def from_finger(cls, finger: PlantFinger) -> "TouchedLinks":
        """The links of a finger in a finalized plant."""
        ids = map(finger.plant.GetCollisionGeometriesForBody, finger.links)
        geometries = [[geometry.get_value() for geometry in of_link] for of_link in ids]
        begins = finger.finger.link_ends[:-1].tolist()
        only_bends = tuple(finger.finger.yields) == ("bending",)
        return cls([link.index() for link in finger.links], geometries, begins, only_bends)

    @cached_property
    def link_of(self) -> dict[int, int]:
        """Link indices by geometry."""
        return {geometry: link for link, geometries in enumerate(self.geometries) for geometry in geometries}


class OwnLink(NamedTuple):
    """The link to which a geometry belongs."""

    finger: int
    link: int  # 0 at the base
    begin: float  # m, arc length at its frame
    body: BodyIndex
    base: BodyIndex  # of the finger


def links_by_geometry(fingers: Sequence[TouchedLinks]) -> dict[int, OwnLink]:
    """Maps the geometries of fingers to their links."""
    return {
        geometry: OwnLink(finger_index, link, finger.begins[link], finger.bodies[link], finger.bodies[0])
        for finger_index, finger in enumerate(fingers)
        for geometry, link in finger.link_of.items()
    }


NO_OBJECT = -1.0  # in the table: the finger touches none of the objects


def patch_table(
    external_patches: Iterable[Patch],
    links: Mapping[int, OwnLink],
    X_WB: Sequence[RigidTransform],
    objects: Mapping[int, int] | None = None,
) -> Array:
    """Raw external contacts of fingers as an array, (P, 34), which `finger_contacts` and `object_grip` interpret.

    Args:
        external_patches: of a plant.
        links: of the fingers, see `links_by_geometry`.
        X_WB: poses of all bodies of the plant, in the order of their indices.
        objects: numbers of the objects to which other geometries belong.
    """
    numbers = objects or {}
    rows: list[Array | tuple[float, ...]] = []
    for patch in external_patches:
        first, second = patch.geometries
        first_link, second_link = links.get(first), links.get(second)
        if first_link is not None and second_link is not None and first_link.finger == second_link.finger:
            continue
        for sign, link, other_geometry in ((1.0, first_link, second), (-1.0, second_link, first)):
            if link is not None:
                X_WL = X_WB[link.body].GetAsMatrix34()
                object_columns = (numbers.get(other_geometry, NO_OBJECT), patch.area, patch.pressure)
                p_WB = X_WB[link.base].translation()
                rows += [(link.finger, link.link, link.begin, sign), *patch[1:5], X_WL, object_columns, p_WB]
    return np.concatenate(rows, axis=None).reshape(-1, COLUMNS) if rows else _EMPTY_TABLE


class FingerContacts(NamedTuple):
    """P patches of contact between fingers and other bodies, in T samples."""

    is_evaluated: NDArray[np.bool_]  # (T,) samples with evaluated contacts
    sample: NDArray[np.int_]  # (P,) of the patch
    finger: NDArray[np.int_]  # (P,) number of the finger
    link: NDArray[np.int_]  # (P,) number of the link, 0 at the base
    arc_length: Array  # (P,) m from the base: location of the centre of pressure along the axis of the link
    center: Array  # (P, 3) m, of the pressure, in the world
    normal: Array  # (P, 3) unit vectors in the world, either way
    total: Array  # (P,) N, magnitude of the force, friction included
    pressing: Array  # (P,) N, along the normal of the patch, not negative
    opening: Array  # (P,) N, across the link in the bending plane; positive on the inner side, so that it opens
    force: Array  # (P, 3) N on the finger, in the world
    facing: Array  # (P, 2) along x and y of the link, of the unit vector that points out of the finger
    lever: Array  # (P, 3) m in the world, from the base to the place on the axis of the finger
    sideways: Array  # (P, 3) y axis of the link in the world

    def select(self, finger: int) -> "FingerContacts":
        """Contacts of one finger."""
        is_own = self.finger == finger
        return FingerContacts(self.is_evaluated, *(column[is_own] for column in self[1:]))

    def sums(self, values: Array) -> Array:
        """Sums over the patches of each sample, (P,) -> (T,); NaN where they are not known."""
        return np.where(self.is_evaluated, np.bincount(self.sample, values, self.samples), np.nan)

    def link_sums(self, values: Array, links: int) -> Array:
        """Sums over the patches of each link, of so many, (P,) -> (T, links); NaN where they are not known."""
        row = self.sample * links + self.link
        sums = np.bincount(row, values, self.samples * links).reshape(self.samples, links)
        return np.where(self.is_evaluated[:, None], sums, np.nan)

    @property
    def samples(self) -> int:
        """Number of samples, T."""
        return len(self.is_evaluated)

    @property
    def mean_arc_length(self) -> Array:
        """Arc length of the centre of pressure, (T,) m: by the sizes of `opening`; NaN without contact."""
        sizes = np.abs(self.opening)
        return _ratio(self.sums(sizes * self.arc_length), self.sums(sizes))

    @property
    def mean_center(self) -> Array:
        """Centre of all contact forces, (T, 3) m in the world; NaN without contact."""
        total = self.sums(self.pressing)
        return np.stack([_ratio(self.sums(self.pressing * part), total) for part in self.center.T], axis=-1)

    @property
    def total_force(self) -> Array:
        """Sum of the forces on the finger, friction included, (T, 3) N in the world."""
        return np.stack([self.sums(part) for part in self.force.T], axis=-1)

    def transverse_force(self, only_bends: bool) -> Array:
        """Size of the part of the total force that bends the finger, (T,) N.

        It is at right angles to the line from the base to the place on the axis where the finger is pressed, the mean
        over all patches by their forces, and in the bending plane, if the finger `only_bends`.
        """
        force, lever = self.total_force, self._mean(self.lever)
        if only_bends:
            sideways = self._mean(self.sideways)
            force, lever = (vector - _projections(vector, sideways) for vector in (force, lever))
        return np.asarray(np.linalg.norm(force - _projections(force, lever), axis=-1))

    def _mean(self, vectors: Array) -> Array:
        """Means over the patches, weighted by their forces, (P, 3) -> (T, 3), up to a factor."""
        return np.stack([self.sums(self.total * part) for part in vectors.T], axis=-1)

    @property
    def side(self) -> Array:
        """Angle around the section at which the finger is pressed, (T,) rad: the mean direction; NaN without contact.

        0 on the inner side, pi / 2 on the side toward +y, pi on the outer side.
        """
        x, y = (self.sums(self.pressing * part) for part in self.facing.T)
        return np.where((x == 0) & (y == 0), np.nan, np.arctan2(y, x))

    @property
    def main_normal(self) -> Array:
        """Normal of the strongest patch, (T, 3) in the world, either way; NaN without contact."""
        order = np.argsort(-self.pressing, kind="stable")
        pressed_order = order[self.pressing[order] > 0]
        sample, first = np.unique(self.sample[pressed_order], return_index=True)
        normals = np.full((self.samples, 3), np.nan)
        normals[sample] = self.normal[pressed_order[first]]
        return normals


def finger_contacts(table: Array, sample: NDArray[np.int_], is_evaluated: NDArray[np.bool_]) -> FingerContacts:
    """External contacts of fingers.

    A force that presses on the inner side pushes a link along the -x axis of its frame. The pressure of a surface acts
    along its mean normal n, in its centre: at  n x torque / (force n)  from the place of the patch.

    Args:
        table: of patches, (P, 34), see `patch_table`.
        sample: that each belongs to, (P,), in rising order.
        is_evaluated: samples with evaluated contacts, (T,).
    """
    finger, link = table[:, :2].astype(int).T
    begin, sign = table[:, 2:4].T
    place, normal, force, torque = (table[:, begin : begin + 3] for begin in (4, 7, 10, 13))
    X_WL = table[:, 16:28].reshape(-1, 3, 4)
    normal = normal / np.linalg.norm(normal, axis=1, keepdims=True)
    pressing = (force * normal).sum(axis=1)
    center = place + np.cross(normal, torque) / np.where(pressing == 0, np.inf, pressing)[:, None]
    R_WL, x, z, origin = X_WL[..., :3], X_WL[..., 0], X_WL[..., 2], X_WL[..., 3]
    arc_length = begin + (z * (center - origin)).sum(axis=1)
    opening = -sign * (force * x).sum(axis=1)
    total = np.linalg.norm(force, axis=1)
    finger_force = sign[:, None] * force
    outward = -np.sign(sign * pressing)[:, None] * normal
    facing = (outward[:, None] @ R_WL)[:, 0, :2]
    lever = origin + (arc_length - begin)[:, None] * z - table[:, 31:34]
    return FingerContacts(
        *(is_evaluated, sample, finger, link, arc_length, center, normal, total),
        *(np.abs(pressing), opening, finger_force, facing, lever, X_WL[..., 1]),
    )


def contact_signals(contact: FingerContacts, links: int, only_bends: bool) -> dict[str, Array]:
    """The outputs of `TrueContact` for one finger with that many links, (T, ...) each."""
    values = (
        *(contact.link_sums(contact.total, links), contact.link_sums(contact.opening, links)),
        *(contact.sums(contact.opening), contact.sums(contact.total)),
        *(contact.mean_arc_length, contact.sums(contact.pressing), contact.mean_center),
        *(contact.total_force, contact.side, contact.transverse_force(only_bends)),
    )
    return dict(zip(CONTACT_SIGNALS, values, strict=True))


class ObjectGripForces(NamedTuple):
    """Grip of F fingers on one object, in T samples: the outputs of `TrueContact` for it."""

    grip_normal_force: Array  # (T, F) N, the sum of what presses, along the normal of each patch
    grip_friction_force: Array  # (T, F, 3) N on the object, in the world
    grip_force: Array  # (T, F, 3) N on the object, in the world: normal forces and friction as vectors
    grip_area: Array  # (T, F) m^2; NaN where points touch
    grip_pressure: Array  # (T, F) Pa, the largest on the surface; NaN where points touch


def object_grip(
    number: int, fingers: int, table: Array, sample: NDArray[np.int_], is_evaluated: NDArray[np.bool_]
) -> ObjectGripForces:
    """The grip of fingers on one object.

    Args:
        number: of the object, see `patch_table`.
        fingers: F, all of them.
        table, sample, is_evaluated: as for `finger_contacts`.
    """
    is_own = table[:, 28] == number
    rows = table[is_own]
    bin_index = sample[is_own] * fingers + rows[:, 0].astype(int)
    bins = len(is_evaluated) * fingers
    normal = rows[:, 7:10] / np.linalg.norm(rows[:, 7:10], axis=1, keepdims=True)
    force = -rows[:, 3:4] * rows[:, 10:13]
    pressing = (force * normal).sum(axis=1)
    friction = force - pressing[:, None] * normal
    largest = np.zeros(bins)
    with np.errstate(invalid="ignore"):  # numpy warns of NaN where points touch
        np.maximum.at(largest, bin_index, rows[:, 30])

    def sums(values: Array) -> Array:
        return np.bincount(bin_index, values, bins)

    sums_flat = (
        sums(np.abs(pressing)),
        *(np.stack([*map(sums, vectors.T)], axis=-1) for vectors in (friction, force)),
        sums(rows[:, 29]),
        largest,
    )
    gripped = [value.reshape(len(is_evaluated), fingers, *value.shape[1:]) for value in sums_flat]
    return ObjectGripForces(
        *(np.where(is_evaluated.reshape(-1, *[1] * (value.ndim - 1)), value, np.nan) for value in gripped)
    )


def contact_width(contacts: Sequence[FingerContacts]) -> Array:
    """Width between the contacts of all fingers, (T,) m; NaN unless two or more fingers all touch something.

    Twice the mean over the fingers of how far their centres of force lie from the centroid of these, along the normal
    at each: of two fingers on parallel faces, the distance of the faces; of more around a cylinder, its diameter.
    """
    centers = np.array([contact.mean_center for contact in contacts])
    if len(contacts) < 2:
        return np.full(max((contact.samples for contact in contacts), default=1), np.nan)
    from_middle = centers - centers.mean(axis=0)
    normals = np.array([contact.main_normal for contact in contacts])
    return 2 * np.abs((from_middle * normals).sum(axis=-1)).mean(axis=0)


def _projections(vectors: Array, line: Array) -> Array:
    """The parts of vectors along lines, (T, 3) each; 0 along a line without length."""
    square = (line**2).sum(axis=-1, keepdims=True)
    return np.asarray((vectors * line).sum(axis=-1, keepdims=True) / np.where(square == 0, 1.0, square) * line)


def _ratio(value: Array, divisor: Array) -> Array:
    """Ratio; NaN where the divisor is zero."""
    return value / np.where(divisor == 0, np.nan, divisor)


def combined_friction(friction: float, other_friction: float) -> float:
    """Coefficient of friction between two surfaces as Drake combines it, 2 a b / (a + b).

    See CalcContactFrictionFromSurfaceProperties.
    """
    return 2 * friction * other_friction / (friction + other_friction) if friction + other_friction > 0 else 0.0


TOUCH = 1e-3  # N, force above which a link counts as touched


def touches(force: Array) -> NDArray[np.bool_]:
    """Mask of the links that touch something, from the forces on them, (...) N."""
    return force > TOUCH


class TrueContact(ArrayBlock):
    """Summarizes the contact results of the plant for each finger.

    ::

                            +-------------+ ---> {finger}.link_contact_force       (N + 1) N, friction included
                            |             | ---> {finger}.link_normal_force        (N + 1) N, positive inside
        contact_results --> |             | ---> {finger}.true_contact_force       (1) N, positive inside
                            | TrueContact | ---> {finger}.true_contact_total       (1) N, friction included
        body_poses -------> |             | ---> {finger}.true_contact_arc_length  (1) m
                            |             | ---> {finger}.normal_force             (1) N, on what is touched
                            |             | ---> {finger}.contact_center           (3) m, of that, in the world
                            |             | ---> {finger}.true_contact_force_world (3) N, in the world
                            |             | ---> {finger}.true_contact_side        (1) rad, around the finger
                            |             | ---> {finger}.true_transverse_force    (1) N, which bends the finger
                            |             | ---> width                             (1) m, between what all touch
                            |             | ---> {object}.grip_normal_force        (F) N, of each finger on it
                            |             | ---> {object}.grip_friction_force      (F x 3) N on it, in the world
                            |             | ---> {object}.grip_force               (F x 3) N on it, in the world
                            |             | ---> {object}.grip_area                (F) m^2
                            +-------------+ ---> {object}.grip_pressure            (F) Pa, the largest

    Forces are those that the finger receives from outside. `true_contact_force` is the sum of `link_normal_force`: each
    across its link, in the bending plane, positive where it presses on the inner side, so that it opens the finger.
    `true_contact_total` is the sum of `link_contact_force`, magnitudes of all that touches a link;
    `true_contact_force_world` is the sum of these forces as vectors, `true_transverse_force` the size of its part at
    right angles to the line from the base to the contact: see `FingerContacts.transverse_force`. The arc length is
    that of the centre of pressure, the side where around the finger it presses, see `FingerContacts.side`.
    `normal_force` goes by the surfaces that touch instead: the sum of what presses, along the normal of each. Without
    contact forces are 0 and places NaN; for the width see `contact_width`.
    """

    def __init__(
        self,
        fingers: Mapping[str, TouchedLinks],
        interval: float | None = None,
        objects: Mapping[str, Collection[int]] | None = None,
    ):
        """
        Args:
            fingers: by their names.
            interval: at other times than its multiples from the beginning of a run, s, everything is NaN; None: never.
            objects: collision geometries of the objects that fingers may hold, by name; values of their GeometryIds.
        """
        super().__init__()
        self._interval = interval
        named = objects or {}
        self.objects = {geometry: number for number, geometries in enumerate(named.values()) for geometry in geometries}
        self._links = links_by_geometry(list(fingers.values()))
        self._results = self.DeclareAbstractInputPort("contact_results", Value(ContactResults()))
        self._poses = self.DeclareAbstractInputPort("body_poses", AbstractValue.Make([RigidTransform()]))
        self._run_time = declare_run_time(self)
        tickets = {self._results.ticket(), self._poses.ticket()}
        if interval is not None:
            tickets |= {self.time_ticket(), self.xd_ticket()}
        self.show("patches", self._collect, tickets)
        self.derive("table", lambda patches: _stack_tables([patches]), "patches", over_time=_stack_tables)
        self.derive("contacts", lambda table: finger_contacts(*table), "table")
        for number, (name, finger) in enumerate(fingers.items()):
            self._put_out_signals(number, name, finger)
        numbers = range(len(fingers))
        self.put_out("width", lambda contacts: contact_width([*map(contacts.select, numbers)]), "contacts", unit="m")
        for number, name in enumerate(named):
            self._put_out_grip(number, name, list(fingers))

    def _put_out_grip(self, number: int, name: str, fingers: Sequence[str]) -> None:
        step = f"{name}.grip"
        self.derive(step, lambda table: object_grip(number, len(fingers), *table), "table")
        for signal in ObjectGripForces._fields:
            unit = {"grip_area": "m^2", "grip_pressure": "Pa"}.get(signal, "N")
            axes = {"xyz": XYZ} if signal in ("grip_friction_force", "grip_force") else {}
            self.put_out(f"{name}.{signal}", attrgetter(signal), step, unit=unit, finger=fingers, **axes)

    def _put_out_signals(self, number: int, name: str, finger: TouchedLinks) -> None:
        links, only_bends = len(finger.bodies), finger.only_bends
        self.derive(name, lambda contacts: contact_signals(contacts.select(number), links, only_bends), "contacts")
        sizes = {"link_contact_force": links, "link_normal_force": links} | dict.fromkeys(VECTORS, 3)
        for signal in CONTACT_SIGNALS:
            unit, axes = PLACES.get(signal, "N"), _axes(signal, sizes.get(signal, 1))
            self.put_out(f"{name}.{signal}", itemgetter(signal), name, unit=unit, **axes)

    def _collect(self, context: Context) -> Array:
        """Collects the table of patches, without columns at omitted samples."""
        if self._interval is not None:
            intervals = self._run_time(context) / self._interval
            if abs(intervals - round(intervals)) > _TIME_TOLERANCE:
                return _LEFT_OUT
        contact_patches = list(patches(self._results.Eval(context), self._links))
        if not contact_patches:
            return _EMPTY_TABLE
        return patch_table(contact_patches, self._links, self._poses.Eval(context), self.objects)


_TIME_TOLERANCE = 1e-6  # of an interval, by which a time may differ from a multiple of it


_LEFT_OUT = np.empty((0, 0))


def _stack_tables(tables: Sequence[Array]) -> tuple[Array, NDArray[np.int_], NDArray[np.bool_]]:
    """One table of all samples, the sample of each patch, and a mask of the samples with evaluated contacts."""
    is_evaluated = np.array([table.shape[1] > 0 for table in tables])
    rows = [table.reshape(-1, COLUMNS) for table in tables]
    sample = np.repeat(np.arange(len(rows)), [len(table) for table in rows])
    return np.concatenate(rows), sample, is_evaluated


def _axes(signal: str, size: int) -> dict[str, Sequence[Any]]:
    """The axes of a signal with that many entries."""
    if size == 1:
        return {}
    return {"link": range(size)} if signal.startswith("link_") else {"xyz": XYZ}
