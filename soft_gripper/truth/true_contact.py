"""TrueContact: what really presses on the fingers, for estimates to be compared with."""

from collections.abc import Iterator, Mapping, Sequence, Set
from functools import partial
from typing import NamedTuple

import numpy as np
from pydrake.common.value import AbstractValue, Value
from pydrake.geometry import ContactSurface, GeometryId
from pydrake.multibody.plant import ContactResults
from pydrake.systems.framework import BasicVector, Context, LeafSystem, ValueProducer

from soft_gripper.arrays import Array
from soft_gripper.signals import XYZ, describe

Shapes = Set[GeometryId]


class Patch(NamedTuple):
    """Where two shapes touch."""

    shapes: frozenset[GeometryId]
    center: Array  # (3,) m, of the pressure, in the world
    normal: Array  # (3,) unit vector in the world, either way
    force: float  # N, along the normal


class Touch(NamedTuple):
    """All that presses on a finger."""

    force: float  # N, sum over the patches
    center: Array  # (3,) m, of the force, in the world; NaN without contact
    normal: Array  # (3,) unit vector in the world, of the strongest patch; NaN without contact


def patches(results: ContactResults) -> Iterator[Patch]:
    """All contacts of a plant. The force of a surface is taken along its mean normal, in the centre of pressure."""
    for i in range(results.num_hydroelastic_contacts()):
        info = results.hydroelastic_contact_info(i)
        surface = info.contact_surface()
        normal = _mean_normal(surface)
        force = float(info.F_Ac_W().translational() @ normal)
        lever = np.cross(normal, info.F_Ac_W().rotational()) / force if force else np.zeros(3)
        yield Patch(frozenset((surface.id_M(), surface.id_N())), surface.centroid() + lever, normal, abs(force))
    for i in range(results.num_point_pair_contacts()):
        point = results.point_pair_contact_info(i)
        pair = point.point_pair()
        force = abs(float(point.contact_force() @ pair.nhat_BA_W))
        yield Patch(frozenset((pair.id_A, pair.id_B)), point.contact_point(), pair.nhat_BA_W, force)


def _mean_normal(surface: ContactSurface) -> Array:
    total = sum(surface.area(i) * surface.face_normal(i) for i in range(surface.num_faces()))
    return total / np.linalg.norm(total)


def touch(finger: Shapes, found: list[Patch]) -> Touch:
    """What presses on a finger from outside."""
    outer = [patch for patch in found if len(patch.shapes & finger) == 1]
    force = sum(patch.force for patch in outer)
    if force == 0:
        return Touch(0.0, np.full(3, np.nan), np.full(3, np.nan))
    center: Array = np.sum([patch.force * patch.center for patch in outer], axis=0) / force
    return Touch(force, center, max(outer, key=lambda patch: patch.force).normal)


def contact_width(touches: Sequence[Touch]) -> float:
    """Width between what all fingers touch, m; NaN unless there are two fingers or more, and all touch something.

    Twice the mean over the fingers of how far their centres of force lie from the centroid of these, along the normal
    at each: of two fingers on parallel faces, the distance of the faces; of more around a cylinder, its diameter.
    """
    centers = np.array([touch.center for touch in touches])
    if len(touches) < 2 or not np.isfinite(centers).all():
        return float("nan")
    from_middle = centers - centers.mean(axis=0)
    along = [abs(float(arm @ touch.normal)) for arm, touch in zip(from_middle, touches, strict=True)]
    return 2 * sum(along) / len(along)


class TrueContact(LeafSystem):
    """Sums up the plant's contact results for the fingers.

    ::

                            +-------------+ ---> {finger}.normal_force    (1) N, all that presses on a finger
        contact_results --> | TrueContact | ---> {finger}.contact_center  (3) m, of that force, in the world
                            +-------------+ ---> width                    (1) m, between what all fingers touch

    Without contact the centre is NaN; for the width see `contact_width`.
    """

    def __init__(self, fingers: Mapping[str, Shapes]):
        """`fingers` are the collision shapes of the fingers, by their names."""
        super().__init__()
        self._fingers = dict(fingers)
        self._results = self.DeclareAbstractInputPort("contact_results", Value(ContactResults()))
        producer = ValueProducer(allocate=lambda: AbstractValue.Make(object()), calc=self._collect)
        self._touches = self.DeclareCacheEntry("touches", producer, {self._results.ticket()})
        ticket = {self.cache_entry_ticket(self._touches.cache_index())}
        for i, name in enumerate(self._fingers):
            force = self.DeclareVectorOutputPort(f"{name}.normal_force", 1, partial(self._calc_force, i), ticket)
            center = self.DeclareVectorOutputPort(f"{name}.contact_center", 3, partial(self._calc_center, i), ticket)
            describe(force, "N")
            describe(center, "m", xyz=XYZ)
        describe(self.DeclareVectorOutputPort("width", 1, self._calc_width, ticket), "m")

    def _collect(self, context: Context, value: AbstractValue) -> None:
        found = list(patches(self._results.Eval(context)))
        value.set_value([touch(shapes, found) for shapes in self._fingers.values()])

    def _calc_force(self, finger: int, context: Context, output: BasicVector) -> None:
        output.SetFromVector([self._touches.Eval(context)[finger].force])

    def _calc_center(self, finger: int, context: Context, output: BasicVector) -> None:
        output.SetFromVector(self._touches.Eval(context)[finger].center)

    def _calc_width(self, context: Context, output: BasicVector) -> None:
        output.SetAtIndex(0, contact_width(self._touches.Eval(context)))
