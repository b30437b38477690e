"""Moulds for casting a finger: a check of its walls, a core for each chamber, and a shell.

Core and shell are meshes in mm that can be printed. Both stand on the base of the finger, in the frame of the middle of
its section: x toward the inner side, z along the finger. They are lofts through rings, rectangles at a height, rows
(K, 5) mm: z, x and y of the middle, thickness along x, width along y. The chamber of the model runs to the tip; the
core ends one wall before it, so that the tip is closed.
"""

from collections.abc import Sequence
from itertools import combinations, groupby, pairwise
from math import inf

import numpy as np
import trimesh

from soft_gripper.arrays import Array
from soft_gripper.fingers.cross_section import CrossSection
from soft_gripper.fingers.finger import Finger

SHELL = 3.0  # mm, thickness of the mould
GROWTH = np.array([0.0, 0.0, 0.0, 2.0, 2.0])  # mm, of a ring that is widened by 1 mm on every side
_MIDDLE = np.array([1.0, 1.0, 1.0, 0.0, 0.0])  # factors that shrink a ring to a point
_SIGNS = np.array([[1, 1], [-1, 1], [-1, -1], [1, -1]])  # of the corners, counterclockwise as seen from the tip
_MM_PER_M = 1e3


def least_wall(finger: Finger) -> float:
    """Thickness of the thinnest wall of silicone around or between chambers, m; infinite without a chamber.

    Taken at the given cross-sections and the stations of the chambers; between them everything changes linearly.
    """
    if not finger.chambers:
        return min(map(_thinnest_wall, finger.cross_sections))
    stations = {*finger.places, *(place for chamber in finger.chambers for place in chamber.at)}
    return min(_thinnest_wall(finger.section(place * finger.length)) for place in stations)


def _thinnest_wall(section: CrossSection) -> float:
    """Thinnest wall of one cross-section, m."""
    width, thickness, layer = (float(length) for length in (section.width, section.thickness, section.layer_thickness))
    rectangles = [np.array(hole, dtype=float) for hole in section.holes if float(hole.area) > 0]
    walls = list[float]()
    for w, t, x, y in rectangles:
        walls += [(width - w) / 2 - abs(y), (thickness - t) / 2 + x, (thickness - t) / 2 - x - layer]
    for first, second in combinations(rectangles, 2):
        sizes = (first[:2] + second[:2]) / 2
        walls.append(np.max(np.abs(first[2:] - second[2:]) - sizes[::-1]))
    return float(min(walls, default=inf))


def outer_rings(finger: Finger) -> Array:
    """Rings of the outer surface of a finger, one for each given cross-section."""
    sections = zip(finger.places, finger.cross_sections, strict=True)
    return _to_rings([(place * finger.length, 0.0, 0.0, s.thickness, s.width) for place, s in sections])


def _to_rings(rows: Sequence[Sequence[float]] | Array) -> Array:
    """Converts rows in m to rings, and drops repeated ones, as at a step of another quantity."""
    rings = _MM_PER_M * np.array(rows, dtype=float)
    return rings[np.append(True, np.diff(rings, axis=0).any(axis=1))]


def cores(finger: Finger) -> list[trimesh.Trimesh]:
    """The core of every chamber, from base to end; a chamber through the tip ends a wall before it.

    The chamber of the sections is in the pieces that solid sections leave.
    """
    length = finger.length
    pieces = list[Array]()
    for chamber in finger.chambers:
        stations = np.array(chamber.at) * length
        profiles = (chamber.value_at(name, stations, length) for name in ("x", "y", "thickness", "width"))
        pieces.append(_to_rings(np.column_stack([stations, *profiles])))
    sections = zip(finger.places, finger.cross_sections, strict=True)
    for is_hollow, piece in groupby(sections, lambda section: section[1].chamber_area > 0):
        if is_hollow and not finger.chambers:
            rows = [(place * length, s.chamber_center, 0.0, s.chamber_thickness, s.chamber_width) for place, s in piece]
            pieces.append(_to_rings(rows))
    return [loft(_cut_top(rings, _MM_PER_M * (length - least_wall(finger)))) for rings in pieces]


def _cut_top(rings: Array, height: float) -> Array:
    """Cuts rings off at a height, mm, and ends them with a ring there."""
    count = np.count_nonzero(rings[:, 0] < height)
    if count == len(rings):
        return rings
    lower, upper = rings[count - 1 : count + 1]
    fraction = (height - lower[0]) / (upper[0] - lower[0])
    return np.vstack([rings[:count], lower + fraction * (upper - lower)])


def loft(rings: Array) -> trimesh.Trimesh:
    """A closed solid through rings of increasing height."""
    return _mesh(np.vstack([_MIDDLE * rings[0], rings, _MIDDLE * rings[-1]]))


def shell(finger: Finger) -> trimesh.Trimesh:
    """A mould around a finger, open at its base, with walls and a floor of SHELL beyond its tip."""
    inner_rings = outer_rings(finger)
    shell_rings = inner_rings + SHELL * GROWTH
    floor = shell_rings[-1] + [SHELL, 0.0, 0.0, 0.0, 0.0]
    # Up along the outside, through the middle of the floor, and down along the inside to where it began.
    middles = [_MIDDLE * floor, _MIDDLE * inner_rings[-1]]
    return _mesh(np.vstack([shell_rings, floor, *middles, inner_rings[::-1], shell_rings[0]]))


def _mesh(rings: Array) -> trimesh.Trimesh:
    """Joins each ring to the next by quadrilaterals, without double points and degenerate faces."""
    faces = [
        face
        for lower, upper in pairwise(range(0, 4 * len(rings), 4))
        for k, next_k in pairwise((0, 1, 2, 3, 0))
        for face in ((lower + k, lower + next_k, upper + next_k), (lower + k, upper + next_k, upper + k))
    ]
    corners = rings[:, None, 1:3] + _SIGNS * rings[:, None, 3:] / 2
    heights = np.repeat(rings[:, None, :1], 4, axis=1)
    mesh = trimesh.Trimesh(np.concatenate([corners, heights], axis=-1).reshape(-1, 3), faces)
    mesh.update_faces([len(set(face)) == 3 for face in mesh.faces.tolist()])
    return mesh
