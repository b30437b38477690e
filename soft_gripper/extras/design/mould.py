"""Moulds for casting a finger: a check of its walls, a core for each chamber, and a shell.

Core and shell are meshes in mm that can be printed. Both stand on the base of the finger, in the frame of the middle of
its section: x toward the inner side, z along the finger. The chamber of the model runs to the tip; the core ends one
wall before it, so that the tip is closed.
"""

from collections.abc import Iterable, Sequence
from itertools import combinations, groupby, pairwise
from math import inf
from typing import NamedTuple

import numpy as np
import trimesh

from soft_gripper.arrays import Array
from soft_gripper.fingers.cross_section import CrossSection
from soft_gripper.fingers.finger import Finger

SHELL = 3.0  # mm, thickness of the mould
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


class Ring(NamedTuple):
    """A rectangle at a height, mm."""

    z: float
    x: float  # of its middle
    y: float
    thickness: float  # along x
    width: float  # along y

    @property
    def corners(self) -> Array:
        """Corners, counterclockwise as seen from the tip, (4, 3)."""
        signs = np.array([[1, 1], [-1, 1], [-1, -1], [1, -1]])
        half_size = np.array([self.x, self.y]) + signs * np.array([self.thickness, self.width]) / 2
        return np.column_stack([half_size, np.full(4, self.z)])

    @property
    def middle(self) -> "Ring":
        """The ring shrunk to a point."""
        return self._replace(thickness=0.0, width=0.0)

    def grown(self, margin: float) -> "Ring":
        """The ring widened on every side."""
        return self._replace(thickness=self.thickness + 2 * margin, width=self.width + 2 * margin)


def outer_rings(finger: Finger) -> list[Ring]:
    """Rings of the outer surface of a finger, one for each given cross-section."""
    sections = zip(finger.places, finger.cross_sections, strict=True)
    return _to_rings((place * finger.length, 0.0, 0.0, section.thickness, section.width) for place, section in sections)


def _to_rings(numbers: Iterable[Sequence[float]]) -> list[Ring]:
    """Converts rows in m to rings, and drops repeated ones, as at a step of another quantity."""
    return [ring for ring, _ in groupby(Ring(*(_MM_PER_M * float(number) for number in row)) for row in numbers)]


def core_rings(finger: Finger) -> list[list[Ring]]:
    """Rings of the chambers of a finger, from base to end; a chamber through the tip ends a wall before it.

    The chamber of the sections is in the pieces that solid sections leave.
    """
    length = finger.length
    pieces = list[Iterable[Sequence[float]]]()
    for chamber in finger.chambers:
        stations = np.array(chamber.at) * length
        profiles = (chamber.value_at(name, stations, length) for name in ("x", "y", "thickness", "width"))
        pieces.append(np.column_stack([stations, *profiles]))
    sections = zip(finger.places, finger.cross_sections, strict=True)
    for is_hollow, piece in groupby(sections, lambda section: section[1].chamber_area > 0):
        if is_hollow:  # and without other chambers
            pieces.append(
                [(place * length, s.chamber_center, 0.0, s.chamber_thickness, s.chamber_width) for place, s in piece]
            )
    return [_cut_top(_to_rings(piece), _MM_PER_M * (length - least_wall(finger))) for piece in pieces]


def _cut_top(rings: Sequence[Ring], height: float) -> list[Ring]:
    """Cuts rings off at a height, mm, and ends them with a ring there."""
    lower_rings = [ring for ring in rings if ring.z < height]
    if len(lower_rings) == len(rings):
        return lower_rings
    lower_ring, upper = lower_rings[-1], rings[len(lower_rings)]
    fraction = (height - lower_ring.z) / (upper.z - lower_ring.z)
    return [*lower_rings, Ring(*(np.array(lower_ring) + fraction * (np.array(upper) - np.array(lower_ring))).tolist())]


def loft(rings: Sequence[Ring]) -> trimesh.Trimesh:
    """A closed solid through rectangles of increasing height."""
    return _mesh([rings[0].middle, *rings, rings[-1].middle])


def shell(finger: Finger) -> trimesh.Trimesh:
    """A mould around a finger, open at its base, with walls and a floor of SHELL beyond its tip."""
    inner_rings = outer_rings(finger)
    shell_rings = [ring.grown(SHELL) for ring in inner_rings]
    shell_rings.append(shell_rings[-1]._replace(z=shell_rings[-1].z + SHELL))
    # Up along the outside, through the middle of the floor, and down along the inside to where it began.
    return _mesh([*shell_rings, shell_rings[-1].middle, inner_rings[-1].middle, *reversed(inner_rings), shell_rings[0]])


def cores(finger: Finger) -> list[trimesh.Trimesh]:
    """The core of every chamber."""
    return [loft(rings) for rings in core_rings(finger)]


def _mesh(rings: Sequence[Ring]) -> trimesh.Trimesh:
    """Joins each ring to the next by quadrilaterals, without double points and degenerate faces."""
    faces = [
        face
        for lower, upper in pairwise(range(0, 4 * len(rings), 4))
        for k, next_k in pairwise((0, 1, 2, 3, 0))
        for face in ((lower + k, lower + next_k, upper + next_k), (lower + k, upper + next_k, upper + k))
    ]
    mesh = trimesh.Trimesh(np.concatenate([ring.corners for ring in rings]), faces)
    mesh.update_faces([len(set(face)) == 3 for face in mesh.faces.tolist()])
    return mesh
