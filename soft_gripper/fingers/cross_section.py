"""The cross-section of a finger as built, and derived quantities: bending stiffness, neutral axis, chamber law.

Seen along the finger, with the inner side, which touches, to the right:

    outer face                                    inner face
        +---------------------------------------+=+
        |          +----------------+           | |   ^ y
        |          |    chamber     |           | |   |
        |          +----------------+           |=|   +--> x, from the middle of the outer section
        +---------------------------------------+=+
                                       strain-limiting layer

Plane sections stay plane (Euler and Bernoulli), so a composite bends about the centroid of its moduli:

    x_n = sum E_i A_i x_i / sum E_i A_i ,    EI = sum E_i (I_i + A_i (x_i - x_n)^2) ,

summed over the block of silicone, the chamber (which takes silicone away) and the layer (which takes its place). All
are symmetric in y, so bending sideways is about the middle of each, and independent of bending in the plane.

Torsion (Saint-Venant): a twisted section turns, and warps along the finger by w(x, y) per rate of twist. Of all
warpings, the actual one costs the least energy:

    G J = least over w of  integral of  G ((dw/dx - y)^2 + (dw/dy + x)^2) dA .

Bilinear finite elements on a grid whose lines follow all edges, and crowd toward them, where the stress is steep: 0.1 %
too stiff at most. The section is symmetric in y and w antisymmetric, so half of it is solved, with w = 0 at y = 0. The
package sectionproperties, for sections of any shape, would bring four more packages, one of them a compiled mesher.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from functools import cached_property, lru_cache
from itertools import pairwise
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from soft_gripper.arrays import Array
from soft_gripper.quantity import Violation, quantity, valid

SIZES = (1e-9, 1e12)  # range of nonzero parameters of a finger; beyond it, derived quantities would overflow
Quantity = Array | float  # at one or several positions along the finger
_SECTION_ELEMENTS = 48  # about, across the section
_MIN_ELEMENTS_PER_GAP = 4  # between two edges
_EDGE_DIGITS = 9  # decimals of the section's size, by which edges are told apart
# Integrals of products of slopes of two hat functions, on a unit length, and of the hat functions themselves.
_SLOPE_PRODUCTS = np.array([[1.0, -1.0], [-1.0, 1.0]])
_HAT_PRODUCTS = np.array([[2.0, 1.0], [1.0, 2.0]]) / 6
_END_SIGNS = np.array([-1.0, 1.0])


class Hole(NamedTuple):
    """A rectangle without material."""

    width: Quantity  # m, along y
    thickness: Quantity  # m, along x
    x: Quantity  # m, of its middle, from the middle of the outer section
    y: Quantity = 0.0  # m, likewise

    @property
    def area(self) -> Quantity:
        """m^2."""
        return self.width * self.thickness


@dataclass(frozen=True)
class CrossSection:
    """Construction of the finger at one position along its length, or at several if the fields are arrays (SI units).

    Without a chamber the section is solid; without a layer it is silicone alone.
    """

    width: float = field(metadata=valid("m", above=0, sizes=SIZES))  # outer, along the bending axis y
    thickness: float = field(metadata=valid("m", above=0, sizes=SIZES))  # outer, along the inner normal x
    youngs_modulus: float = field(metadata=valid("Pa", above=0, sizes=SIZES))  # of the silicone
    density: float = field(metadata=valid("kg/m^3", above=0, sizes=SIZES))  # of the silicone
    chamber_width: float = quantity(0.0, "m", least=0, sizes=SIZES)  # along y
    chamber_thickness: float = quantity(0.0, "m", least=0, sizes=SIZES)  # along x
    # Along x from the middle of the outer section; negative toward the outer face.
    chamber_center: float = quantity(0.0, "m", sizes=SIZES)
    # Of a strain-limiting layer in the inner face, as wide as the finger.
    layer_thickness: float = quantity(0.0, "m", least=0, sizes=SIZES)
    layer_modulus: float = quantity(0.0, "Pa", least=0, sizes=SIZES)  # Young's modulus of that layer
    # Of that layer, in its plane; 0: isotropic and incompressible, a third of its Young's modulus.
    layer_shear_modulus: float = quantity(0.0, "Pa", least=0, sizes=SIZES)

    @cached_property
    def chamber_area(self) -> Quantity:
        """m^2."""
        return self.chamber_width * self.chamber_thickness

    @cached_property
    def area(self) -> Quantity:
        """Solid area, m^2."""
        return self.width * self.thickness - sum(hole.area for hole in self.holes)

    @property
    def holes(self) -> tuple[Hole, ...]:
        """Hollow parts of the section: its chamber."""
        return (Hole(self.chamber_width, self.chamber_thickness, self.chamber_center),)

    @cached_property
    def _parts(self) -> list[tuple[Quantity, ...]]:
        """Modulus, width, thickness and centre (x, y) of the summed parts: block, holes, layer."""
        layer = (self.layer_modulus - self.youngs_modulus, self.width, self.layer_thickness, self.layer_center, 0.0)
        block = (self.youngs_modulus, self.width, self.thickness, 0.0, 0.0)
        return [block, *((-self.youngs_modulus, *hole) for hole in self.holes), layer]

    @property
    def layer_center(self) -> Quantity:
        """m, along x from the middle of the outer section."""
        return (self.thickness - self.layer_thickness) / 2

    @cached_property
    def neutral_axis(self) -> Quantity:
        """Axis that keeps its length in bending, m along x from the middle of the outer section."""
        return sum(E * w * t * x for E, w, t, x, _ in self._parts) / self.stretch_stiffness

    @cached_property
    def bending_stiffness(self) -> Quantity:
        """E I about the neutral axis, N m^2."""
        return sum(E * w * t * (t**2 / 12 + (x - self.neutral_axis) ** 2) for E, w, t, x, _ in self._parts)

    @cached_property
    def sideways_stiffness(self) -> Quantity:
        """E I about the axis of symmetry, of bending out of the plane, N m^2."""
        return sum(E * w**3 * t / 12 + E * w * t * y**2 for E, w, t, _, y in self._parts)

    @cached_property
    def twist_stiffness(self) -> Quantity:
        """G J, N m^2; silicone is incompressible, G = E / 3."""
        layer_shear_modulus = np.where(self.layer_shear_modulus == 0, self.layer_modulus / 3, self.layer_shear_modulus)
        block = (self.youngs_modulus / 3, self.width, self.thickness)
        layer = (layer_shear_modulus, self.layer_thickness, self.layer_center)
        return _twist_stiffness(*block, *layer, *(number for hole in self.holes for number in hole))

    @cached_property
    def stretch_stiffness(self) -> Quantity:
        """E A, N."""
        return sum(E * w * t for E, w, t, _, _ in self._parts)

    @cached_property
    def chamber_eccentricity(self) -> Quantity:
        """Distance from the chamber's centroid to the neutral axis, m; positive where pressure closes the finger."""
        return self.neutral_axis - self.chamber_center

    @property
    def inner_face(self) -> Quantity:
        """m, along x from the neutral axis."""
        return self.thickness / 2 - self.neutral_axis

    @property
    def outer_face(self) -> Quantity:
        """m, along x from the neutral axis; negative."""
        return -self.thickness / 2 - self.neutral_axis

    @cached_property
    def mass_center(self) -> Quantity:
        """m, along x from the neutral axis. The layer counts as silicone."""
        return -sum(hole.area * hole.x for hole in self.holes) / self.area - self.neutral_axis

    @cached_property
    def gyration(self) -> tuple[Quantity, Quantity]:
        """Squares of the radii of gyration of the mass about its centre, along x and along y, m^2."""
        center = self.mass_center + self.neutral_axis
        block = self.width * self.thickness
        along_x = block * (self.thickness**2 / 12 + center**2)
        along_x = along_x - sum(hole.area * (hole.thickness**2 / 12 + (hole.x - center) ** 2) for hole in self.holes)
        along_y = block * self.width**2 / 12 - sum(h.area * (h.width**2 / 12 + h.y**2) for h in self.holes)
        return along_x / self.area, along_y / self.area

    @property
    def walls(self) -> dict[str, Quantity]:
        """Thickness of the walls round the chamber, m: at each side, outer and inner (of silicone, without layer)."""
        half, middle = self.chamber_thickness / 2, self.chamber_center
        return {
            "side": (self.width - self.chamber_width) / 2,
            "outer": self.thickness / 2 + middle - half,
            "inner": self.thickness / 2 - middle - half - self.layer_thickness,
        }

    def violations(self) -> Iterator[Violation]:
        """Dimensions that cannot be moulded: field, value, and the valid range."""
        if (self.chamber_width == 0) != (self.chamber_thickness == 0):
            yield "chamber_width", self.chamber_width, "a chamber has a width and a thickness, a solid section neither"
        if (self.layer_thickness == 0) != (self.layer_modulus == 0):
            yield "layer_modulus", self.layer_modulus, "a layer has a thickness and a modulus"
        if self.layer_shear_modulus > 0 and self.layer_thickness == 0:
            yield "layer_shear_modulus", self.layer_shear_modulus, "leave it out: there is no layer"
        if self.layer_thickness >= self.thickness:
            yield "layer_thickness", self.layer_thickness, f"give less than the thickness, {self.thickness:g} m"
        if self.chamber_area == 0:
            return
        field = {"side": "chamber_width", "outer": "chamber_center", "inner": "chamber_center"}
        walls = ", ".join(f"{name} {1e3 * wall:.2f} mm" for name, wall in self.walls.items())
        for name, wall in self.walls.items():
            if wall <= 0:
                expected = f"the chamber does not fit; it leaves walls of {walls}"
                yield field[name], getattr(self, field[name]), expected
        if self.chamber_eccentricity <= 0:
            expected = f"pressure would open the finger: give less than the neutral axis, {self.neutral_axis:.3g} m"
            yield "chamber_center", self.chamber_center, expected


@dataclass(frozen=True)
class PiercedSection(CrossSection):
    """A section pierced by the finger's chambers, in place of one chamber of the section; mirrored in y."""

    bores: tuple[Hole, ...] = ()

    @property
    def holes(self) -> tuple[Hole, ...]:
        return self.bores


@dataclass(frozen=True)
class Station(CrossSection):
    """A cross-section between the base and the tip."""

    at: float = field(kw_only=True, metadata=valid(above=0, below=1))  # place, as a share of the finger's length


@np.vectorize
def _twist_stiffness(
    shear_modulus: float,
    width: float,
    thickness: float,
    layer_shear_modulus: float,
    layer_thickness: float,
    layer_center: float,
    *holes: float,
) -> float:
    block = Rectangle(shear_modulus, width, thickness, 0.0)
    hollow = [Rectangle(0.0, w, t, x, abs(y)) for w, t, x, y in zip(*(holes[i::4] for i in range(4)), strict=True)]
    layer = Rectangle(layer_shear_modulus, width, layer_thickness, layer_center)
    return torsional_stiffness((block, *hollow, layer))


class Rectangle(NamedTuple):
    """A part of a section, or two that mirror each other in y."""

    modulus: float  # Pa, of shear
    width: float  # m, along y
    thickness: float  # m, along x
    center: float  # m, x
    side: float = 0.0  # m, of the middle of one of two, y

    @property
    def edges(self) -> tuple[float, float]:
        """Ends along x, m."""
        return self.center - self.thickness / 2, self.center + self.thickness / 2

    @property
    def sides(self) -> tuple[float, float]:
        """Ends along y, m."""
        return self.side - self.width / 2, self.side + self.width / 2


@lru_cache(maxsize=4096)
def torsional_stiffness(parts: tuple[Rectangle, ...]) -> float:
    """G J of a section, N m^2; every part takes the place of those before it, and a hole is one of modulus 0."""
    size = max(parts[0].width, parts[0].thickness)
    x = _grid_lines([edge for part in parts for edge in part.edges], size)
    y = _grid_lines([0.0, *(edge for part in parts for edge in part.sides if edge >= 0)], size)
    modulus, x_middles, y_middles = np.zeros((len(x) - 1, len(y) - 1)), (x[1:] + x[:-1]) / 2, (y[1:] + y[:-1]) / 2
    for part in parts:
        (low, high), (bottom, top) = part.edges, part.sides
        is_inside = (x_middles > low) & (x_middles < high), (y_middles > bottom) & (y_middles < top)
        modulus[np.ix_(*is_inside)] = part.modulus
    i, j = np.nonzero(modulus)
    rigid, stiffness, load = _element_terms(modulus[i, j], x[[i, i + 1]].T, y[[j, j + 1]].T)
    corners = (i[:, None, None] + np.arange(2)[:, None]) * len(y) + j[:, None, None] + np.arange(2)
    return 2 * (rigid - _warping_energy(corners.reshape(-1, 4), stiffness, load, len(y)))


def _grid_lines(edges: Sequence[float], size: float) -> Array:
    """Lines of the grid: all edges and, between each two, places that crowd toward them."""
    grid_edges = size * np.unique(np.round(np.array(edges) / size, _EDGE_DIGITS))
    lines = [grid_edges[:1]]
    for low, high in pairwise(grid_edges):
        count = max(round(_SECTION_ELEMENTS * ((high - low) / size)), _MIN_ELEMENTS_PER_GAP)
        lines.append(low + (high - low) * ((1 - np.cos(np.pi * np.arange(1, count + 1) / count)) / 2))
    return np.concatenate(lines)


def _element_terms(modulus: Array, x: Array, y: Array) -> tuple[float, Array, Array]:
    """Energy without warping, N m^2, of rectangles from x[:, 0] to x[:, 1] and y[:, 0] to y[:, 1].

    Also returns matrix and load of the warping at their corners, (E, 4, 4) and (E, 4).
    """
    a, b = np.diff(x)[:, 0], np.diff(y)[:, 0]
    squares = sum((side**2).sum(axis=1) + side.prod(axis=1) for side in (x, y)) / 3
    stiffness = np.einsum("e,ik,jl->eijkl", modulus * b / a, _SLOPE_PRODUCTS, _HAT_PRODUCTS)
    stiffness += np.einsum("e,ik,jl->eijkl", modulus * a / b, _HAT_PRODUCTS, _SLOPE_PRODUCTS)
    load = np.einsum("e,i,ej->eij", modulus * b, _END_SIGNS, y @ _HAT_PRODUCTS)
    load -= np.einsum("e,ei,j->eij", modulus * a, x @ _HAT_PRODUCTS, _END_SIGNS)
    return float((modulus * a * b) @ squares), stiffness.reshape(-1, 4, 4), load.reshape(-1, 4)


def _warping_energy(corners: NDArray[np.int_], stiffness: Array, load: Array, rows: int) -> float:
    """Energy that warping saves, N m^2; `corners` number the grid points, with `rows` of them along y."""
    from scipy.sparse import coo_array
    from scipy.sparse.linalg import spsolve

    places, nodes = np.unique(np.where(corners % rows, corners, -1), return_inverse=True)
    nodes = nodes.reshape(corners.shape) - 1  # -1: where it does not warp
    unknown_count = len(places) - 1
    indices = [np.broadcast_to(part, stiffness.shape) for part in (nodes[:, :, None], nodes[:, None, :])]
    is_inside = (indices[0] >= 0) & (indices[1] >= 0)
    entries = stiffness[is_inside], (indices[0][is_inside], indices[1][is_inside])
    matrix = coo_array(entries, shape=(unknown_count, unknown_count)).tocsc()
    load_sums = np.bincount(nodes[nodes >= 0], load[nodes >= 0], unknown_count)
    return float(load_sums @ spsolve(matrix, load_sums))
