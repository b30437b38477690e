"""Demands of a mould on a finger: walls that are thick enough, everywhere."""

from itertools import combinations

from soft_gripper.fingers.cross_section import CrossSection, Hole
from soft_gripper.fingers.finger import Finger

INFINITE = float("inf")


def least_wall(finger: Finger) -> float:
    """Thickness of the thinnest wall of silicone round a chamber, and between two, m; infinite without a chamber.

    At the cross-sections that are given and at the stations of the chambers; between them everything changes linearly.
    """
    if not finger.chambers:
        return min(map(thinnest, finger.cross_sections))
    stations = {*finger.places, *(place for chamber in finger.chambers for place in chamber.at)}
    return min(thinnest(finger.section(place * finger.length)) for place in stations)


def thinnest(section: CrossSection) -> float:
    """Thinnest wall of one cross-section, m."""
    holes = [hole for hole in section.holes if float(hole.area) > 0]
    around = [wall for hole in holes for wall in _around(section, hole)]
    return min([*around, *(_between(one, other) for one, other in combinations(holes, 2))], default=INFINITE)


def _around(section: CrossSection, hole: Hole) -> list[float]:
    """Walls at either side, outer and inner, without the layer."""
    half = float(section.thickness) / 2
    side = float(section.width) / 2 - abs(float(hole.y)) - float(hole.width) / 2
    outer = half + float(hole.x) - float(hole.thickness) / 2
    inner = half - float(section.layer_thickness) - float(hole.x) - float(hole.thickness) / 2
    return [side, outer, inner]


def _between(one: Hole, other: Hole) -> float:
    """The gap between two rectangles, along x or along y."""
    along_x = abs(float(one.x) - float(other.x)) - (float(one.thickness) + float(other.thickness)) / 2
    along_y = abs(float(one.y) - float(other.y)) - (float(one.width) + float(other.width)) / 2
    return max(along_x, along_y)
