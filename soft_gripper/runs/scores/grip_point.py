"""Grip points of a finger on an object, and the object's shift along the finger from there."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from pydrake.math import RigidTransform
from pydrake.multibody.tree import RigidBody
from pydrake.systems.framework import Context

from soft_gripper.arrays import Array
from soft_gripper.fingers.plant_finger import PlantFinger


class Grip(NamedTuple):
    """A point on a finger's link and a point on the object that coincide when the grip begins."""

    link: RigidBody
    on_link: Array  # (3,) m, in the frame of the link
    on_object: Array  # (3,) m, in the frame of the object


def face_shifts(X: Array, p: Array, on_link: Array) -> Array:
    """Shifts of a point of the object from a point of a link, along the link's inner face, (..., 2) m.

    Args:
        X: the pose of the link in any frame, (..., 3, 4).
        p: the point of the object in it, (..., 3) m.
        on_link: the point of the link, in its own frame, (3,) m.
    """
    return np.asarray((seen_from(X, p) - on_link)[..., 1:])


def seen_from(X: Array, p: Array) -> Array:
    """Points seen from a frame whose pose is X, (..., 3, 4) [R | p] and (..., 3) m -> (..., 3) m."""
    return np.asarray(((p - X[..., 3])[..., None, :] @ X[..., :3])[..., 0, :])


def grip_at(context: Context, finger: PlantFinger, X_WO: RigidTransform, p_WC: Array) -> Grip:
    """The grip of a finger on an object at a point in the world, on the link with the nearest centre."""
    X_WL = np.array([link.EvalPoseInWorld(context).GetAsMatrix34() for link in finger.links])
    link_index, on_link = nearest_link(finger, X_WL, p_WC)
    return Grip(finger.links[int(link_index)], on_link, X_WO.inverse() @ p_WC)


def nearest_link(finger: PlantFinger, X: Array, p: Array) -> tuple[NDArray[np.int_], Array]:
    """The number of the link whose centre is nearest to a point, (...), and the point in its frame, (..., 3) m.

    `X` are the poses of all links in any frame, (..., L, 3, 4), and `p` the point in it, (..., 3) m.
    """
    points = seen_from(X, p[..., None, :])
    middles = np.diff(finger.finger.link_ends) / 2
    link = np.argmin(np.linalg.norm(points - np.outer(middles, [0.0, 0.0, 1.0]), axis=-1), axis=-1)
    return link, np.take_along_axis(points, link[..., None, None], axis=-2)[..., 0, :]


def shift(context: Context, grip: Grip, X_WO: RigidTransform) -> Array:
    """Shift of the object's point from the link's point, along the link's inner face, (2,) m."""
    return face_shifts(grip.link.EvalPoseInWorld(context).GetAsMatrix34(), X_WO @ grip.on_object, grip.on_link)
