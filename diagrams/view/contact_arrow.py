"""The estimated contact force of a finger as an arrow in Meshcat, on both sides of the finger.

It begins at the face on which the force presses, at the estimated place, and points to where the finger is pushed;
beside the finger, because neither the finger nor what it touches can hide it there.
"""

import numpy as np
from pydrake.geometry import Cylinder, Meshcat, MeshcatCone, Rgba
from pydrake.math import RigidTransform, RotationMatrix

from soft_gripper.diagrams.view.drawn_finger import PROUD, DrawnFinger
from soft_gripper.diagrams.view.estimate_shapes import point_at
from soft_gripper.diagrams.view.planar_pose import put, rounded
from soft_gripper.estimators.contact_levers import face_offset
from soft_gripper.shape.arcs import Arcs

CONTACT = "/drake/estimate/contact"
LENGTH = 0.025  # m for a newton, as for the true forces
LEAST = 0.02  # N, that is drawn; as for the true forces
COLOR = Rgba(1.0, 0.72, 0.0)
_RADIUS, _HEAD, _HEAD_RADIUS = 0.9e-3, 5e-3, 2.2e-3  # m


def place_arrow(meshcat: Meshcat, drawn: DrawnFinger) -> None:
    """Makes the arrow, hidden: along z from the origin, with a shaft that is to be scaled from 1 m."""
    path, aside = _path(drawn), drawn.sides[1] + PROUD
    turned = RotationMatrix.MakeXRotation(np.pi)  # a cone of Meshcat has its point at the origin
    for side, y in (("left", aside), ("right", -aside)):
        meshcat.SetObject(f"{path}/shaft/{side}", Cylinder(_RADIUS, 1.0), COLOR)
        meshcat.SetTransform(f"{path}/shaft/{side}", RigidTransform([0.0, y, 0.5]))
        meshcat.SetObject(f"{path}/head/{side}", MeshcatCone(_HEAD, _HEAD_RADIUS, _HEAD_RADIUS), COLOR)
        meshcat.SetTransform(f"{path}/head/{side}", RigidTransform(turned, [0.0, y, _HEAD]))
    meshcat.SetProperty(path, "visible", False)


def draw_arrow(meshcat: Meshcat, drawn: DrawnFinger, arcs: Arcs, force: float, arc_length: float, time: float) -> None:
    """Poses the arrow of a force, N, that presses at an arc length, m; hides it where either is not known."""
    path, (point, heading) = _path(drawn), point_at(arcs, arc_length)
    visible = bool(abs(force) >= LEAST and np.isfinite([arc_length, heading, point.real]).all())  # not if it is NaN
    meshcat.SetProperty(path, "visible", visible, time)
    if visible:
        side, length = np.sign(force), max(LENGTH * abs(force) - _HEAD, 0.0)
        face = point + 1j * np.exp(1j * heading) * float(
            face_offset(drawn.finger, np.array(arc_length), np.array(side))
        )
        put(meshcat, path, face, heading - side * np.pi / 2, time)
        meshcat.SetProperty(f"{path}/shaft", "scale", [1.0, 1.0, rounded(length)], time)
        meshcat.SetProperty(f"{path}/head", "position", [0.0, 0.0, rounded(length)], time)


def _path(drawn: DrawnFinger) -> str:
    return f"{CONTACT}/{drawn.name}/arrow"
