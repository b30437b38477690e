"""The uncertainty of an estimated curve as a translucent ribbon in Meshcat, on both sides of the finger.

A piece for every link: as wide as two standard deviations on either side, in the mean over its ends. The base of the
finger is where it is known to be.
"""

import numpy as np
from pydrake.geometry import Box, Meshcat, Rgba

from soft_gripper.arrays import Array
from soft_gripper.diagrams.view.drawn_finger import PROUD, DrawnFinger
from soft_gripper.diagrams.view.estimate_shapes import point_at
from soft_gripper.diagrams.view.planar_pose import put, rounded
from soft_gripper.shape.arcs import Arcs

BAND = "/drake/estimate/band"
STDS = 2  # standard deviations, on either side
COLOR = Rgba(0.0, 0.6, 0.6, 0.45)
_LEAST = 1e-6  # m; Meshcat has no shape without width


def place_ribbon(meshcat: Meshcat, drawn: DrawnFinger) -> None:
    """Makes the pieces, 1 m wide."""
    inside, outside = drawn.sides
    thickness = outside - inside - PROUD / 2  # less proud than the curve, which lies over it
    for i, length in enumerate(np.diff(drawn.finger.link_ends)):
        for side, sign in (("left", 1), ("right", -1)):
            path = f"{_path(drawn, i)}/{side}"
            meshcat.SetObject(path, Box(1.0, thickness, 1.03 * length), COLOR)
            meshcat.SetProperty(path, "position", [0.0, sign * (inside + thickness / 2), 0.0])


def draw_ribbon(meshcat: Meshcat, drawn: DrawnFinger, arcs: Arcs, std: Array, time: float) -> None:
    """Poses and scales the pieces by the standard deviations of joints and tip, (N + 1) m; hides what is not known."""
    ends, widths = drawn.finger.link_ends, 2 * STDS * _in_links(std)
    for i, (s, width) in enumerate(zip((ends[:-1] + ends[1:]) / 2, widths, strict=True)):
        path, (point, heading) = _path(drawn, i), point_at(arcs, s)
        visible = bool(np.isfinite([point.real, heading, width]).all())
        meshcat.SetProperty(path, "visible", visible, time)
        if visible:
            put(meshcat, path, point, heading, time)
            meshcat.SetProperty(path, "scale", [max(rounded(width), _LEAST), 1.0, 1.0], time)


def _in_links(std: Array) -> Array:
    """In the middles of the links, (N + 1)."""
    ends = np.concatenate([[0.0], std])
    return (ends[:-1] + ends[1:]) / 2


def _path(drawn: DrawnFinger, link: int) -> str:
    return f"{BAND}/{drawn.name}/{link}"
