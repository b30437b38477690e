"""TrueContact: what really presses on two fingers, for estimates to be held against."""

from collections.abc import Iterator, Mapping, Set
from functools import partial
from typing import NamedTuple

import numpy as np
from pydrake.common.value import AbstractValue, Value
from pydrake.geometry import ContactSurface, GeometryId
from pydrake.multibody.plant import ContactResults
from pydrake.systems.framework import BasicVector, Context, LeafSystem, ValueProducer

from soft_gripper.arrays import Array

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


class TrueContact(LeafSystem):
    """Sums up the plant's contact results for two fingers.

                        +-------------+ ---> {finger}.normal_force    (1) N, all that presses on a finger
    contact_results --> | TrueContact | ---> {finger}.contact_center  (3) m, of that force, in the world
                        +-------------+ ---> width                    (1) m, between what both fingers touch

    Without contact the centre is NaN. The width is measured along the normal at the first finger, between the
    centres of force, and is NaN unless both fingers touch something.
    """

    def __init__(self, fingers: Mapping[str, Shapes]):
        """`fingers` are the collision shapes of both fingers, by their names."""
        super().__init__()
        self._fingers = dict(fingers)
        self._results = self.DeclareAbstractInputPort("contact_results", Value(ContactResults()))
        producer = ValueProducer(allocate=lambda: AbstractValue.Make(object()), calc=self._collect)
        self._touches = self.DeclareCacheEntry("touches", producer, {self._results.ticket()})
        ticket = {self.cache_entry_ticket(self._touches.cache_index())}
        for i, name in enumerate(self._fingers):
            self.DeclareVectorOutputPort(f"{name}.normal_force", 1, partial(self._calc_force, i), ticket)
            self.DeclareVectorOutputPort(f"{name}.contact_center", 3, partial(self._calc_center, i), ticket)
        self.DeclareVectorOutputPort("width", 1, self._calc_width, ticket)

    def _collect(self, context: Context, value: AbstractValue) -> None:
        found = list(patches(self._results.Eval(context)))
        value.set_value([touch(shapes, found) for shapes in self._fingers.values()])

    def _calc_force(self, finger: int, context: Context, output: BasicVector) -> None:
        output.SetFromVector([self._touches.Eval(context)[finger].force])

    def _calc_center(self, finger: int, context: Context, output: BasicVector) -> None:
        output.SetFromVector(self._touches.Eval(context)[finger].center)

    def _calc_width(self, context: Context, output: BasicVector) -> None:
        first, second = self._touches.Eval(context)
        output.SetFromVector([abs((second.center - first.center) @ first.normal)])
