"""Patches: where two shapes of a plant touch, and with what force."""

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np
from pydrake.geometry import ContactSurface, GeometryId
from pydrake.multibody.plant import ContactResults

from soft_gripper.arrays import Array


class Patch(NamedTuple):
    """Where two shapes touch."""

    shapes: tuple[GeometryId, GeometryId]
    center: Array  # (3,) m, of the pressure, in the world
    normal: Array  # (3,) unit vector in the world, either way
    force: Array  # (3,) N in the world, friction included, that the first shape receives; the second its opposite


def patches(results: ContactResults) -> Iterator[Patch]:
    """All contacts of a plant. The pressure of a surface acts along its mean normal, in the centre of pressure."""
    for i in range(results.num_hydroelastic_contacts()):
        info = results.hydroelastic_contact_info(i)
        surface, wrench = info.contact_surface(), info.F_Ac_W()
        normal, force = _mean_normal(surface), wrench.translational()
        pressed = float(force @ normal)
        lever = np.cross(normal, wrench.rotational()) / pressed if pressed else np.zeros(3)
        yield Patch((surface.id_M(), surface.id_N()), surface.centroid() + lever, normal, force)
    for i in range(results.num_point_pair_contacts()):
        point = results.point_pair_contact_info(i)
        pair = point.point_pair()
        yield Patch((pair.id_B, pair.id_A), point.contact_point(), pair.nhat_BA_W, point.contact_force())


def _mean_normal(surface: ContactSurface) -> Array:
    total = sum(surface.area(i) * surface.face_normal(i) for i in range(surface.num_faces()))
    return total / np.linalg.norm(total)
