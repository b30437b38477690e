"""Cells of a finger's surface that may be pressed: their prior, and the wrench of a force in each.

Each cell is a location along the finger on one of its faces or edges, or on the rim or the end of the tip, and is
smooth or rough. A flat object that a bent finger meets pushes on the rim along the object's normal. A finger that only
bends is pressed on its inner and outer face, in cells of different friction along it, and on the edge of its tip.

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
SMOOTH_FRICTION, _SMOOTH_PROBABILITY = 0.01, 0.3  # friction per force of a smooth contact, and the probability of one
_CELLS_AROUND = 8  # faces, and the edges between them
_EDGE_PROBABILITY = 0.04  # of each edge
_EDGE_NORMAL_STD = np.radians(45) / math.sqrt(3)  # of the direction of an edge's normal
_TIP_PROBABILITY = 0.6  # probability of rim and end of the tip, relative to that of a place
_STRADDLED_LEVER_STD = 1.5e-3  # m, lever at the joint next to a contact that may lie on both links
_Z_AXIS = np.array([0.0, 0.0, 1.0])
_SLIDING_PROBABILITY = 0.25  # of friction at either end of the cone, in the plane, where contacts slide
_FRICTION_CELLS = 5  # cells of friction in the plane
_RIM_FRICTIONS = 0.6 + 0.3 * np.arange(4)  # friction per force on the edge of the tip, toward the tip or the base


class _Tangent(NamedTuple):
    """A direction along the surface."""

    direction: Array  # (3)
    extent: float  # m, of the part in this direction
    friction: float  # in this direction, as a share of the force, standard deviation
    friction_mean: float = 0.0  # its mean


class _Surface(NamedTuple):
    """A part of the surface that may be pressed; vectors in the frame of its link, (3)."""

    point: Array  # m
    normal: Array  # outward
    tangents: tuple[_Tangent, ...]  # T of them
    straddled: float = 0.0  # m, see `_STRADDLED_LEVER_STD`
    is_rough: bool = True  # friction may be large


def _wrenches(surfaces: Sequence[_Surface]) -> Array:
    """Wrenches of 1 N on each surface, and their standard deviations by friction and place, (C, 1 + 2 T, 6) N m, N."""
    point, normal = (np.array([surface[i] for surface in surfaces])[:, None] for i in range(2))
    tangents = [zip(*surface.tangents, strict=True) for surface in surfaces]
    direction, extent, friction, friction_mean = (np.array(column) for column in zip(*tangents, strict=True))
    total_force = (friction_mean[..., None] * direction).sum(axis=-2, keepdims=True) - normal
    forces = np.concatenate([total_force, friction[..., None] * direction], axis=-2)
    wrenches = np.concatenate([vector_product(point, forces), forces], axis=-1)
    place_moments = vector_product(extent[..., None] / math.sqrt(12) * direction, -normal)
    return np.concatenate([wrenches, np.concatenate([place_moments, np.zeros_like(place_moments)], axis=-1)], axis=-2)


@dataclass(frozen=True, eq=False)
class SurfaceCells:
    """C cells of a finger's surface, ordered by sides around the finger and places along it."""

    place: NDArray[np.int_]  # (C)
    side: NDArray[np.int_]  # (C) rising: from 1, the inner one, toward +y; -1 and 1 if the finger only bends
    prior: Array  # (C)
    arc_length: Array  # (C) m
    link: NDArray[np.int_]  # (C)
    nearest_joint: NDArray[np.int_]  # (C) joint next to it
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
        pairs, pair_index = np.unique(np.stack([self.link, self.nearest_joint], axis=-1), axis=0, return_inverse=True)
        return pairs[:, 0], pairs[:, 1], pair_index.ravel()

    @property
    def tangents(self) -> int:
        """Number of tangents, T."""
        return self.directions.shape[-2] - 1

    @classmethod
    def from_finger(cls, finger: Finger, deformations: Sequence[str], friction: float) -> "SurfaceCells":
        """Cells of a finger with some deformations, for contacts with coefficients of friction up to `friction`."""
        columns = map(list, zip(*_cells(finger, deformations, friction), strict=True))
        place, side, face, probability, s, surfaces = columns
        wrenches, tangents = _wrenches(surfaces), len(surfaces[0].tangents)
        middles = (np.array(place) + 0.5) / (max(place) + 1) * finger.length
        extents = [surface.tangents[0].extent * surface.tangents[0].direction[2] for surface in surfaces]
        return cls(
            place=np.array(place),
            side=np.array(side),
            prior=np.array(probability) / np.sum(probability),
            arc_length=np.array(s),
            link=np.searchsorted(finger.joint_arc_lengths, s),
            nearest_joint=np.abs(middles[:, None] - finger.joint_arc_lengths).argmin(axis=-1),
            wrenches=wrenches,
            straddled=np.array([vector_product(surface.straddled * _Z_AXIS, -surface.normal) for surface in surfaces]),
            directions=wrenches[:, : 1 + tangents, 3:],
            extent=np.array(extents) / math.sqrt(12),
            angle=np.angle(np.exp(2j * math.pi * np.array(face) / _CELLS_AROUND)),
            rough=np.array([surface.is_rough for surface in surfaces]),
            on_face=np.array(face) % 2 == 0,
        )


class _Cell(NamedTuple):
    """A surface that may be pressed, and where it is."""

    place: int
    side: int
    face: int  # or edge, of _CELLS_AROUND
    probability: float  # relative
    arc_length: float  # m
    surface: _Surface


def _cells(finger: Finger, deformations: Sequence[str], friction: float) -> Iterator[_Cell]:
    """Yields all cells, by sides and places; if the finger only bends, on the outer face, -1, and the inner one, 1."""
    place_count = finger.segments * 2 * math.ceil(_FEWEST_PLACES / (2 * finger.segments))
    arc_lengths = (np.arange(place_count) + 0.5) / place_count * finger.length
    begins = np.append(0.0, finger.joint_arc_lengths)
    section, extent = finger.section(arc_lengths), finger.length / place_count
    sizes = np.broadcast_arrays(section.outer_face, section.inner_face, section.width, arc_lengths)[:3]
    outlines = [_Outline(*size) for size in zip(*sizes, strict=True)]
    heights, end = arc_lengths - begins[np.searchsorted(begins, arc_lengths) - 1], finger.length - begins[-1]
    sides: Iterable[tuple[int, int]]
    if tuple(deformations) == ("bending",):
        sides = ((-1, _CELLS_AROUND // 2), (1, 0))
        make_faces = _planar_face_surfaces
        make_tips = _planar_tip_surfaces
    else:
        sides = enumerate(range(_CELLS_AROUND), start=1)
        make_faces = _face_surfaces
        make_tips = _tip_surfaces
    for side, face in sides:
        for i, outline in enumerate(outlines):
            for probability, surface in make_faces(face, outline, heights[i], extent, friction):
                yield _Cell(i, side, face, probability, arc_lengths[i], surface)
        for probability, surface in make_tips(face, outlines[-1], end, friction):
            yield _Cell(place_count - 1, side, face, probability, finger.length, surface)


class _Outline(NamedTuple):
    """Outline of a section."""

    outer: float  # m, along x
    inner: float  # m
    width: float  # m

    def patch(self, side: int) -> tuple[Array, Array, float, float]:
        """Middle of a face or edge, (3,) m, its outward normal, (3,), the depth behind it and its extent across, m."""
        normal, cross_direction = _normal(side)
        half_sizes = np.array([(self.inner - self.outer) / 2, self.width / 2, 0.0])
        middle = np.array([(self.inner + self.outer) / 2, 0.0, 0.0])
        point = middle + np.round(normal * math.sqrt(2)).clip(-1, 1) * half_sizes
        return point, normal, float(np.abs(normal) @ half_sizes), 2 * float(np.abs(cross_direction) @ half_sizes)


def _normal(side: int) -> tuple[Array, Array]:
    """The outward normal of a face or edge, and the direction across it, (3) each."""
    angle = 2 * math.pi * side / _CELLS_AROUND
    return np.array([math.cos(angle), math.sin(angle), 0.0]), np.array([-math.sin(angle), math.cos(angle), 0.0])


_Surfaces = Iterator[tuple[float, _Surface]]  # with relative probabilities


def _face_surfaces(face: int, outline: _Outline, height: float, extent: float, friction: float) -> _Surfaces:
    """Yields a face, or the edge between two, at a height above the origin of its link, smooth and rough."""
    (point, normal, _, reach), cross_direction, is_edge = outline.patch(face), _normal(face)[1], face % 2 == 1
    fraction = _EDGE_PROBABILITY if is_edge else (1 - _EDGE_PROBABILITY * _CELLS_AROUND / 2) / (_CELLS_AROUND / 2)
    kinds = (False, SMOOTH_FRICTION, _SMOOTH_PROBABILITY), (True, friction, 1 - _SMOOTH_PROBABILITY)
    for is_rough, friction_std, probability in kinds:
        tilt_tangent = _Tangent(cross_direction, 0.0, math.hypot(friction_std, _EDGE_NORMAL_STD))
        cross_tangent = tilt_tangent if is_edge else _Tangent(cross_direction, reach, friction_std)
        tangents = _Tangent(_Z_AXIS, extent, friction_std), cross_tangent
        yield probability * fraction, _Surface(point + height * _Z_AXIS, normal, tangents, is_rough=is_rough)


def _tip_surfaces(face: int, outline: _Outline, height: float, friction: float) -> _Surfaces:
    """Yields the rim of a face at the tip, and the part of the tip's end beside that face."""
    if face % 2 == 1:
        return
    point, normal, depth, reach = outline.patch(face)
    rim, edge_axis = (normal + _Z_AXIS) / math.sqrt(2), (_Z_AXIS - normal) / math.sqrt(2)
    rim_tangent = _Tangent(_normal(face)[1], reach, friction)
    tilt_tangent = _Tangent(edge_axis, 0.0, math.hypot(friction, _EDGE_NORMAL_STD))
    yield _TIP_PROBABILITY / _CELLS_AROUND, _Surface(point + height * _Z_AXIS, rim, (rim_tangent, tilt_tangent))
    middle = point - depth / 2 * normal + height * _Z_AXIS
    yield _TIP_PROBABILITY / _CELLS_AROUND, _Surface(middle, _Z_AXIS, (rim_tangent, _Tangent(normal, depth, friction)))


def _planar_face_surfaces(face: int, outline: _Outline, height: float, extent: float, friction: float) -> _Surfaces:
    """Yields a face at a height above the origin of its link: smooth on one link, and of any friction along it."""
    point, normal = outline.patch(face)[0] + height * _Z_AXIS, outline.patch(face)[1]
    yield _SMOOTH_PROBABILITY, _Surface(point, normal, (_Tangent(_Z_AXIS, extent, SMOOTH_FRICTION),), is_rough=False)
    frictions = friction * np.linspace(-1, 1, _FRICTION_CELLS)
    std = (frictions[1] - frictions[0]) / math.sqrt(12)
    inner_probability = (1 - 2 * _SLIDING_PROBABILITY) / (_FRICTION_CELLS - 2)
    for i, mean in enumerate(frictions):
        probability = _SLIDING_PROBABILITY if i in (0, _FRICTION_CELLS - 1) else inner_probability
        surface = _Surface(point, normal, (_Tangent(_Z_AXIS, extent, std, mean),), _STRADDLED_LEVER_STD)
        yield (1 - _SMOOTH_PROBABILITY) * probability, surface


def _planar_tip_surfaces(face: int, outline: _Outline, height: float, friction: float) -> _Surfaces:
    """Yields the edge of the tip, which may be pressed in any direction."""
    point, normal = outline.patch(face)[0] + height * _Z_AXIS, outline.patch(face)[1]
    std = (_RIM_FRICTIONS[1] - _RIM_FRICTIONS[0]) / math.sqrt(12)
    for mean in np.concatenate([-_RIM_FRICTIONS, _RIM_FRICTIONS]):
        surface = _Surface(point, normal, (_Tangent(_Z_AXIS, 0.0, std, mean),), _STRADDLED_LEVER_STD)
        yield _TIP_PROBABILITY / (2 * len(_RIM_FRICTIONS)), surface
