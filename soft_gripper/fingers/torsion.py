"""Saint-Venant torsion of a section made of rectangles: the moment that twists it by one radian a metre.

A twisted section turns, and warps along the finger by w(x, y) per rate of twist. Of all warpings, the actual one costs
the least energy:

    G J = least over w of  integral of  G ((dw/dx - y)^2 + (dw/dy + x)^2) dA .

Bilinear finite elements on a grid whose lines follow all edges, and crowd toward them, where the stress is steep: 0.1 %
too stiff at most. The section is symmetric in y and w antisymmetric, so half of it is solved, with w = 0 at y = 0. The
package sectionproperties, for sections of any shape, would bring four more packages, one of them a compiled mesher.
"""

from collections.abc import Sequence
from functools import lru_cache
from itertools import pairwise
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from soft_gripper.arrays import Array

_SECTION_ELEMENTS = 48  # about, across the section
_MIN_ELEMENTS_PER_GAP = 4  # between two edges
_EDGE_DIGITS = 9  # decimals of the section's size, by which edges are told apart
# Integrals of products of slopes of two hat functions, on a unit length, and of the hat functions themselves.
_SLOPE_PRODUCTS = np.array([[1.0, -1.0], [-1.0, 1.0]])
_HAT_PRODUCTS = np.array([[2.0, 1.0], [1.0, 2.0]]) / 6
_END_SIGNS = np.array([-1.0, 1.0])


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
