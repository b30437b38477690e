"""A finger in its bending plane, drawn in mm: its rigid segments, its estimated arcs, its base."""

from itertools import pairwise
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.patches import BoxStyle, FancyBboxPatch, Polygon, Rectangle
from matplotlib.transforms import Affine2D

from soft_gripper.arrays import Array, Planar
from soft_gripper.fingers.finger import Finger
from soft_gripper.fingers.kinematics import Chain, as_points
from soft_gripper.sensors.sensor_layout import SensorLayout
from soft_gripper.shape.arcs import Arcs, points_on_arcs

SECTION_COLORS = ("#33608c", "#d1663b", "#3d8f5f", "#a9489c")
_STRAIGHT = 10.0  # m; an arc of a larger radius is called straight
_TEXT_DISTANCE = 9e-3  # m, from the side of the finger to where its radius is written
_EDGE = "0.35"


def in_mm(planar: Planar) -> Array:
    """(x, z) in mm, (..., 2), of points in m."""
    return 1e3 * as_points(planar)


def draw_base(axes: Axes, finger: Finger) -> None:
    """What the finger is mounted on, as a dark block."""
    width, depth = 1.8e3 * finger.base.thickness, 0.6e3 * finger.base.thickness
    middle = -1e3 * float(finger.base.neutral_axis)
    axes.add_patch(Rectangle((middle - width / 2, -depth), width, depth, color="#474f5c"))


def draw_segments(axes: Axes, finger: Finger, chain: Chain, colors: Array) -> None:
    """The segments as rounded rectangles of `colors`, (N, 3)."""
    section, length = finger.section(finger.joint_arc_lengths), 1e3 * finger.segment_length
    faces = 1e3 * np.array([section.outer_face, section.inner_face]).T
    style = BoxStyle.Round(pad=0, rounding_size=0.2 * length)
    for (begin, end), (outer, inner), rgb in zip(pairwise(chain.segment_ends), faces, colors, strict=True):
        corner, width = (outer, -length / 2), inner - outer
        segment = FancyBboxPatch(corner, width, length, boxstyle=style, facecolor=rgb, edgecolor=_EDGE, lw=0.6)
        place = Affine2D().rotate(-np.angle(end - begin)).translate(*in_mm(np.array((begin + end) / 2)))
        segment.set_transform(place + axes.transData)
        axes.add_patch(segment)


def draw_tube(axes: Axes, layout: SensorLayout, arcs: Arcs, colors: Array) -> None:
    """The finger as the arcs bend it: a piece of `colors`, (N, 3), for every segment, a line round every section."""
    in_section = np.arange(layout.finger.segments) - layout.section_ends[layout.joint_sections]
    for section, i, rgb in zip(layout.joint_sections, in_section, colors, strict=True):
        ends = np.array([i, i + 1]) / layout.joints_per_section[section]
        piece = _outline(layout, arcs, section, *ends)
        axes.add_patch(Polygon(piece, facecolor=rgb, edgecolor=rgb, lw=0.6))
    for section in range(layout.sections):
        axes.add_patch(Polygon(_outline(layout, arcs, section), fill=False, edgecolor=_EDGE, lw=0.8))


def _outline(layout: SensorLayout, arcs: Arcs, section: int, begin: float = 0.0, end: float = 1.0) -> Array:
    """Round the finger from `begin` to `end`, fractions of an arc, (M, 2) mm."""
    fraction = np.linspace(begin, end, 17)
    s = layout.section_ends[section] * layout.finger.segment_length + fraction * layout.rest_lengths[section]
    normal = 1j * np.exp(1j * (arcs.heading[section] + fraction * arcs.theta[section]))
    built = layout.finger.section(s)
    axis = points_on_arcs(arcs, np.full(len(fraction), section), fraction)
    return in_mm(np.concatenate([axis + built.inner_face * normal, (axis + built.outer_face * normal)[::-1]]))


def draw_arcs(axes: Axes, layout: SensorLayout, arcs: Arcs) -> None:
    """The arcs with their centres, and with the radii to both of their ends, in mm."""
    for section, (start, center, end) in enumerate(zip(arcs.start, arcs.centers, arcs.end, strict=True)):
        look: dict[str, Any] = {"color": SECTION_COLORS[section % len(SECTION_COLORS)]}
        fraction = np.linspace(0, 1, 31)
        curve = points_on_arcs(arcs, np.full(len(fraction), section), fraction)
        axes.plot(*in_mm(curve).T, lw=2.4, solid_capstyle="butt", **look)
        axes.plot(*in_mm(np.array([start, center, end])).T, lw=0.7, ls=(0, (4, 2)), **look)
        axes.plot(*in_mm(np.array([center])).T, "+", ms=7, **look)
        _write_radius(axes, layout, arcs, section, **look)


def _write_radius(axes: Axes, layout: SensorLayout, arcs: Arcs, section: int, **look: Any) -> None:
    """The radius of an arc, mm, beside its middle on the outer side of the bend."""
    (middle,) = points_on_arcs(arcs, np.array([section]), np.array([0.5]))
    theta, radius = arcs.theta[section], abs(arcs.start[section] - arcs.centers[section])
    normal = 1j * np.exp(1j * (arcs.heading[section] + theta / 2))
    base = layout.finger.base
    face = base.outer_face - _TEXT_DISTANCE if theta > 0 else base.inner_face + _TEXT_DISTANCE
    x, z = in_mm(middle + face * normal)
    text = f"{1e3 * radius:.0f}" if radius < _STRAIGHT else "straight"
    axes.text(x, z, text, ha="center", va="center", fontsize="small", **look)
