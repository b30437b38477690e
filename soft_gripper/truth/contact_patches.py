"""Patches: where two shapes of a plant touch, and with what force."""

from collections.abc import Container, Iterator
from typing import NamedTuple

import numpy as np
from pydrake.geometry import ContactSurface
from pydrake.multibody.plant import ContactResults

from soft_gripper.arrays import Array


class Patch(NamedTuple):
    """Where two shapes touch.

    Shapes are known by the values of their GeometryIds: a block that kept ids would keep the plant that gave them.
    """

    shapes: tuple[int, int]
    place: Array  # (3,) m, of the patch, in the world
    normal: Array  # (3,) in the world, either way, of any length
    force: Array  # (3,) N in the world, friction included, that the first shape receives; the second its opposite
    torque: Array  # (3,) N m in the world, about the place


def patches(results: ContactResults, shapes: Container[int]) -> Iterator[Patch]:
    """All contacts of some shapes of a plant, given by the values of their ids.

    The normal of a surface is the mean over its faces.
    """
    for i in range(results.num_hydroelastic_contacts()):
        info = results.hydroelastic_contact_info(i)
        surface = info.contact_surface()
        pair = (surface.id_M().get_value(), surface.id_N().get_value())
        if pair[0] in shapes or pair[1] in shapes:
            wrench = info.F_Ac_W()
            yield Patch(pair, surface.centroid(), _area(surface), wrench.translational(), wrench.rotational())
    for i in range(results.num_point_pair_contacts()):
        point = results.point_pair_contact_info(i)
        touching = point.point_pair()
        pair = (touching.id_B.get_value(), touching.id_A.get_value())
        if pair[0] in shapes or pair[1] in shapes:
            yield Patch(pair, point.contact_point(), touching.nhat_BA_W, point.contact_force(), np.zeros(3))


def _area(surface: ContactSurface) -> Array:
    """Sum of the normals of a surface's faces, each as long as the face is large."""
    faces = range(surface.num_faces())
    normals = np.concatenate([*map(surface.face_normal, faces)]).reshape(-1, 3)
    area: Array = np.array([*map(surface.area, faces)]) @ normals
    return area
