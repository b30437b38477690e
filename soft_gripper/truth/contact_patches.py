"""Patches: where two shapes of a plant touch, and with what force."""

from collections.abc import Iterator, Set
from typing import NamedTuple

import numpy as np
from pydrake.geometry import ContactSurface, GeometryId
from pydrake.math import VectorToSkewSymmetric
from pydrake.multibody.plant import ContactResults

from soft_gripper.arrays import Array


class Patch(NamedTuple):
    """Where two shapes touch."""

    shapes: tuple[GeometryId, GeometryId]
    center: Array  # (3,) m, of the pressure, in the world
    normal: Array  # (3,) unit vector in the world, either way
    force: Array  # (3,) N in the world, friction included, that the first shape receives; the second its opposite


def patches(results: ContactResults, shapes: Set[GeometryId]) -> Iterator[Patch]:
    """All contacts of some shapes of a plant. A surface's pressure acts along its mean normal, in its centre."""
    for i in range(results.num_hydroelastic_contacts()):
        info = results.hydroelastic_contact_info(i)
        surface, wrench = info.contact_surface(), info.F_Ac_W()
        pair = (surface.id_M(), surface.id_N())
        if shapes.isdisjoint(pair):
            continue
        normal, force = _mean_normal(surface), wrench.translational()
        pressed = float(force @ normal)
        lever = VectorToSkewSymmetric(normal) @ wrench.rotational() / pressed if pressed else np.zeros(3)
        yield Patch(pair, surface.centroid() + lever, normal, force)
    for i in range(results.num_point_pair_contacts()):
        point = results.point_pair_contact_info(i)
        pair, normal = (point.point_pair().id_B, point.point_pair().id_A), point.point_pair().nhat_BA_W
        if not shapes.isdisjoint(pair):
            yield Patch(pair, point.contact_point(), normal, point.contact_force())


def _mean_normal(surface: ContactSurface) -> Array:
    faces = range(surface.num_faces())
    total = np.array([surface.area(i) for i in faces]) @ np.array([surface.face_normal(i) for i in faces])
    return total / np.linalg.norm(total)
