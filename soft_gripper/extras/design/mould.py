"""Moulds to cast a finger with: a core for each chamber, and a shell, as meshes in mm that can be printed.

Both stand on the base of the finger, in the frame of the middle of its section: x toward the inner side, z along the
finger. The chamber of the model runs to the tip; the core ends one wall before it, so that the tip is closed.
"""

from collections.abc import Iterable, Iterator, Sequence
from itertools import groupby, pairwise
from typing import NamedTuple

import numpy as np
import trimesh

from soft_gripper.arrays import Array
from soft_gripper.extras.design.walls import INFINITE, least_wall
from soft_gripper.fingers.finger import Finger

SHELL = 3.0  # mm, thickness of the mould
_MM = 1e3


class Ring(NamedTuple):
    """A rectangle at a height, mm."""

    z: float
    x: float  # of its middle
    y: float
    thickness: float  # along x
    width: float  # along y

    @property
    def corners(self) -> Array:
        """Counterclockwise as seen from the tip, (4, 3)."""
        signs = np.array([[1, 1], [-1, 1], [-1, -1], [1, -1]])
        across = np.array([self.x, self.y]) + signs * np.array([self.thickness, self.width]) / 2
        return np.column_stack([across, np.full(4, self.z)])

    def grown(self, by: float) -> "Ring":
        """Wider on every side."""
        return self._replace(thickness=self.thickness + 2 * by, width=self.width + 2 * by)


def outer_rings(finger: Finger) -> list[Ring]:
    """The outside of a finger, at the cross-sections that are given."""
    return _distinct(
        Ring(_MM * place * finger.length, 0.0, 0.0, _MM * float(section.thickness), _MM * float(section.width))
        for place, section in zip(finger.places, finger.cross_sections, strict=True)
    )


def _distinct(rings: Iterable[Ring]) -> list[Ring]:
    """Rings without those that repeat the one before, as at a step of something else."""
    return [ring for ring, _ in groupby(rings)]


def core_rings(finger: Finger) -> list[list[Ring]]:
    """The chambers of a finger, each from its base to its end, a wall before the tip if it runs that far."""
    wall = least_wall(finger)
    if wall == INFINITE:
        return []
    chambers = _listed(finger) if finger.chambers else list(_of_sections(finger))
    return [_closed(_distinct(rings), _MM * (finger.length - wall)) for rings in chambers]


def _of_sections(finger: Finger) -> Iterator[list[Ring]]:
    """The chamber of the sections, in the pieces that these leave."""
    rings: list[Ring] = []
    for place, section in zip(finger.places, finger.cross_sections, strict=True):
        t, w, x = (float(v) for v in (section.chamber_thickness, section.chamber_width, section.chamber_center))
        if t * w > 0:
            rings.append(Ring(_MM * place * finger.length, _MM * x, 0.0, _MM * t, _MM * w))
        elif rings:
            yield rings
            rings = []
    if rings:
        yield rings


def _listed(finger: Finger) -> list[list[Ring]]:
    """The chambers that are given along the finger."""
    found = []
    for chamber in finger.chambers:
        at = [share * finger.length for share in chamber.at]
        numbers = [[float(chamber.along(n, s, finger.length)) for n in ("x", "y", "thickness", "width")] for s in at]
        found.append([Ring(*(_MM * np.array([s, *row])).tolist()) for s, row in zip(at, numbers, strict=True)])
    return found


def _closed(rings: Sequence[Ring], top: float) -> list[Ring]:
    """The rings below a height, and one there if they go beyond it."""
    below = [ring for ring in rings if ring.z < top]
    if len(below) == len(rings):
        return below
    low, high = below[-1], rings[len(below)]
    share = (top - low.z) / (high.z - low.z)
    return [*below, Ring(*(np.array(low) + share * (np.array(high) - np.array(low))).tolist())]


def loft(rings: Sequence[Ring]) -> trimesh.Trimesh:
    """A closed solid through rectangles of increasing height."""
    return _mesh([ring.corners for ring in rings])


def shell(finger: Finger) -> trimesh.Trimesh:
    """A mould around a finger, open at its base, with walls and a floor of SHELL beyond its tip."""
    inside = outer_rings(finger)
    outside = [ring.grown(SHELL) for ring in inside]
    outside.append(outside[-1]._replace(z=outside[-1].z + SHELL))
    # Up along the outside, over the floor, and down along the inside to where it began.
    return _mesh([ring.corners for ring in (*outside, *reversed(inside))], is_ring=True)


def cores(finger: Finger) -> list[trimesh.Trimesh]:
    """The core of every chamber."""
    return [loft(rings) for rings in core_rings(finger)]


def _mesh(rings: Sequence[Array], is_ring: bool = False) -> trimesh.Trimesh:
    """Quadrilaterals between rings of four points.

    The first and the last ring are closed; or, if these form a ring themselves, joined, and the floor is closed.
    """
    faces = [face for i, j in pairwise(range(len(rings))) for face in _sides(i, j)]
    if is_ring:
        floor = next(i for i, (one, other) in enumerate(pairwise(rings)) if one[0, 2] > other[0, 2])
        # Between the top of the outside and that of the inside there is solid, so both are closed instead of joined.
        faces = [face for i, j in pairwise(range(len(rings))) if i != floor for face in _sides(i, j)]
        faces += [*_cap(floor), *(face[::-1] for face in _cap(floor + 1)), *_sides(len(rings) - 1, 0)]
    else:
        faces += [*(face[::-1] for face in _cap(0)), *_cap(len(rings) - 1)]
    return trimesh.Trimesh(np.concatenate(rings), np.array(faces))


def _sides(low: int, high: int) -> Iterator[tuple[int, int, int]]:
    for k in range(4):
        a, b = 4 * low + k, 4 * low + (k + 1) % 4
        c, d = 4 * high + (k + 1) % 4, 4 * high + k
        yield from ((a, b, c), (a, c, d))


def _cap(ring: int) -> list[tuple[int, int, int]]:
    first = 4 * ring
    return [(first, first + 1, first + 2), (first, first + 2, first + 3)]
