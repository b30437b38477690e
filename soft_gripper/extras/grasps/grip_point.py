"""Grip points of a finger on an object, and the object's shift along the finger from there."""

from typing import NamedTuple

import numpy as np
from pydrake.math import RigidTransform
from pydrake.multibody.tree import RigidBody
from pydrake.systems.framework import Context

from soft_gripper.arrays import Array
from soft_gripper.fingers.plant_finger import PlantFinger
from soft_gripper.runs.scores.recorded_object import face_shifts, nearest_link


class Grip(NamedTuple):
    """A point on a finger's link and a point on the object that coincide when the grip begins."""

    link: RigidBody
    on_link: Array  # (3,) m, in the frame of the link
    on_object: Array  # (3,) m, in the frame of the object


def grip_at(context: Context, finger: PlantFinger, X_WO: RigidTransform, p_WC: Array) -> Grip:
    """The grip of a finger on an object at a point in the world, on the link with the nearest centre."""
    X_WL = np.array([link.EvalPoseInWorld(context).GetAsMatrix34() for link in finger.links])
    link_index, on_link = nearest_link(finger, X_WL, p_WC)
    return Grip(finger.links[int(link_index)], on_link, X_WO.inverse() @ p_WC)


def shift(context: Context, grip: Grip, X_WO: RigidTransform) -> Array:
    """Shift of the object's point from the link's point, along the link's inner face, (2,) m."""
    return face_shifts(grip.link.EvalPoseInWorld(context).GetAsMatrix34(), X_WO @ grip.on_object, grip.on_link)
