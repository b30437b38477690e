"""Where a finger may be pressed: cells of its surface, how likely each is, and the wrench of a force in each.

Cells are places along the finger, faces and edges around it, each smooth or rough, and the rim and the end of the tip:
a flat face that a bent finger meets pushes on the rim along its own normal. A finger that only bends is pressed on its
inner and outer face, in cells of different friction along it, and on the edge of its tip.

Contacts are smooth, with a probability of 0.3, or rough: the standard deviation of the friction in each direction is
then the coefficient at the limit of the cone. So a force without friction is found as closely as the readings allow,
and one at the limit is not excluded.

Leading axes are free; C cells, T tangents: two, or the one in its plane of a finger that only bends.
"""

import math
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from soft_gripper.arrays import Array
from soft_gripper.fingers.finger import Finger
from soft_gripper.fingers.spatial_chain import vector_product

_FEWEST_PLACES = 48  # cells along the finger; joints are at their ends, for the torques change there
SMOOTH_FRICTION, _IS_SMOOTH = 0.01, 0.3  # friction per force of a smooth contact, and the probability of one
_CELLS_AROUND = 8  # faces, and the edges between them
_EDGE_PROBABILITY = 0.04  # of each edge
_EDGE_NORMAL_STD = np.radians(45) / math.sqrt(3)  # of the direction of an edge's normal
_ON_TIP = 0.6  # probability of rim and end of the tip, relative to that of a place
_STRADDLED = 1.5e-3  # m, standard deviation of the lever at the joint next to a contact, which may lie on both links
_Z = np.array([0.0, 0.0, 1.0])
_SLIDING = 0.25  # probability of friction at either end of the cone, in the plane; sliding contacts are there
_RUBS = 5  # cells of friction in the plane
_RIM_RUBS = 0.6 + 0.3 * np.arange(4)  # friction per force on the edge of the tip, toward the tip or the base


class _Tangent(NamedTuple):
    """A direction along the surface."""

    along: Array  # (3)
    extent: float  # m, of the part in this direction
    friction: float  # in this direction, as a share of the force, standard deviation
    rub: float = 0.0  # its mean


class _Surface(NamedTuple):
    """A part of the surface that may be pressed; vectors in the frame of its link, (3)."""

    point: Array  # m
    normal: Array  # outward
    tangents: tuple[_Tangent, ...]  # T of them
    straddled: float = 0.0  # m, see `_STRADDLED`
    is_rough: bool = True  # friction may be large


def _wrenches(surfaces: Sequence[_Surface]) -> Array:
    """Wrenches of a force of 1 N on each, and their changes, (C, 1 + 2 T, 6): by friction and by the place."""
    point, normal = (np.array(each)[:, None] for each in zip(*(each[:2] for each in surfaces), strict=True))
    tangents = [zip(*each.tangents, strict=True) for each in surfaces]
    along, extent, friction, rub = (np.array(each) for each in zip(*tangents, strict=True))
    pushing = (rub[..., None] * along).sum(axis=-2, keepdims=True) - normal
    forces = np.concatenate([pushing, friction[..., None] * along], axis=-2)
    wrenches = np.concatenate([vector_product(point, forces), forces], axis=-1)
    moved = vector_product(extent[..., None] / math.sqrt(12) * along, -normal)
    return np.concatenate([wrenches, np.concatenate([moved, np.zeros_like(moved)], axis=-1)], axis=-2)


@dataclass(frozen=True, eq=False)
class SurfaceCells:
    """Where a finger may be pressed: C cells, ordered by sides around the finger and places along it."""

    place: NDArray[np.int_]  # (C)
    side: NDArray[np.int_]  # (C) rising: from 1, the inner one, toward +y; -1 and 1 if the finger only bends
    prior: Array  # (C)
    arc_length: Array  # (C) m
    link: NDArray[np.int_]  # (C)
    nearest: NDArray[np.int_]  # (C) joint next to it
    wrenches: Array  # (C, 1 + 2 T, 6) in the frame of the link
    straddled: Array  # (C, 3) N m, moment at the joint next to it
    directions: Array  # (C, 1 + T, 3) of a force of 1 N, and what friction adds to it
    extent: Array  # (C) m, standard deviation of the place along the finger
    angle: Array  # (C) rad around the finger, from the inner side toward +y
    rough: NDArray[np.bool_]  # (C) whether friction may be large
    on_face: NDArray[np.bool_]  # (C) not on an edge

    @cached_property
    def pairs(self) -> tuple[NDArray[np.int_], NDArray[np.int_], NDArray[np.int_]]:
        """Links and the joints next to them, of all cells, (X) each, and the number of the pair of each cell, (C)."""
        pairs, number = np.unique(np.stack([self.link, self.nearest], axis=-1), axis=0, return_inverse=True)
        return pairs[:, 0], pairs[:, 1], number.ravel()

    @property
    def tangents(self) -> int:
        """T."""
        return self.directions.shape[-2] - 1

    @classmethod
    def of(cls, finger: Finger, ways: Sequence[str], friction: float) -> "SurfaceCells":
        """Cells of a finger that yields in some ways, whose contacts have friction of coefficients up to `friction`."""
        place, side, face, share, s, surfaces = (
            list(each) for each in zip(*_cells(finger, ways, friction), strict=True)
        )
        wrenches, tangents = _wrenches(surfaces), len(surfaces[0].tangents)
        middles = (np.array(place) + 0.5) / (max(place) + 1) * finger.length
        along = [each.tangents[0].extent * each.tangents[0].along[2] for each in surfaces]
        return cls(
            place=np.array(place),
            side=np.array(side),
            prior=np.array(share) / np.sum(share),
            arc_length=np.array(s),
            link=np.searchsorted(finger.joint_arc_lengths, s),
            nearest=np.abs(middles[:, None] - finger.joint_arc_lengths).argmin(axis=-1),
            wrenches=wrenches,
            straddled=np.array([vector_product(each.straddled * _Z, -each.normal) for each in surfaces]),
            directions=wrenches[:, : 1 + tangents, 3:],
            extent=np.array(along) / math.sqrt(12),
            angle=np.angle(np.exp(2j * math.pi * np.array(face) / _CELLS_AROUND)),
            rough=np.array([each.is_rough for each in surfaces]),
            on_face=np.array(face) % 2 == 0,
        )


class _Cell(NamedTuple):
    """A surface that may be pressed, and where it is."""

    place: int
    side: int
    face: int  # or edge, of _CELLS_AROUND
    share: float  # of the probability
    arc_length: float  # m
    surface: _Surface


def _cells(finger: Finger, ways: Sequence[str], friction: float) -> Iterator[_Cell]:
    """All cells, by sides and places; a finger that only bends has the outer face, side -1, and the inner one, 1."""
    count = finger.segments * 2 * math.ceil(_FEWEST_PLACES / (2 * finger.segments))
    s, begins = (np.arange(count) + 0.5) / count * finger.length, np.append(0.0, finger.joint_arc_lengths)
    section, extent = finger.section(s), finger.length / count
    sizes = (np.broadcast_to(each, s.shape) for each in (section.outer_face, section.inner_face, section.width))
    outlines = [_Outline(*size) for size in zip(*sizes, strict=True)]
    heights, end = s - begins[np.searchsorted(begins, s) - 1], finger.length - begins[-1]
    sides: Iterable[tuple[int, int]]
    if tuple(ways) == ("bending",):
        sides, beside, tip = ((-1, _CELLS_AROUND // 2), (1, 0)), _beside_in_plane, _tip_in_plane
    else:
        sides, beside, tip = enumerate(range(_CELLS_AROUND), start=1), _beside, _tip
    for side, face in sides:
        for i, outline in enumerate(outlines):
            for share, surface in beside(face, outline, heights[i], extent, friction):
                yield _Cell(i, side, face, share, s[i], surface)
        for share, surface in tip(face, outlines[-1], end, friction):
            yield _Cell(count - 1, side, face, share, finger.length, surface)


class _Outline(NamedTuple):
    """Outline of a section."""

    outer: float  # m, along x
    inner: float  # m
    width: float  # m

    def toward(self, side: int) -> tuple[Array, Array, float, float]:
        """Middle of a face or edge, the outward normal, the depth behind it, and its extent across, m."""
        normal, across = _normal(side)
        half = np.array([(self.inner - self.outer) / 2, self.width / 2, 0.0])
        middle = np.array([(self.inner + self.outer) / 2, 0.0, 0.0])
        point = middle + np.round(normal * math.sqrt(2)).clip(-1, 1) * half
        return point, normal, float(np.abs(normal) @ half), 2 * float(np.abs(across) @ half)


def _normal(side: int) -> tuple[Array, Array]:
    """The outward normal of a face or edge, and the direction across it, (3) each."""
    angle = 2 * math.pi * side / _CELLS_AROUND
    return np.array([math.cos(angle), math.sin(angle), 0.0]), np.array([-math.sin(angle), math.cos(angle), 0.0])


_Surfaces = Iterator[tuple[float, _Surface]]  # each with its share of the probability


def _beside(face: int, outline: _Outline, height: float, extent: float, friction: float) -> _Surfaces:
    """A face, or the edge between two, at a height above the origin of its link, smooth and rough."""
    (point, normal, _, reach), across, on_edge = outline.toward(face), _normal(face)[1], face % 2 == 1
    share = _EDGE_PROBABILITY if on_edge else (1 - _EDGE_PROBABILITY * _CELLS_AROUND / 2) / (_CELLS_AROUND / 2)
    for is_rough, rubs, likely in ((False, SMOOTH_FRICTION, _IS_SMOOTH), (True, friction, 1 - _IS_SMOOTH)):
        turned = _Tangent(across, 0.0, math.hypot(rubs, _EDGE_NORMAL_STD))
        tangents = _Tangent(_Z, extent, rubs), turned if on_edge else _Tangent(across, reach, rubs)
        yield likely * share, _Surface(point + height * _Z, normal, tangents, is_rough=is_rough)


def _tip(face: int, outline: _Outline, height: float, friction: float) -> _Surfaces:
    """The rim of a face at the tip, and the part of its end beside that face."""
    if face % 2 == 1:
        return
    point, normal, depth, reach = outline.toward(face)
    rim, up = (normal + _Z) / math.sqrt(2), (_Z - normal) / math.sqrt(2)
    across = _Tangent(_normal(face)[1], reach, friction)
    turned = _Tangent(up, 0.0, math.hypot(friction, _EDGE_NORMAL_STD))
    yield _ON_TIP / _CELLS_AROUND, _Surface(point + height * _Z, rim, (across, turned))
    middle = point - depth / 2 * normal + height * _Z
    yield _ON_TIP / _CELLS_AROUND, _Surface(middle, _Z, (across, _Tangent(normal, depth, friction)))


def _beside_in_plane(face: int, outline: _Outline, height: float, extent: float, friction: float) -> _Surfaces:
    """A face at a height above the origin of its link: smooth on one link, and of any friction along it."""
    point, normal = outline.toward(face)[0] + height * _Z, outline.toward(face)[1]
    yield _IS_SMOOTH, _Surface(point, normal, (_Tangent(_Z, extent, SMOOTH_FRICTION),), is_rough=False)
    rubs = friction * np.linspace(-1, 1, _RUBS)
    std = (rubs[1] - rubs[0]) / math.sqrt(12)
    for i, rub in enumerate(rubs):
        share = _SLIDING if i in (0, _RUBS - 1) else (1 - 2 * _SLIDING) / (_RUBS - 2)
        yield (1 - _IS_SMOOTH) * share, _Surface(point, normal, (_Tangent(_Z, extent, std, rub),), _STRADDLED)


def _tip_in_plane(face: int, outline: _Outline, height: float, friction: float) -> _Surfaces:
    """The edge of the tip, which may be pressed in any direction."""
    point, normal = outline.toward(face)[0] + height * _Z, outline.toward(face)[1]
    for rub in np.concatenate([-_RIM_RUBS, _RIM_RUBS]):
        std = (_RIM_RUBS[1] - _RIM_RUBS[0]) / math.sqrt(12)
        yield _ON_TIP / (2 * len(_RIM_RUBS)), _Surface(point, normal, (_Tangent(_Z, 0.0, std, rub),), _STRADDLED)
